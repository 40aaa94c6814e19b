// Moves through the shots: slider, buttons, keys, the address.

// Order in which “next line” displays the lines of the algorithm.
const LINE_QUANTITIES = ["before", "visibility", "form_factor", "change", "radiosity", "residual"];
// Milliseconds for which a line is displayed while the algorithm plays line by line.
const LINE_MILLISECONDS = 900;
// Milliseconds between two changes of the address: browsers refuse too many.
const ADDRESS_MILLISECONDS = 200;

class TracePage {
  constructor(element, viewer) {
    this.element = element;
    this.viewer = viewer;
    this.slider = element.querySelector("input.shot");
    this.position = element.querySelector(".position");
    this.speed = element.querySelector(".speed select");
    this.last = viewer.trace.shots.length;
    this.panels = new TracePanels(element, viewer, (n) => this.go(n));
    this.timer = null;
    // Ends the listeners of the whole page.
    this.closing = new AbortController();
    this.listen();
    this.go(this.addressed_shot() ?? 0);
    // Some texel’s numbers are displayed from the start.
    viewer.look(viewer.canvas.clientWidth / 2, 0.8 * viewer.canvas.clientHeight);
  }

  get done() {
    return this.viewer.state.done;
  }

  // Shows the state after `n` shots.
  go(n) {
    const to = Math.min(Math.max(n, 0), this.last);
    this.viewer.move_to(to);
    this.panels.show(to);
    this.slider.value = to;
    this.position.textContent = to === 0 ? `before the first of ${this.last} shots` : `shot ${to} of ${this.last}`;
    this.address ??= setTimeout(() => {
      this.address = null;
      history.replaceState(null, "", `#shot=${this.done}`);
    }, ADDRESS_MILLISECONDS);
  }

  // Returns the shot that the address names, or null.
  addressed_shot() {
    const named = /^#shot=(\d+)$/.exec(location.hash);
    return named ? Number(named[1]) : null;
  }

  // Shows the next line of the algorithm, after the last that of the next shot; returns false at the end.
  next_line() {
    const next = LINE_QUANTITIES[LINE_QUANTITIES.indexOf(this.viewer.what) + 1];
    if (this.done > 0 && next && this.lines_begun) {
      this.viewer.select(next);
      return true;
    }
    if (this.done === this.last) return false;
    this.go(this.done + 1);
    this.viewer.select(LINE_QUANTITIES[0]);
    this.lines_begun = true;
    return true;
  }

  play(on = this.timer === null) {
    clearTimeout(this.timer);
    this.timer = null;
    if (on && this.done === this.last) this.go(0);
    const button = this.element.querySelector("[data-act=play]");
    button.textContent = on ? "⏸ pause" : "▶ play";
    button.setAttribute("aria-label", on ? "Pause (space)" : "Play (space)");
    if (!on) return;
    const tick = () => {
      const by_lines = this.speed.value === "lines";
      const went_on = by_lines ? this.next_line() : this.done < this.last;
      if (!by_lines && went_on) this.go(this.done + 1);
      if (!went_on) return this.play(false);
      this.timer = setTimeout(tick, by_lines ? LINE_MILLISECONDS : 1000 / Number(this.speed.value));
    };
    this.timer = setTimeout(tick, 0);
  }

  listen() {
    const { element, viewer } = this;
    // A step by hand ends playing.
    const step = (to) => { this.play(false); this.lines_begun = false; this.go(to); };
    const acts = {
      first: () => step(0), back: () => step(this.done - 1), forward: () => step(this.done + 1), last: () => step(this.last),
      play: () => this.play(), line: () => { this.play(false); this.next_line(); },
    };
    element.querySelectorAll("[data-act]").forEach((button) => button.addEventListener("click", acts[button.dataset.act]));
    element.querySelectorAll("[data-show]").forEach((button) => button.addEventListener("click", () => viewer.select(button.dataset.show)));
    this.slider.addEventListener("input", () => step(Number(this.slider.value)));
    const { signal } = this.closing;
    window.addEventListener("hashchange", () => step(this.addressed_shot() ?? this.done), { signal });
    const keys = { ArrowLeft: "back", ArrowRight: "forward", Home: "first", End: "last", " ": "play", n: "line" };
    document.addEventListener("keydown", (e) => {
      const act = acts[keys[e.key]];
      if (!act || e.ctrlKey || e.metaKey || e.altKey || e.shiftKey) return;
      // Sliders, lists and buttons have keys of their own.
      if (e.target.matches("select, .viewer input") || (e.key === " " && e.target.matches("button"))) return;
      e.preventDefault();
      act();
    }, { signal });
  }

  // Ends what goes on, before the element is removed.
  close() {
    this.play(false);
    clearTimeout(this.address);
    this.closing.abort();
    this.viewer.close();
  }

  // Marks what the picture displays.
  show_quantity() {
    this.panels.light_lines(this.viewer.what);
  }
}

// Opens the record of an element; returns whether it can be shown.
async function open_trace(element) {
  const own = element.querySelector(".viewer");
  const viewer = new TraceViewer(own);
  own.viewer = viewer;
  viewer.told.textContent = "Unpacking the shots …";
  try {
    const trace = await Trace.read(element, viewer.scene);
    viewer.attach(trace, () => element.page?.show_quantity());
    element.page = new TracePage(element, viewer);
    element.page.show_quantity();
    element.dataset.ready = "";
  } catch (error) {
    viewer.told.textContent = `The shots cannot be shown: this page needs a browser of 2023 or later (${error}).`;
  }
}

document.querySelectorAll(".trace").forEach(open_trace);
