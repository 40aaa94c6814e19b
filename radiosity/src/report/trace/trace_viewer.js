// Viewer of the texels after some shots: each texel in one colour, the shooter outlined, and the numbers of the texel that is
// pointed at.

const SHOOTER_COLOUR = [1, 0.55, 0.1, 1];
const SEEN_COLOUR = [0.35, 0.85, 1, 1];
const FACE_COLOUR = [1, 1, 0.35, 1];
const HIDDEN_COLOUR = [1, 0.25, 0.3, 1];
// Texels that are outlined at most because an item buffer errs there.
const MAX_WRONG_OUTLINES = 400;

class TraceViewer extends OutlineViewer {
  // Shows the state of a solve; `changed` is called when another quantity is displayed.
  attach(trace, changed) {
    const { scene, shape } = this;
    const surface = scene.surface(0);
    const reflectance = new Float32Array(3 * scene.texels);
    for (let k = 0; k < scene.texels; k++) {
      const at = 6 * (scene.by_texel ? k : shape.face_of[k]) + 3;
      reflectance.set(surface.subarray(at, at + 3), 3 * k);
    }
    this.trace = trace;
    this.changed = changed;
    this.state = new ShotState(trace, reflectance);
    this.shown = new Float32Array(3 * scene.texels);
  }

  keys() {
    // Left and right move through the shots.
    const { ArrowLeft, ArrowRight, ...others } = super.keys();
    return others;
  }

  quantities() {
    return ["radiosity", "residual", "change", "visibility", "form_factor", "before", "error"];
  }

  select(what) {
    if (!this.state || (what === "error" && !this.trace.item_buffer)) return;
    this.what = what;
    this.show();
    this.changed();
  }

  // Moves to the state after `n` shots.
  move_to(n) {
    this.state.move_to(n);
    this.show();
  }

  // Writes the displayed quantity of each texel.
  write_shown() {
    const { state, shown, trace, what } = this;
    if (["radiosity", "residual", "error"].includes(what)) return shown.set(state[what]);
    const none = state.done === 0;
    const value = {
      change: (k) => state.change(k),
      before: (k) => state.residual_before(k),
      visibility: (k) => { const { form_factor, share } = trace.link(state.done, k); return Array(3).fill(form_factor > 0 ? share : 0); },
      form_factor: (k) => Array(3).fill(trace.link(state.done, k).form_factor),
    }[what];
    for (let k = 0; k < trace.scene.texels; k++) shown.set(none && what !== "before" ? [0, 0, 0] : value(k), 3 * k);
  }

  fill() {
    if (!this.state) return;
    this.write_shown();
    const { shape, shown, light } = this;
    let v = 0;
    shape.rings.forEach((ring, k) => {
      for (const end = v + 3 * (ring.length + 1); v < end; v += 3) {
        light[v] = shown[3 * k];
        light[v + 1] = shown[3 * k + 1];
        light[v + 2] = shown[3 * k + 2];
      }
    });
  }

  // Ends of the scales are the same at all shots.
  range() {
    if (this.what === "visibility") return 1;
    if (this.what === "error") return this.full_error ??= this.largest_error() || 1;
    if (this.what === "change" && this.trace.relight) return this.full_change ??= this.state.typical_change() || 1;
    return this.what === "form_factor" ? this.trace.largest_form_factor || 1 : this.scene.white;
  }

  mode() {
    if (this.what === "error") return 2;
    // A relight has changes of either sign.
    if (this.trace.relight && ["visibility", "change", "residual", "before"].includes(this.what)) return 2;
    if (this.what === "visibility") return 1;
    if (this.what === "change" || this.what === "form_factor") return 4;
    if (!this.false_colours) return 0;
    return this.what === "radiosity" ? 1 : 4;
  }

  // Returns the largest error of B after the last shot.
  largest_error() {
    const last = new ShotState(this.trace, this.state.reflectance);
    last.move_to(this.trace.shots.length);
    return last.error.reduce((most, error) => Math.max(most, Math.abs(error)), 0);
  }

  quantity_unit() {
    return this.what === "visibility" || this.what === "form_factor" ? "" : super.quantity_unit();
  }

