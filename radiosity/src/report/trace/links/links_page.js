// Moves through the steps and their parts, and writes the numbers of the texel that is pointed at.

// Links in the list, those of most light.
const LISTED_LINKS = 12;

const PART_NAMES = { direct: "direct light", coarse: "coarse links", final: "final gather" };

class LinkPage {
  // `links` are those of each step.
  constructor(element, links) {
    this.element = element;
    this.links = links;
    this.steps = [...element.querySelectorAll(".step")];
    this.content = element.querySelector("[data-panel=texel] .content");
    this.position = element.querySelector(".position");
    this.viewers = [];
    this.part = "direct";
  }

  get viewer() {
    return this.viewers[this.step - 1];
  }

  // Shows step `n`, from 1, with the camera and the exposure of the one before.
  go(n) {
    const to = Math.min(Math.max(n, 1), this.steps.length);
    if (to === this.step) return;
    const before = this.viewer;
    const element = this.steps[to - 1];
    this.steps.forEach((step) => { step.hidden = step !== element; });
    if (!this.viewers[to - 1]) {
      const own = element.querySelector(".viewer");
      const viewer = new LinkViewer(own);
      own.viewer = viewer;
      viewer.attach(this.links[to - 1], () => this.tell());
      this.viewers[to - 1] = viewer;
    }
    this.step = to;
    const { viewer } = this;
    if (before) {
      [viewer.eye, viewer.target] = [before.eye, before.target];
      viewer.expose(before.stops - viewer.stops);
    }
    viewer.part = this.part;
    viewer.show();
    // The same place of the picture, or one on the floor at first.
    const [x, y] = this.place ?? [viewer.canvas.clientWidth / 2, 0.8 * viewer.canvas.clientHeight];
    viewer.look(x, y);
    this.write_position();
  }

  // Shows the step and the part that the address names, at first step 1 and direct light.
  go_to_address() {
    const named = new URLSearchParams(location.hash.slice(1));
    const part = GATHERS.includes(named.get("part")) ? named.get("part") : this.part;
    this.part = part;
    this.go(Number(named.get("step")) || this.step || 1);
    if (this.viewer.part !== part) this.show_part(part);
  }

  show_part(part) {
    this.part = part;
    this.viewer.select_part(part);
    this.write_position();
  }

  next_part() {
    this.show_part(GATHERS[(GATHERS.indexOf(this.part) + 1) % GATHERS.length]);
  }

  // Presses the buttons of what is shown, lights its line of the method, and puts it into the address.
  write_position() {
    const { step } = this;
    const { goal } = this.viewer.step;
    this.position.textContent = `step ${step} of ${this.steps.length}, to ${percent(goal)}: ${PART_NAMES[this.part]}`;
    this.element.querySelectorAll("[data-go]").forEach((button) => button.setAttribute("aria-pressed", Number(button.dataset.go) === step));
    this.element.querySelectorAll("[data-show]").forEach((button) => button.setAttribute("aria-pressed", button.dataset.show === this.part));
    this.element.querySelectorAll("[data-line]").forEach((line) => line.classList.toggle("lit", line.dataset.line === this.part));
    history.replaceState(null, "", `#step=${step}&part=${this.part}`);
  }

