// Interactive viewer of a solved scene: WebGL 2, no library. Texel values are the solver's. Light between texels is that
// of report/view/interpolation.rs, whose nodes the page holds.

const VERTEX = `#version 300 es
  in vec3 place; in vec3 light; in float inside; in vec4 number;
  uniform mat4 camera;
  out vec3 value; out float depth; flat out vec4 which;
  void main() {
    gl_Position = camera * vec4(place, 1.0);
    value = light; depth = inside; which = number;
  }`;

// Modes: 0 picture, 1 false colours, 2 signed differences, 3 texel numbers, 4 false colours of the logarithm. The filmic curve is that of report/picture.rs.
const FRAGMENT = `#version 300 es
  precision highp float;
  in vec3 value; in float depth; flat in vec4 which;
  uniform int mode; uniform float gain; uniform float decades; uniform bool grid;
  uniform vec3 rising[9]; uniform vec3 signed_[7];
  out vec4 colour;
  const float S = SHOULDER;
  float shoulder(float x) { return x <= S ? x : 1.0 - (1.0 - S) * exp(-(x - S) / (1.0 - S)); }
  float srgb(float y) { return y <= 0.0031308 ? 12.92 * y : 1.055 * pow(y, 1.0 / 2.4) - 0.055; }
  void main() {
    if (mode == 3) { colour = which; return; }
    vec3 c = gain * value;
    if (mode == 0) {
      c = max(c, 0.0);
      c = vec3(srgb(shoulder(c.r)), srgb(shoulder(c.g)), srgb(shoulder(c.b)));
    } else if (mode == 1 || mode == 4) {
      float y = dot(c, vec3(0.2126, 0.7152, 0.0722));
      if (mode == 4) y = 1.0 + log(max(y, 1e-30)) / (2.302585 * decades);
      float t = 8.0 * clamp(y, 0.0, 1.0);
      int k = min(int(t), 7);
      c = mix(rising[k], rising[k + 1], t - float(k));
    } else {
      float t = 3.0 + 3.0 * clamp(dot(c, vec3(0.2126, 0.7152, 0.0722)), -1.0, 1.0);
      int k = min(int(t), 5);
      c = mix(signed_[k], signed_[k + 1], t - float(k));
    }
    if (grid && depth < 1.3 * fwidth(depth)) c = mix(c, vec3(dot(c, vec3(0.333)) > 0.4 ? 0.0 : 1.0), 0.45);
    colour = vec4(c, 1.0);
  }`;

