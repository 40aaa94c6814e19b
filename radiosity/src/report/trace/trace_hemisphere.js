// What the shooter sees: its item buffer, each face in a colour of its own. A pixel that is pointed at and its face in the
// picture are outlined together, and so are a texel that is pointed at and its pixel.

// Pixels of the canvas for each pixel of the item buffer.
const HEMISPHERE_SCALE = 6;
// Half width of the mark of a pixel, in pixels of the canvas.
const MARK_RADIUS = 7;

// Places on the square −1…1 of a direction in the shooter's frame, by projection.
const PROJECTIONS = {
  hemisphere: ([x, y]) => [x, y],
  paper: ([x, y]) => [x, y],
  stereographic: ([x, y, z]) => [x / (1 + z), y / (1 + z)],
  hemicube: ([x, y, z]) => {
    const side = Math.max(Math.abs(x), Math.abs(y));
    if (z >= side) return [x / (2 * z), y / (2 * z)];
    const down = 1 - z / (2 * side);
    return Math.abs(x) >= Math.abs(y) ? [Math.sign(x) * down, y / (2 * side)] : [x / (2 * side), Math.sign(y) * down];
  },
};

// Returns a colour for a face: neighbouring numbers are far apart on the wheel.
function face_colour(face, is_lit) {
  return `hsl(${(face * 137.508) % 360} ${is_lit ? 90 : 45}% ${is_lit ? 70 : 38 + 8 * (face % 3)}%)`;
}

class HemispherePanel {
  constructor(content, viewer) {
    this.viewer = viewer;
    this.trace = viewer.trace;
    const size = this.trace.hemisphere.size;
    this.canvas = make("canvas", { width: HEMISPHERE_SCALE * size, height: HEMISPHERE_SCALE * size, role: "img", "aria-label": "What the shooter sees" });
    this.says = make("p", { class: "small" });
    content.replaceChildren(this.canvas, this.says);
    const point = (e) => {
      const { left, top, width, height } = this.canvas.getBoundingClientRect();
      const pixel = [((e.clientX - left) / width) * size, ((e.clientY - top) / height) * size].map(Math.floor);
      this.point_at(pixel.every((x) => x >= 0 && x < size) ? pixel : null);
    };
    this.canvas.addEventListener("pointermove", point);
    this.canvas.addEventListener("pointerdown", point);
    // A finger leaves with each tap.
    this.canvas.addEventListener("pointerleave", (e) => { if (e.pointerType === "mouse") this.point_at(null); });
    this.pixel = null;
  }

  // Returns the item buffer of the latest shooter; none before the first shot.
  get view() {
    const { state } = this.viewer;
    return state.done > 0 ? this.trace.hemispheres[this.trace.shot(state.done).shooter] : null;
  }

  // Returns the face in a pixel; null if there is none.
  face_at([x, y]) {
    const id = this.view ? this.view.ids[y * this.trace.hemisphere.size + x] : 0;
    return id > 0 ? id - 1 : null;
  }

  // Points at a pixel, whose face is outlined in the picture; null points at none.
  point_at(pixel) {
    this.pixel = pixel;
    this.viewer.outline_face(pixel && this.face_at(pixel));
    this.draw();
  }

  // Returns the pixel of texel `k`; null if it lies below the shooter's horizon.
  pixel_of(k) {
    const { frame } = this.view;
    const away = sub(this.viewer.texel_outline(k).centre, frame[0]);
    const local = unit([dot(frame[1], away), dot(frame[2], away), dot(frame[3], away)]);
    if (local[2] <= 0) return null;
    const { size, projection } = this.trace.hemisphere;
    const [x, y] = PROJECTIONS[projection](local);
    return [(x * 0.5 + 0.5) * size, (0.5 - y * 0.5) * size].map((p) => Math.min(Math.max(Math.floor(p), 0), size - 1));
  }

  // Shows the item buffer after a shot or a movement of the pointer.
  draw() {
    const { canvas, viewer, view } = this;
    const pen = canvas.getContext("2d");
    canvas.hidden = !view;
    this.marked = null;
    if (!view) {
      this.says.textContent = "Nothing has shot yet.";
      return;
    }
    if (!pen) return;
    const { size, projection } = this.trace.hemisphere;
    const lit = this.pixel && this.face_at(this.pixel);
    pen.clearRect(0, 0, canvas.width, canvas.height);
    for (let y = 0; y < size; y++) for (let x = 0; x < size; x++) {
      const face = this.face_at([x, y]);
      if (face === null) continue;
      pen.fillStyle = face_colour(face, face === lit);
      pen.fillRect(HEMISPHERE_SCALE * x, HEMISPHERE_SCALE * y, HEMISPHERE_SCALE, HEMISPHERE_SCALE);
    }
    // Pixels of texels for which rays find another visible share.
    const wrong = this.trace.wrong_texels(viewer.state.done).map((k) => this.pixel_of(k)).filter((pixel) => pixel);
    pen.strokeStyle = "#ff404d";
    pen.lineWidth = 2;
    for (const [x, y] of wrong) pen.strokeRect(HEMISPHERE_SCALE * x, HEMISPHERE_SCALE * y, HEMISPHERE_SCALE, HEMISPHERE_SCALE);
    if (viewer.seen !== null && !this.pixel) this.marked = this.pixel_of(viewer.seen);
    const mark = this.pixel ?? this.marked;
    if (mark) {
      const [x, y] = mark.map((p) => HEMISPHERE_SCALE * (p + 0.5));
      for (const [colour, width] of [["#000", 5], ["#fff", 2.5]]) {
        pen.strokeStyle = colour;
        pen.lineWidth = width;
        pen.strokeRect(x - MARK_RADIUS, y - MARK_RADIUS, 2 * MARK_RADIUS, 2 * MARK_RADIUS);
      }
    }
    const face = mark && this.face_at(mark);
    const there = !mark ? "Point at a pixel to outline its face." : face === null ? "This pixel has no face." : `This pixel has ${viewer.face_name(face)}.`;
    const areas = projection === "hemisphere" ? ", whose areas are form factors" : "";
    this.says.textContent = `${size} × ${size} pixels, ${projection} projection${areas}. ${there}`;
  }
}
