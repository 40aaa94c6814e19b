// Arrays of a page's scene, and the triangles that a viewer draws of them.

const sub = (a, b) => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
const add = (a, b, s = 1) => [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]];
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const length = (a) => Math.sqrt(dot(a, a));
const unit = (a) => { const l = length(a) || 1; return [a[0] / l, a[1] / l, a[2] / l]; };
const luminance = (c) => 0.2126 * c[0] + 0.7152 * c[1] + 0.0722 * c[2];
// Formats a number with five significant digits.
const number = (x) => (x === 0 ? "0" : Math.abs(x) >= 1e5 || Math.abs(x) < 1e-3 ? x.toExponential(4) : String(Number(x.toPrecision(5))));
const three = (v) => v.map(number).join("  ");

// Decodes a number of 16 bits (IEEE 754).
const from_half = (bits) => {
  const [exponent, rest] = [(bits >> 10) & 31, (bits & 1023) / 1024];
  const size = exponent === 0 ? rest * 2 ** -14 : exponent === 31 ? 0 / 0 : (1 + rest) * 2 ** (exponent - 15);
  return bits & 32768 ? -size : size;
};

// Returns the bytes of an element's text in base 64.
const decode_bytes = (element) => {
  const text = atob(element.textContent.trim());
  const bytes = new Uint8Array(text.length);
  for (let k = 0; k < text.length; k++) bytes[k] = text.charCodeAt(k);
  return bytes;
};

// Reads the page's arrays: corners, resolution, shape and name per face; E and ρ per face or texel; B and H per
// layer and texel, unless the page computes them; error estimates; joined nodes, knots on edges, values of nodes.
function read(element) {
  const head = JSON.parse(element.querySelector(".head").textContent);
  const bytes = decode_bytes(element.querySelector(".data"));
  let at = 0;
  const take = (Kind, count) => { const own = new Kind(bytes.buffer, at, count); at += 4 * count; return own; };
  const scene = { ...head };
  scene.corners = take(Float32Array, 12 * head.faces);
  scene.info = take(Uint32Array, 4 * head.faces);
  const surfaces = [];
  for (let k = 0; k < head.surfaces; k++) surfaces.push(take(Float32Array, 6 * (head.by_texel ? head.texels : head.faces)));
  // Layers with equal reflectance and emission share one surface.
  scene.surface = (layer) => surfaces[Math.min(layer, surfaces.length - 1)];
  scene.layers = head.layers.map((name) => ({ name, light: head.light ? take(Float32Array, 6 * head.texels) : null }));
  scene.off = head.off ? take(Float32Array, head.texels) : null;
  scene.joins = take(Uint32Array, 2 * head.joins);
  scene.knots = take(Uint32Array, 3 * head.knots);
  const halves = new Uint16Array(bytes.buffer, at, head.light ? 3 * head.nodes * head.fields * head.layers.length : 0);
  const values = Float32Array.from(halves, (bits) => head.step * from_half(bits));
  const field = (k) => values.subarray(3 * head.nodes * k, 3 * head.nodes * (k + 1));
  // The carried light of a layer, or its irradiance.
  scene.nodes = (layer, irradiance) => field(head.fields * (layer + 1) - (irradiance ? 1 : head.fields));
  return scene;
}