// Links a program of two shaders; null with the reason in `failed` if the browser refuses.
function link_program(gl, vertex, fragment, failed) {
  const program = gl.createProgram();
  for (const [kind, source] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
    const shader = gl.createShader(kind);
    gl.shaderSource(shader, source);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (gl.getProgramParameter(program, gl.LINK_STATUS)) return program;
  failed(gl.getProgramInfoLog(program));
  return null;
}

// Decades of the logarithmic false colours.
const DECADES = 4;

class Viewer {
  constructor(element) {
    this.element = element;
    this.canvas = element.querySelector("canvas");
    this.told = element.querySelector(".told");
    this.scene = read(element);
    this.shape = build(this.scene);
    this.fan = fans(this.shape, this.scene.under);
    this.light = new Float32Array(3 * this.fan.vertices);
    this.what = "radiosity";
    this.layer = 0;
    this.grid = false;
    this.stops = 0;
    this.seen = null;
    this.lines = new LineDrawer();
    this.home();
    this.controls();
    this.open();
    this.canvas.addEventListener("webglcontextlost", (e) => e.preventDefault());
    this.canvas.addEventListener("webglcontextrestored", () => this.open());
    new ResizeObserver(() => this.ask()).observe(this.canvas);
  }

  open() {
    const gl = this.canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: true });
    this.gl = gl;
    this.refusal = null;
    if (!gl) return this.refuse("This browser has no WebGL 2: preview.png shows the same scene.");
    const program = link_program(gl, VERTEX, FRAGMENT.replace("SHOULDER", this.scene.shoulder.toFixed(6)), (why) => {
      this.refuse(`The picture cannot be drawn: ${why}`);
    });
    if (!program) {
      this.gl = null;
      return;
    }
    gl.useProgram(program);
    this.program = program;
    this.arrays = gl.createVertexArray();
    gl.bindVertexArray(this.arrays);
    this.uniform = (name) => gl.getUniformLocation(program, name);
    const buffer = (name, size, kind, data, normalised = false) => {
      const own = gl.createBuffer();
      gl.bindBuffer(gl.ARRAY_BUFFER, own);
      gl.bufferData(gl.ARRAY_BUFFER, data, gl.STATIC_DRAW);
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, kind, normalised, 0, 0);
      return own;
    };
    buffer("place", 3, gl.FLOAT, this.fan.place);
    buffer("inside", 1, gl.FLOAT, this.fan.inside);
    buffer("number", 4, gl.UNSIGNED_BYTE, this.fan.ids, true);
    this.values = buffer("light", 3, gl.FLOAT, this.light);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, gl.createBuffer());
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, this.fan.index, gl.STATIC_DRAW);
    gl.uniform3fv(this.uniform("rising"), this.scene.rising.flat());
    gl.uniform3fv(this.uniform("signed_"), this.scene.signed.flat());
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.CULL_FACE);
    gl.polygonOffset(1, 1);
    this.lines.open(gl);
    this.show();
  }

  // Gives back what the graphics driver holds: a browser allows few pictures at a time.
  close() {
    cancelAnimationFrame(this.asked);
    this.gl?.getExtension("WEBGL_lose_context")?.loseContext();
    this.gl = null;
  }

  // Says why no picture is drawn; the reason stays.
  refuse(why) {
    this.refusal = why;
    this.told.textContent = why;
  }

  // Returns a texel's own values: B and H of a layer, E and ρ.
  texel(k, layer = this.layer) {
    const { light } = this.scene.layers[layer];
    const s = 6 * (this.scene.by_texel ? k : this.shape.face_of[k]);
    const surface = this.scene.surface(layer);
    const three = (array, at) => Array.from(array.subarray(at, at + 3));
    return {
      radiosity: three(light, 6 * k), irradiance: three(light, 6 * k + 3),
      emission: three(surface, s), reflectance: three(surface, s + 3),
      off: this.scene.off ? this.scene.off[k] : null,
    };
  }

  // Computes vertex values from those of the nodes: B = E + ρH, B = E + (B − E), or B itself.
  fill() {
    const { shape, scene, light } = this;
    const layers = this.what === "difference" ? scene.difference : [this.layer];
    const irradiance = this.what === "irradiance";
    const [with_emission, with_reflectance] = [scene.carried !== "radiosity", scene.carried === "irradiance"];
    const own = new Float32Array(light.length);
    light.fill(0);
    layers.forEach((layer, l) => {
      const sign = l === 0 ? 1 : -1;
      const surface = scene.surface(layer);
      const nodes = scene.nodes(layer, irradiance);
      let first = 0;
      shape.rings.forEach((ring, k) => {
        const s = 6 * (scene.by_texel ? k : shape.face_of[k]);
        mean(own, nodes, ring, shape.corner_of[k], first);
        for (const last = first + ring.length; first <= last; first++) for (let c = 0; c < 3; c++) {
          const e = with_emission && !irradiance ? surface[s + c] : 0;
          const rho = with_reflectance && !irradiance ? surface[s + 3 + c] : 1;
          light[3 * first + c] += this.what === "error" ? scene.off[k] : sign * (e + rho * own[3 * first + c]);
        }
      });
    });
  }

  // Returns the end of the colour range for the displayed quantity.
  range() {
    const { scene } = this;
    if (this.what === "radiosity") return scene.white;
    const all = [];
    const step = Math.max(1, Math.floor(scene.texels / 20000));
    for (let k = 0; k < scene.texels; k += step) {
      if (this.what === "error") all.push(scene.off[k]);
      else if (this.what === "irradiance") all.push(luminance(this.texel(k).irradiance));
      else all.push(Math.abs(luminance(this.texel(k, 1).radiosity) - luminance(this.texel(k, 0).radiosity)));
    }
    all.sort((a, b) => a - b);
    return all[Math.floor(0.98 * (all.length - 1))] || all[all.length - 1] || 1;
  }

  show() {
    if (!this.gl) return;
    this.fill();
    this.full = this.range();
    const gl = this.gl;
    gl.bindBuffer(gl.ARRAY_BUFFER, this.values);
    gl.bufferData(gl.ARRAY_BUFFER, this.light, gl.DYNAMIC_DRAW);
    for (const button of this.element.querySelectorAll("[data-what]")) {
      button.setAttribute("aria-pressed", button.dataset.what === this.what);
    }
    for (const button of this.element.querySelectorAll("[data-layer]")) {
      button.setAttribute("aria-pressed", Number(button.dataset.layer) === this.layer);
    }
    this.legend();
    this.tell();
    this.ask();
  }

  mode() {
    if (this.what === "difference") return 2;
    return this.what === "radiosity" && !this.false_colours ? 0 : 1;
  }

  // Returns the quantities, in the order of their keys.
  quantities() {
    return ["radiosity", "irradiance", "error", "difference"];
  }

  // Returns the unit of the displayed quantity.
  quantity_unit() {
    return "W/m²";
  }

  legend() {
    const legend = this.element.querySelector(".legend");
    const end = this.full / 2 ** this.stops;
    const mode = this.mode();
    legend.hidden = mode === 0;
    const colours = mode === 2 ? this.scene.signed : this.scene.rising;
    const css = colours.map((c) => `rgb(${c.map((x) => Math.round(255 * x)).join()})`).join();
    legend.querySelector(".ramp").style.background = `linear-gradient(to right,${css})`;
    const low = { 2: -end, 4: end / 10 ** DECADES }[mode] ?? 0;
    legend.querySelector(".low").textContent = number(low);
    legend.querySelector(".high").textContent = `${number(end)} ${this.quantity_unit()}`.trim();
    this.element.querySelector(".stops").textContent = `${this.stops > 0 ? "+" : ""}${this.stops} stops`;
  }

  ask() {
    if (this.asked) return;
    this.asked = requestAnimationFrame(() => { this.asked = 0; this.draw(); });
  }

  frame() {
    const away = sub(this.target, this.eye);
    const forward = unit(away);
    const right = unit(cross(forward, this.scene.up));
    return { forward, right, up: cross(right, forward), distance: length(away) };
  }

  camera() {
    const { forward, right, up, distance } = this.frame();
    const { width, height } = this.canvas;
    const near = Math.max(0.002, 0.02 * (distance - 2)), far = distance + 8;
    const f = 1 / Math.tan((this.scene.fov * Math.PI) / 360);
    // A tall canvas has the horizontal field of view of a square one.
    const [x, y] = width < height ? [f, (f * width) / height] : [(f * height) / width, f];
    const [a, b] = [(near + far) / (near - far), (2 * near * far) / (near - far)];
    const view = (n) => [right[n], up[n], -forward[n]];
    const columns = [0, 1, 2].map((n) => { const [r, u, z] = view(n); return [x * r, y * u, a * z, -z]; });
    const [r, u, z] = [-dot(right, this.eye), -dot(up, this.eye), dot(forward, this.eye)];
    return [...columns.flat(), x * r, y * u, a * z + b, -z];
  }

  // Gives the canvas as many pixels as the screen has there; returns these per CSS pixel.
  fit() {
    const { canvas } = this;
    const scale = Math.min(window.devicePixelRatio || 1, 2);
    const [w, h] = [canvas.clientWidth, canvas.clientHeight].map((n) => Math.max(1, Math.round(n * scale)));
    if (canvas.width !== w || canvas.height !== h) [canvas.width, canvas.height] = [w, h];
    return scale;
  }

  draw(mode = this.mode()) {
    const gl = this.gl;
    if (!gl) return;
    const scale = this.fit();
    const [w, h] = [this.canvas.width, this.canvas.height];
    gl.useProgram(this.program);
    gl.bindVertexArray(this.arrays);
    gl.viewport(0, 0, w, h);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const camera = this.camera();
    gl.uniformMatrix4fv(this.uniform("camera"), false, camera);
    gl.uniform1i(this.uniform("mode"), mode);
    gl.uniform1f(this.uniform("gain"), 2 ** this.stops / this.full);
    gl.uniform1f(this.uniform("decades"), DECADES);
    gl.uniform1i(this.uniform("grid"), this.grid ? 1 : 0);
    const { index, behind } = this.fan;
    gl.enable(gl.POLYGON_OFFSET_FILL);
    gl.drawElements(gl.TRIANGLES, behind, gl.UNSIGNED_INT, 0);
    gl.disable(gl.POLYGON_OFFSET_FILL);
    gl.drawElements(gl.TRIANGLES, index.length - behind, gl.UNSIGNED_INT, 4 * behind);
    if (mode !== 3) this.lines.draw(gl, camera, [w, h], scale);
  }

  // Returns the texel at a point of the canvas, −1 for none, by drawing texel numbers off-screen.
  pick(x, y) {
    const gl = this.gl;
    if (!gl) return -1;
    this.fit();
    const [w, h] = [this.canvas.width, this.canvas.height];
    const aside = gl.createFramebuffer();
    const buffers = [[gl.RGBA8, gl.COLOR_ATTACHMENT0], [gl.DEPTH_COMPONENT24, gl.DEPTH_ATTACHMENT]].map(([format, to]) => {
      const own = gl.createRenderbuffer();
      gl.bindRenderbuffer(gl.RENDERBUFFER, own);
      gl.renderbufferStorage(gl.RENDERBUFFER, format, w, h);
      gl.bindFramebuffer(gl.FRAMEBUFFER, aside);
      gl.framebufferRenderbuffer(gl.FRAMEBUFFER, to, gl.RENDERBUFFER, own);
      return own;
    });
    const pixel = new Uint8Array(4);
    const at = [x * w / this.canvas.clientWidth, h - 1 - y * h / this.canvas.clientHeight].map(Math.floor);
    gl.enable(gl.SCISSOR_TEST);
    gl.scissor(at[0], at[1], 1, 1);
    this.draw(3);
    gl.readPixels(at[0], at[1], 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
    gl.disable(gl.SCISSOR_TEST);
    gl.bindFramebuffer(gl.FRAMEBUFFER, null);
    buffers.forEach((own) => gl.deleteRenderbuffer(own));
    gl.deleteFramebuffer(aside);
    return pixel[3] === 0 ? -1 : pixel[0] + (pixel[1] << 8) + (pixel[2] << 16) - 1;
  }

  look(x, y) {
    const found = this.pick(x, y);
    this.seen = found < 0 ? null : found;
    this.tell();
  }

  tell() {
    const k = this.seen;
    if (k === null) {
      this.told.textContent = this.refusal ?? "Point at a texel to read its light.";
      this.told.removeAttribute("data-texel");
      return;
    }
    const face = this.shape.face_of[k];
    const name = this.scene.names[this.scene.info[4 * face + 3]];
    const [i, j] = this.shape.places.subarray(2 * k, 2 * k + 2);
    const own = this.texel(k);
    const rows = [[`face ${face}`, `${name}, texel ${i}, ${j}`]];
    this.scene.layers.forEach(({ name }, layer) => {
      const of = this.scene.layers.length > 1 ? ` ${name}` : "";
      const light = this.texel(k, layer);
      rows.push([`B${of}`, `${three(light.radiosity)}  W/m²`]);
      if (this.scene.irradiance) rows.push([`H${of}`, `${three(light.irradiance)}  W/m²`]);
    });
    rows.push(["ρ", three(own.reflectance)]);
    if (own.emission.some((e) => e !== 0)) rows.push(["E", `${three(own.emission)}  W/m²`]);
    if (this.scene.difference) {
      const [a, b] = this.scene.difference.map((layer) => this.texel(k, layer).radiosity);
      rows.push([this.scene.difference.map((layer) => this.scene.layers[layer].name).join(" − "), `${three(sub(a, b))}  W/m²`]);
    }
    if (own.off !== null) rows.push(["error", `about ${number(own.off)} W/m²`]);
    this.write_rows(k, rows);
  }

  // Writes what is known of texel `k`: a name and its value in each row.
  write_rows(k, rows) {
    this.told.dataset.texel = k;
    this.told.replaceChildren(...rows.map(([term, text]) => {
      const [row, a, b] = ["div", "b", "span"].map((tag) => document.createElement(tag));
      a.textContent = term;
      b.textContent = text;
      row.append(a, " ", b);
      return row;
    }));
  }

  home() {
    [this.eye, this.target] = [this.scene.eye.slice(), this.scene.target.slice()];
    this.ask();
  }

  orbit(dx, dy) {
    const { distance } = this.frame();
    const up = this.scene.up;
    let back = unit(sub(this.eye, this.target));
    const side = unit(cross(up, back));
    const turn = (v, axis, angle) => {
      const [c, s] = [Math.cos(angle), Math.sin(angle)];
      const along = dot(v, axis) * (1 - c);
      return add(add([v[0] * c, v[1] * c, v[2] * c], cross(axis, v), s), axis, along);
    };
    back = turn(back, up, -dx);
    const tilted = turn(back, unit(cross(up, back)), -dy);
    // Stop before the pole.
    if (Math.abs(dot(tilted, up)) < 0.998 && length(side) > 0) back = tilted;
    this.eye = add(this.target, back, distance);
    this.ask();
  }

  pan(dx, dy) {
    const { right, up, distance } = this.frame();
    const step = 2 * distance * Math.tan((this.scene.fov * Math.PI) / 360);
    const by = add(add([0, 0, 0], right, -dx * step), up, dy * step);
    [this.eye, this.target] = [add(this.eye, by), add(this.target, by)];
    this.ask();
  }

  zoom(by) {
    const { distance, forward } = this.frame();
    const to = Math.min(Math.max(distance * by, 0.02), 40);
    this.eye = add(this.target, forward, -to);
    this.ask();
  }

  expose(by) {
    this.stops = Math.min(Math.max(this.stops + by, -12), 12);
    this.element.querySelector("input[type=range]").value = this.stops;
    this.legend();
    this.ask();
  }

  select(what) {
    if (what === "error" && !this.scene.off) return;
    if (what === "irradiance" && !this.scene.irradiance) return;
    if (what === "difference" && !this.scene.difference) return;
    this.what = what;
    this.show();
  }

  // Presses or releases a button, such as that of the texels' outlines.
  toggle(name) {
    this[name] = !this[name];
    const button = this.element.querySelector(`[data-toggle=${name}]`);
    button.setAttribute("aria-pressed", this[name]);
    this.legend();
    this.ask();
  }

  // Returns the action of each key while the picture has the focus.
  keys() {
    const { canvas } = this;
    const turn = (dx, dy) => (e) => (e.shiftKey ? this.pan(-0.3 * dx, -0.3 * dy) : this.orbit(dx, dy));
    const keys = {
      ArrowLeft: turn(-0.1, 0), ArrowRight: turn(0.1, 0), ArrowUp: turn(0, -0.1), ArrowDown: turn(0, 0.1),
      "+": () => this.zoom(0.9), "=": () => this.zoom(0.9), "-": () => this.zoom(1.1),
      "[": () => this.expose(-0.5), "]": () => this.expose(0.5), r: () => this.home(),
      g: () => this.toggle("grid"), f: () => this.toggle("false_colours"),
      Enter: () => this.look(canvas.clientWidth / 2, canvas.clientHeight / 2),
    };
    this.quantities().forEach((what, k) => { keys[k + 1] = () => this.select(what); });
    return keys;
  }

  controls() {
    const { canvas, element } = this;
    const on = (to, kind, act) => to.addEventListener(kind, act);
    element.querySelectorAll("[data-what]").forEach((b) => on(b, "click", () => this.select(b.dataset.what)));
    element.querySelectorAll("[data-layer]").forEach((b) => on(b, "click", () => {
      this.layer = Number(b.dataset.layer);
      if (this.what === "difference") this.what = "radiosity";
      this.show();
    }));
    element.querySelectorAll("[data-toggle]").forEach((b) => on(b, "click", () => this.toggle(b.dataset.toggle)));
    on(element.querySelector(".reset"), "click", () => this.home());
    on(element.querySelector("input[type=range]"), "input", (e) => this.expose(Number(e.target.value) - this.stops));
    const held = new Map();
    let moved = 0;
    const place = (e) => { const r = canvas.getBoundingClientRect(); return [e.clientX - r.left, e.clientY - r.top]; };
    on(canvas, "pointerdown", (e) => {
      held.set(e.pointerId, place(e));
      moved = 0;
      // Synthetic events have no pointer.
      if (e.isTrusted) canvas.setPointerCapture(e.pointerId);
    });
    on(canvas, "pointermove", (e) => {
      const [x, y] = place(e);
      const before = held.get(e.pointerId);
      if (!before) { this.look(x, y); return; }
      const [dx, dy] = [x - before[0], y - before[1]];
      moved += Math.abs(dx) + Math.abs(dy);
      const size = canvas.clientHeight;
      if (held.size === 2) {
        const other = [...held].find(([id]) => id !== e.pointerId)[1];
        const apart = (p) => Math.hypot(p[0] - other[0], p[1] - other[1]) || 1;
        this.zoom(apart(before) / apart([x, y]));
        this.pan(dx / size / 2, dy / size / 2);
      } else if (e.buttons & 6 || e.shiftKey) {
        this.pan(dx / size, dy / size);
      } else {
        this.orbit((4 * dx) / size, (4 * dy) / size);
      }
      held.set(e.pointerId, [x, y]);
    });
    const drop = (e) => { if (held.delete(e.pointerId) && moved < 6) this.look(...place(e)); };
    on(canvas, "pointerup", drop);
    on(canvas, "pointercancel", (e) => held.delete(e.pointerId));
    on(canvas, "contextmenu", (e) => e.preventDefault());
    on(canvas, "wheel", (e) => { e.preventDefault(); this.zoom(Math.exp(0.0012 * e.deltaY)); });
    const keys = this.keys();
    on(canvas, "keydown", (e) => {
      const act = keys[e.key];
      if (!act || e.ctrlKey || e.metaKey || e.altKey) return;
      e.preventDefault();
      act(e);
    });
  }
}