  show() {
    if (!this.state) return;
    super.show();
    this.mark();
  }

  look(x, y) {
    if (!this.state) return;
    super.look(x, y);
    this.mark();
    this.ask();
    this.looked?.();
  }

  // Outlines a face; null outlines none.
  outline_face(face) {
    this.outlined = face;
    this.mark();
    this.ask();
  }

  // Outlines the shooter and the texel that is pointed at, and joins them.
  mark() {
    const { state, trace, seen } = this;
    const lines = [];
    if (state.done > 0) {
      const shooter = trace.patches[trace.shot(state.done).patch];
      lines.push(...outline(shooter.corners, SHOOTER_COLOUR));
      if (seen !== null && !state.cleared.has(seen)) {
        const { form_factor, share } = trace.link(state.done, seen);
        const colour = form_factor > 0 && share !== 0 && (share > 0 || !trace.shot(state.done).is_captured) ? SEEN_COLOUR : HIDDEN_COLOUR;
        lines.push([this.texel_outline(seen).centre, shooter.centre, colour]);
      }
    }
    // Where the errors themselves are displayed, outlines would hide them.
    const wrong = this.what === "error" ? [] : trace.wrong_texels(state.done);
    for (const k of wrong.slice(0, MAX_WRONG_OUTLINES)) lines.push(...outline(this.texel_outline(k).corners, HIDDEN_COLOUR));
    if (seen !== null) lines.push(...outline(this.texel_outline(seen).corners, SEEN_COLOUR));
    if (this.outlined != null) lines.push(...outline(this.face_corners(this.outlined), FACE_COLOUR));
    this.lines.set(this.gl, lines.filter(([from, to]) => length(sub(from, to)) > 0));
  }

  short_patch_name(patch) {
    return `${patch} “${this.scene.names[this.scene.info[4 * this.trace.patches[patch].face + 3]]}”`;
  }

  patch_name(patch) {
    return `patch ${patch} (${this.face_name(this.trace.patches[patch].face)})`;
  }

  // Returns distance and cosines between texel `k` and the shooter's centre.
  geometry(k) {
    const { state, trace } = this;
    const shooter = trace.patches[trace.shot(state.done).patch];
    const texel = this.texel_outline(k);
    const normal = (face) => {
      const [a, b, c, d] = this.face_corners(face);
      return unit(cross(sub(c, a), sub(d, b)));
    };
    const way = sub(texel.centre, shooter.centre);
    const r = length(way);
    const cosine = (face, sign) => (sign * dot(normal(face), way)) / r;
    return {
      r: r * trace.unit,
      shooter_cosine: cosine(shooter.face, 1),
      texel_cosine: cosine(this.shape.face_of[k], -1),
      shooter_area: shooter.area,
      texel_area: texel.area * trace.unit ** 2,
    };
  }

  tell() {
    if (!this.state) return;
    const k = this.seen;
    if (k === null) return super.tell();
    const { state, shape } = this;
    const face = shape.face_of[k];
    const [i, j] = shape.places.subarray(2 * k, 2 * k + 2);
    const rows = [["texel j", `${this.face_name(face)}, texel ${i}, ${j}`]];
    if (state.done > 0) rows.push(...this.shot_rows(k));
    const now = (name) => Array.from(state[name].subarray(3 * k, 3 * k + 3));
    const [radiosity, residual] = [now("radiosity"), now("residual")];
    const before = Array.from(state.before.radiosity.subarray(3 * k, 3 * k + 3));
    const step = (before, after) => (state.done > 0 ? `${three(before)}  →  ${three(after)}` : three(after));
    rows.push(["B", `${step(before, radiosity)}  W/m²`]);
    rows.push(["r", `${step(state.residual_before(k), residual)}  W/m²`]);
    this.write_rows(k, rows);
  }

