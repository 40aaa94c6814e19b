// Figures beside the picture: the choice of the shooter, the energy, the unshot power.

const ENERGY_PARTS = ["absorbed", "unshot", "escaped", "closure"];
// Share of the unshot power below which the curve is not drawn.
const MIN_CURVE_SHARE = 1e-6;
const CURVE = { width: 400, height: 150, left: 44, right: 8, top: 8, bottom: 22 };

class TracePanels {
  // `seek` moves to a shot.
  constructor(element, viewer, seek) {
    const content = (name) => element.querySelector(`[data-panel=${name}] .content`);
    [this.choice, this.energy, this.curve] = ["choice", "energy", "curve"].map(content);
    this.viewer = viewer;
    this.trace = viewer.trace;
    this.lines = [...element.querySelectorAll("[data-line]")];
    this.draw_curve(seek);
    this.hemisphere = new HemispherePanel(content("hemisphere"), viewer);
    viewer.looked = () => this.hemisphere.point_at(null);
  }

  // Shows the figures after `n` shots.
  show(n) {
    this.show_choice(n);
    if (this.trace.relight) this.show_change();
    else this.show_energy(n);
    this.hemisphere.point_at(null);
    this.show_cursor(n);
  }

  // Lights the lines of the algorithm whose effect is displayed.
  light_lines(quantity) {
    for (const line of this.lines) {
      const is_lit = line.dataset.line === quantity;
      line.classList.toggle("lit", is_lit);
      line.querySelector("button")?.setAttribute("aria-pressed", is_lit);
    }
  }

  show_choice(n) {
    const { trace, viewer } = this;
    const next = n === 0;
    const shot = trace.shot(next ? 1 : n);
    if (!shot) {
      this.choice.replaceChildren(trace.unshot > 0 ? "No shot was made." : "The scene is dark: nothing is to be shot.");
      return;
    }
    const [first, second] = shot.ranking;
    const all = trace.unshot_after(next ? 0 : n - 1);
    const name = viewer.patch_name(first.patch);
    const kind = trace.relight === null ? "unshot power" : shot.is_captured ? "captured light that is not yet shot" : "unshot change";
    // A relight begins to shoot its change when no captured light is left.
    const begins = trace.relight !== null && n > 1 && shot.is_captured !== trace.shot(n - 1).is_captured;
    const share = begins ? "" : `, ${percent(first.power / all)} of all that is unshot`;
    const most = `the most ${kind} of all patches: ${watts(first.power)}${share}`;
    const says = [next ? `${name} shoots first. It has ${most}.` : `Shot ${n}: ${name} had ${most}.`];
    if (second) {
      says.push(` Runner-up: ${viewer.patch_name(second.patch)}, ${watts(second.power)}${second.power === first.power ? " as well; of equals the lowest number shoots" : `, ${percent(second.power / first.power)} of that`}.`);
    }
    const bars = shot.ranking.map(({ patch, power }, rank) => make("div", { class: rank === 0 ? "bar shooter" : "bar" }, [
      make("span", { class: "name" }, [viewer.short_patch_name(patch)]),
      make("span", { class: "track" }, [make("span", { class: "fill", style: `width:${(100 * power) / first.power}%` })]),
      make("span", { class: "value" }, [watts(power)]),
    ]));
    this.choice.replaceChildren(make("p", {}, says), ...bars);
  }

  show_energy(n) {
    const parts = this.trace.energy_after(n);
    const whole = this.trace.emitted;
    const all = Math.max(whole, parts.reduce((sum, part) => sum + Math.max(0, part), 0));
    const widths = parts.map((part) => share_of(Math.max(0, part), all));
    const bar = make("div", { class: "energy-bar", role: "img", "aria-label": "Shares of the emitted power" }, widths.map((width, k) => (
      make("span", { class: ENERGY_PARTS[k], style: `width:${100 * width}%`, title: ENERGY_PARTS[k] })
    )));
    const rows = parts.map((part, k) => make("tr", { "data-part": ENERGY_PARTS[k] }, [
      make("td", {}, [make("span", { class: `swatch ${ENERGY_PARTS[k]}` }), ` ${ENERGY_PARTS[k]}`]),
      make("td", { class: "n" }, [watts(part)]),
      make("td", { class: "n" }, [percent(share_of(part, whole))]),
    ]));
    const says = `Of ${watts(whole)} emitted, if the file’s unit of length is the metre. Escaped: it met no front. Closure: the form factors’ error, below 0 if they made light.`;
    this.energy.replaceChildren(bar, make("table", {}, [make("tbody", {}, rows)]), make("p", { class: "small" }, [says]));
  }