// Builds the nodes and, around each texel, its ring of nodes from corner to corner.
function build(scene) {
  const { corners, info, faces, texels, joins, knots } = scene;
  let all = 0;
  for (let f = 0; f < faces; f++) all += (info[4 * f] + 1) * (info[4 * f + 1] + 1);
  const earlier = new Map();
  for (let k = 0; k < joins.length; k += 2) earlier.set(joins[k], joins[k + 1]);
  const own = new Uint32Array(all);
  const positions = [];
  const rings = [];
  const face_of = new Uint32Array(texels);
  const places = new Uint32Array(2 * texels);
  let [first, start] = [0, 0];
  for (let f = 0; f < faces; f++) {
    const [w, h, quad] = [info[4 * f], info[4 * f + 1], info[4 * f + 2]];
    const corner = (k) => Array.from(corners.subarray(12 * f + 3 * k, 12 * f + 3 * k + 3));
    const [a, b, c, d] = [0, 1, 2, 3].map(corner);
    for (let j = 0; j <= h; j++) for (let i = 0; i <= (quad ? w : w - j); i++) {
      const at = start + j * (w + 1) + i;
      const known = earlier.get(at);
      if (known !== undefined) {
        own[at] = own[known];
        continue;
      }
      own[at] = positions.length / 3;
      const [u, v] = [i / w, j / h];
      const low = add(a, sub(b, a), u);
      positions.push(...(quad ? add(low, sub(add(d, sub(c, d), u), low), v) : add(low, sub(c, a), v)));
    }
    const texel = (k, i, j, ring) => {
      face_of[k] = f;
      places[2 * k] = i;
      places[2 * k + 1] = j;
      rings[k] = ring.map(([x, y]) => own[start + (j + y) * (w + 1) + i + x]);
    };
    if (quad) {
      for (let j = 0; j < h; j++) for (let i = 0; i < w; i++) {
        texel(first + j * w + i, i, j, [[0, 0], [1, 0], [1, 1], [0, 1]]);
      }
    } else {
      // Rows from edge 0-1 on, upright and inverted triangles alternating.
      let k = first;
      for (let j = 0; j < w; j++) for (let i = 0; i < w - j; i++) {
        texel(k++, i, j, [[0, 0], [1, 0], [0, 1]]);
        if (i + 1 < w - j) texel(k++, i, j, [[1, 0], [1, 1], [0, 1]]);
      }
    }
    first += w * h;
    start += (w + 1) * (h + 1);
  }
  const corner_of = rings.map((ring) => ring.map((n, k) => k));
  // From the last on, so that the places of those before stay.
  for (let k = knots.length - 3; k >= 0; k -= 3) {
    const [texel, after, node] = knots.subarray(k, k + 3);
    rings[texel].splice(after + 1, 0, own[node]);
    corner_of[texel].splice(after + 1, 0, -1);
  }
  return { positions: new Float32Array(positions), rings, corner_of, face_of, places };
}

// Builds the triangles of each texel, between the mean of its corners and its ring. Those of faces that lie `under` others
// come first, as the `behind` first numbers of `index`.
function fans(shape, under) {
  const vertices = shape.rings.reduce((sum, ring) => sum + ring.length + 1, 0);
  const place = new Float32Array(3 * vertices);
  const inside = new Float32Array(vertices);
  const ids = new Uint8Array(4 * vertices);
  const index = new Uint32Array(3 * (vertices - shape.rings.length));
  const covered = new Set(under);
  const is_under = (k) => covered.has(shape.face_of[k]);
  const behind = shape.rings.reduce((sum, ring, k) => sum + (is_under(k) ? 3 * ring.length : 0), 0);
  let v = 0, back = 0, front = behind;
  shape.rings.forEach((ring, k) => {
    let n = is_under(k) ? back : front;
    const [first, middle, id] = [v, v + ring.length, k + 1];
    mean(place, shape.positions, ring, shape.corner_of[k], first);
    inside[middle] = 1;
    for (; v <= middle; v++) {
      ids.set([id & 255, (id >> 8) & 255, (id >> 16) & 255, 255], 4 * v);
      if (v < middle) {
        index.set([middle, v, v + 1 < middle ? v + 1 : first], n);
        n += 3;
      }
    }
    if (is_under(k)) back = n;
    else front = n;
  });
  return { place, inside, ids, index, behind, vertices };
}

// Writes the vectors of a ring, then the mean of its corners, to the vertices from `first` on.
function mean(vertices, vectors, ring, corner_of, first) {
  const middle = 3 * (first + ring.length);
  const corners = corner_of.reduce((sum, corner) => sum + (corner >= 0), 0);
  for (let c = 0; c < 3; c++) vertices[middle + c] = 0;
  ring.forEach((node, r) => {
    for (let c = 0; c < 3; c++) {
      const value = vectors[3 * node + c];
      vertices[3 * (first + r) + c] = value;
      if (corner_of[r] >= 0) vertices[middle + c] += value / corners;
    }
  });
}