  // Returns what the latest shot did to texel `k`.
  shot_rows(k) {
    const { state, trace } = this;
    const shot = trace.shot(state.done);
    const rows = [["shooter i", this.patch_name(shot.patch)]];
    if (state.cleared.has(k)) {
      return [...rows, ["r ← 0", "this texel belongs to the shooter: it has shot its residual, and receives nothing from itself"]];
    }
    const { form_factor, share, open, occluder } = trace.link(state.done, k);
    const { r, shooter_cosine, texel_cosine, ...areas } = this.geometry(k);
    rows.push(["r, cosines", `r = ${number(r)} · cos θᵢ = ${number(shooter_cosine)} · cos θⱼ = ${number(texel_cosine)}`]);
    if (form_factor === 0 && shot.is_captured && trace.is_of_room(k)) {
      return [...rows, ["V − V₀ = 0", "the objects hide nothing of the shooter that this texel saw: its captured light stays, ΔB = 0"]];
    }
    if (form_factor === 0) {
      return [...rows, ["F = 0", "one of the two does not face the other: ΔB = 0"]];
    }
    rows.push(["F", `${number(form_factor)}${this.explain_form_factor(form_factor, { r, shooter_cosine, texel_cosine, ...areas })}`]);
    const is_change = shot.is_captured && trace.is_of_room(k);
    const { share_error } = trace.link(state.done, k);
    rows.push([is_change ? "V − V₀" : "V", `${number(share)}: ${is_change ? this.explain_change(share, occluder) : this.explain_share(share, open, occluder)}`]);
    if (share_error !== 0) rows.push(["by rays", `V = ${number(share - share_error)}: the item buffer ${share_error > 0 ? "shows what is hidden" : "hides what is seen"}`]);
    if (open < 1) rows.push(["o", `${number(open)}: the open share of the shooter, from which all its light leaves; a body covers the rest`]);
    const vector = (v) => `(${three(v)})`;
    const rho = Array.from(state.reflectance.subarray(3 * k, 3 * k + 3));
    const factors = [vector(rho), number(form_factor), share < 0 ? `(${number(share)})` : number(share), vector(shot.radiosity)].join(" · ");
    const over = (name) => (open > 0 && open < 1 ? ` / ${name}` : "");
    rows.push(["ΔB = Δr", `ρ · F · ${is_change ? "(V − V₀)" : "V"} · Bᵢ${over("o")} = ${factors}${over(number(open))} = ${vector(state.change(k))}  W/m²`]);
    return rows;
  }

  // Returns the meaning of a share with the objects less the share without them.
  explain_change(share, occluder) {
    if (share > 0) return "the objects cover a part of the shooter that this texel did not see, and the rest shines for it";
    const by = occluder === null ? "the objects" : this.face_name(occluder);
    return `this share of the shooter is now hidden by ${by}: its light is lost`;
  }

  // Returns the meaning of a visible share, and the reasons for which it is below 1.
  explain_share(share, open, occluder) {
    if (share >= 1) return "the shooter is seen whole";
    const reasons = [];
    if (open < 1) reasons.push("covered by a body");
    if (occluder !== null) reasons.push(`hidden by ${this.face_name(occluder)}`);
    const rest = reasons.join(" or ") || "hidden or below the texel’s horizon";
    return share > 0 ? `of the shooter is seen, the rest is ${rest}` : `the shooter is ${rest}`;
  }

  // Returns the formula of a disc with its numbers, which gives the form factor or is near it.
  explain_form_factor(form_factor, { r, shooter_cosine, texel_cosine, shooter_area, texel_area }) {
    if (shooter_cosine <= 0 || texel_cosine <= 0) return ": a part of the shooter is above the texel’s horizon";
    const disc = this.trace.form_factor === "paper" ? texel_area : shooter_area;
    const value = (shooter_area * shooter_cosine * texel_cosine) / (Math.PI * r * r + disc);
    const [a, d] = [shooter_area, disc].map(number);
    const cosines = `${number(shooter_cosine)} · ${number(texel_cosine)}`;
    const name = this.trace.form_factor === "paper" ? "a" : "A";
    const formula = `A cos θᵢ cos θⱼ / (π r² + ${name}) = ${a} · ${cosines} / (π · ${number(r)}² + ${d}) = ${number(value)}`;
    if (Math.abs(value - form_factor) <= 2e-3 * form_factor) return ` ≈ ${formula}`;
    const exact = this.trace.form_factor === "polygon" ? "exact for the polygon" : "mean over the texel";
    return `, ${exact}; at the centre, of a disc: ${formula}`;
  }
}