  // Writes the links of the texel that is pointed at.
  tell() {
    const { viewer, content } = this;
    const { step, seen, receiver, received, part } = viewer;
    if (seen === null) return content.replaceChildren(make("p", {}, ["Point at a texel to see the links over which it received light."]));
    if (receiver === null) return content.replaceChildren(make("p", {}, ["This texel received nothing in this part."]));
    const stored = part === "coarse";
    const is_texel = step.nodes[receiver].texel !== null;
    const whose = {
      direct: "of the light that lamps send",
      coarse: "over which light is carried from bounce to bounce",
      final: "of the last bounce: all light that surfaces reflect",
    }[part];
    const says = [`${received.length} links to ${viewer.node_name(receiver)}, ${whose}.`];
    if (!is_texel) says.push(stored ? " Texels take the light of their coarse node." : " The texels within did not gather: light is linear there, and is interpolated.");
    const weight = received.reduce((sum, { w }) => sum + w, 0);
    const rows = [["Σ w", `${number(weight)}: share of the hemisphere, by cosines, in which sources are seen`]];
    if (!stored) {
      const plain = received.reduce((sum, { w, radiosity }) => add(sum, radiosity, w), [0, 0, 0]);
      const whole = step.irradiance_of(part, receiver);
      rows.push(["Σ w B̄", `${three(plain)}  W/m²`], ["Σ w g·o", `${three(sub(whole, plain))}  W/m²: slopes of the radiosity on the nodes`], ["H", `${three(whole)}  W/m², the sum of both`]);
    }
    const sum = step.light_of(seen);
    if (sum) {
      const whole = viewer.texel(seen).irradiance;
      const rest = sub(sub(whole, sum.direct), sum.final);
      rows.push(["H in all", `${three(whole)}  W/m² = direct light (${three(sum.direct)}) + final gather (${three(sum.final)}) + its corrections and light from outside (${three(rest)})`]);
    }
    const most = received.length > 0 ? received[0].amount : 0;
    const bars = received.slice(0, LISTED_LINKS).map((link) => {
      const bar = make("div", { class: "bar", tabindex: 0 }, [
        make("span", { class: "name" }, [viewer.short_node_name(link.node)]),
        make("span", { class: "track" }, [make("span", { class: "fill", style: `width:${100 * share_of(link.amount, most)}%` })]),
        make("span", { class: "value" }, [stored ? `w ${number(link.w)}` : `${number(link.amount)}`]),
      ]);
      bar.title = `w = F · V = ${number(link.w)}${stored ? "" : `; B̄ = (${three(link.radiosity)}) W/m²; w B̄ = (${three(link.radiosity.map((b) => b * link.w))}) W/m²`}`;
      for (const kind of ["pointerenter", "focus"]) bar.addEventListener(kind, () => viewer.outline_node(link.node));
      for (const kind of ["pointerleave", "blur"]) bar.addEventListener(kind, () => viewer.outline_node(null));
      return bar;
    });
    const more = received.length - bars.length;
    const unit = stored ? "w of each link" : "luminance of w B̄ in W/m²";
    const legend = `${unit}; point at a bar to outline its node${more > 0 ? `; ${more} more links carry less` : ""}.`;
    const table = make("table", {}, [make("tbody", {}, rows.map(([name, text]) => make("tr", {}, [make("td", {}, [make("b", {}, [name])]), make("td", {}, [text])])))]);
    content.replaceChildren(make("p", {}, says), table, ...bars, make("p", { class: "small" }, [legend]));
  }

  listen() {
    const { element } = this;
    const steps = (by) => this.go(this.step + by);
    element.querySelectorAll("[data-go]").forEach((button) => button.addEventListener("click", () => this.go(Number(button.dataset.go))));
    element.querySelectorAll("[data-show]").forEach((button) => button.addEventListener("click", () => this.show_part(button.dataset.show)));
    element.addEventListener("pointermove", (e) => {
      if (!e.target.matches(".viewer canvas") || e.buttons) return;
      const { left, top } = e.target.getBoundingClientRect();
      this.place = [e.clientX - left, e.clientY - top];
    }, true);
    window.addEventListener("hashchange", () => this.go_to_address());
    const acts = { ArrowLeft: () => steps(-1), ArrowRight: () => steps(1), n: () => this.next_part() };
    document.addEventListener("keydown", (e) => {
      const act = acts[e.key];
      if (!act || e.ctrlKey || e.metaKey || e.altKey || e.shiftKey || e.target.matches(".viewer input")) return;
      e.preventDefault();
      act();
    });
  }
}

document.querySelectorAll(".trace.links").forEach(async (element) => {
  try {
    const links = [];
    for (const step of element.querySelectorAll(".step")) links.push(await LinkStep.read(step));
    const page = new LinkPage(element, links);
    page.go_to_address();
    page.listen();
    element.page = page;
    element.dataset.ready = "";
  } catch (error) {
    element.querySelector("[data-panel=texel] .content").textContent = `The links cannot be shown: this page needs a browser of 2023 or later (${error}).`;
  }
});