  // Shows what the texels have gained and lost since before the first shot of a relight.
  show_change() {
    const { trace, viewer } = this;
    this.areas ??= Array.from({ length: trace.scene.texels }, (_, k) => viewer.texel_outline(k).area * trace.unit ** 2);
    const [gained, lost] = viewer.state.gain_and_loss(this.areas);
    const all = Math.max(gained + lost, Number.MIN_VALUE);
    const parts = [["gained", "unshot", gained], ["lost", "escaped", lost]];
    const bar = make("div", { class: "energy-bar", role: "img", "aria-label": "Power that texels gain and lose" }, parts.map(([name, look, power]) => (
      make("span", { class: look, style: `width:${(100 * power) / all}%`, title: name })
    )));
    const rows = parts.map(([name, look, power]) => make("tr", { "data-part": name }, [
      make("td", {}, [make("span", { class: `swatch ${look}` }), ` ${name}`]),
      make("td", { class: "n" }, [watts(power)]),
    ]));
    const says = "Σ |ΔB| A of the texels that became brighter since before the first shot, the objects’ among them, and of those that became darker.";
    this.energy.replaceChildren(bar, make("table", {}, [make("tbody", {}, rows)]), make("p", { class: "small" }, [says]));
  }

  draw_curve(seek) {
    const { trace } = this;
    const { width, height, left, right, top, bottom } = CURVE;
    const shots = trace.shots.length;
    const share = (n) => Math.max(share_of(trace.unshot_after(n), trace.unshot), MIN_CURVE_SHARE);
    const shares = Array.from({ length: shots + 1 }, (_, n) => share(n));
    const lowest = Math.min(trace.epsilon, ...shares) / 1.3;
    this.x = (n) => left + ((width - left - right) * n) / Math.max(1, shots);
    this.y = (value) => top + (height - top - bottom) * (Math.log(Math.min(value, 1)) / Math.log(lowest));
    const line = (x1, y1, x2, y2, name) => make("svg:line", { x1, y1, x2, y2, class: name });
    const text = (x, y, anchor, says) => make("svg:text", { x, y, "text-anchor": anchor }, [says]);
    const marks = [];
    for (let value = 1; value >= lowest; value /= 10) {
      marks.push(line(left, this.y(value), width - right, this.y(value), "grid"), text(left - 5, this.y(value) + 4, "end", percent(value)));
    }
    marks.push(text(left, height - 6, "start", "0"), text(width - right, height - 6, "end", `${shots} shots`));
    if (trace.epsilon >= lowest) marks.push(line(left, this.y(trace.epsilon), width - right, this.y(trace.epsilon), "threshold"));
    const points = shares.map((value, n) => `${this.x(n).toFixed(2)},${this.y(value).toFixed(2)}`).join(" ");
    this.cursor = line(0, top, 0, height - bottom, "cursor");
    this.dot = make("svg:circle", { r: 4, class: "dot" });
    this.says = make("p", { class: "small" });
    const svg = make("svg:svg", { viewBox: `0 0 ${width} ${height}`, role: "img", "aria-label": "Unshot power after each shot" }, [
      ...marks, make("svg:polyline", { points, class: "curve" }), this.cursor, this.dot,
    ]);
    const pick = (e) => {
      if (e.type === "pointermove" && e.buttons === 0) return;
      const { left: start, width: wide } = svg.getBoundingClientRect();
      seek(Math.round(((((e.clientX - start) / wide) * width - left) / (width - left - right)) * shots));
    };
    svg.addEventListener("pointerdown", pick);
    svg.addEventListener("pointermove", pick);
    this.curve.replaceChildren(svg, this.says);
  }

  show_cursor(n) {
    const { trace } = this;
    const share = share_of(trace.unshot_after(n), trace.unshot);
    const [x, y] = [this.x(n), this.y(Math.max(share, MIN_CURVE_SHARE))];
    this.cursor.setAttribute("x1", x);
    this.cursor.setAttribute("x2", x);
    this.dot.setAttribute("cx", x);
    this.dot.setAttribute("cy", y);
    this.says.textContent = `${percent(share)} of ${trace.relight ? "the captured power" : "the power that was unshot at the start"} is unshot; ${trace.end}.`;
  }
}
