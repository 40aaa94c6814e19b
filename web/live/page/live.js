// The live page: its controls, the worker that solves, and the record of the latest solve.

// A running solve that is no longer wanted may come to its end within this time; a longer one is stopped.
const PATIENCE_MILLISECONDS = 700;
// The worker is ended if it has not received a stop after this time: it receives none within a shot, or while it makes texels.
const STOP_MILLISECONDS = 5000;
// Texels that a scene begins with at most, so that its first solve takes a moment.
const FIRST_TEXELS = 20000;
// Names of files that hold a scene.
const SCENE_NAME = /\.(obj|glb|gltf)$/i;
// Names of files that hold a panorama.
const PANORAMA_NAME = /\.(hdr|exr)$/i;

// Ends a note of the program as a sentence.
const end_sentence = (text) => (text.endsWith(".") ? text : `${text}.`);

// A solve that was ended because another is wanted.
class Ended extends Error {}

// The program in a worker, which is started again after it was ended.
class Program {
  constructor(module) {
    this.module = module;
    this.calls = new Map();
    this.next = 0;
    this.start();
  }

  start() {
    this.worker = new Worker("worker.js", { type: "module" });
    this.worker.onmessage = ({ data }) => this.receive(data);
    this.worker.onerror = (event) => this.fail(new Error(event.message || "the worker cannot be started"));
    this.started = this.call("start", { module: this.module });
    this.opened = null;
  }

  // Stops the running solve, whose answer is then what it has done; ends the worker if that takes longer than `patience`.
  async stop(patience) {
    const timer = setTimeout(() => this.end(), patience);
    await this.call("stop", {}).catch(() => null);
    clearTimeout(timer);
  }

  // Ends what runs; what was opened is opened again when it is needed.
  end() {
    this.worker.terminate();
    this.fail(new Ended());
    this.start();
  }

  fail(error) {
    const calls = [...this.calls.values()];
    this.calls.clear();
    for (const { refuse } of calls) refuse(error);
  }

  call(act, content, show) {
    const call = this.next++;
    return new Promise((accept, refuse) => {
      this.calls.set(call, { accept, refuse, show });
      this.worker.postMessage({ act, call, ...content });
    });
  }

  receive({ call, answer, share, message, broken }) {
    const known = this.calls.get(call);
    if (!known) return;
    if (share !== undefined) return known.show?.(share);
    this.calls.delete(call);
    if (message === undefined) return known.accept(answer);
    if (broken) {
      this.worker.terminate();
      this.start();
    }
    known.refuse(new Error(broken ? `The program failed: ${message}` : message));
  }

  // Opens a scene and returns its description.
  async open(source) {
    this.source = source;
    await this.started;
    this.opened = this.call("open", source);
    return this.opened;
  }

  // Calls the program on the opened scene.
  async ask(act, content, show) {
    await this.started;
    this.opened ??= this.call("open", this.source);
    await this.opened;
    return this.call(act, content, show);
  }
}

class LivePage {
  constructor(element, module) {
    this.element = element;
    this.form = element.querySelector("form");
    this.outcome = element.querySelector(".outcome");
    this.bar = element.querySelector("progress");
    this.record = element.querySelector(".record");
    this.program = new Program(module);
    this.changes = new Map();
    this.cases = [];
    this.own_settings = null;
    this.view = null;
    this.verdict = element.querySelector(".compare .verdict");
    this.stage_test = new StageTest(this);
    this.listen();
    this.list_shaders();
    this.list_cases();
    this.has_gpu = false;
    this.gpu_offered = this.offer_gpu();
    const asked = new URLSearchParams(location.search).get("scene");
    const { scene } = this.form.elements;
    if ([...scene.options].some((option) => option.value === asked)) scene.value = asked;
    this.choose_bundled();
  }

  listen() {
    const { form, element } = this;
    form.addEventListener("submit", (event) => event.preventDefault());
    form.addEventListener("input", ({ target }) => this.react(target));
    const acts = {
      stop: () => this.stop(), compare: () => this.compare(), reset: () => this.reset(), picture: () => this.save_picture(),
      lightmap: () => this.save_answer("lightmap", "lightmap.exr", "image/x-exr"), glb: () => this.save_answer("glb", "radiosity.glb", "model/gltf-binary"),
    };
    for (const [name, act] of Object.entries(acts)) this.button(name).addEventListener("click", act);
    element.querySelector("[name=shader]").addEventListener("input", ({ target }) => this.show_shader(target.value));
    element.querySelector("[name=fault]").addEventListener("input", ({ target }) => this.plant_fault(this.faults[target.value]));
    document.addEventListener("dragover", (event) => { event.preventDefault(); element.classList.add("over"); });
    document.addEventListener("dragleave", (event) => { if (!event.relatedTarget) element.classList.remove("over"); });
    document.addEventListener("drop", (event) => {
      event.preventDefault();
      element.classList.remove("over");
      this.choose_files([...event.dataTransfer.files]);
    });
  }

  button(name) {
    return this.element.querySelector(`[data-do=${name}]`);
  }

  react({ name, files }) {
    const { lamp, surface } = this.form.elements;
    if (name === "scene") return this.choose_bundled();
    if (name === "case") return this.choose_case();
    if (name === "value") return this.open_case();
    if (name === "method") this.set_method();
    if (name === "solver") this.gpu_failure = null;
    if (name === "files") return this.choose_files([...files]);
    if (name === "lamp") return this.show_lamp();
    if (name === "surface") return this.show_surface();
    if (["x", "y", "z", "brightness"].includes(name)) this.change_lamp(lamp.value);
    if (["red", "green", "blue"].includes(name)) this.change_surface(surface.value);
    return this.solve();
  }

  // Offers the GPU where the browser has one. It solves, unless it is one that the CPU stands in for.
  async offer_gpu() {
    // A program that does not start has its failure told elsewhere.
    const adapter = await this.program.started.catch(() => null);
    const { solver } = this.form.elements;
    this.has_gpu = !!adapter;
    solver.querySelector("[value=gpu]").disabled = !adapter;
    if (adapter && !adapter.software) solver.value = "gpu";
  }

  // Fills the list of the cases that are built to break a method.
  async list_cases() {
    await this.program.started;
    this.cases = await this.program.call("cases", {});
    this.form.elements.case.append(...this.cases.map(({ name }) => new Option(name, name)));
  }

  // Returns the case whose scene is chosen; nothing if it is another scene.
  chosen_case() {
    return this.cases.find(({ name }) => name === this.form.elements.case.value);
  }

  // Opens a case in the middle of its values with a method that fails there.
  async choose_case() {
    const { elements } = this.form;
    const chosen = this.chosen_case();
    if (!chosen) return this.choose_bundled();
    const { values, methods, failing_method } = chosen;
    this.own_settings ??= Object.fromEntries(Object.keys(methods[0].settings).map((name) => [name, elements[name].value]));
    elements.value.replaceChildren(...values.map(({ value, text }) => new Option(text, value)));
    elements.value.selectedIndex = Math.floor(values.length / 2);
    elements.method.replaceChildren(...methods.map(({ name }) => new Option(name, name)));
    elements.method.selectedIndex = methods.findIndex(({ name }) => name === failing_method);
    return this.open_case();
  }

  async open_case() {
    const { elements } = this.form;
    this.show_case_controls();
    return this.open({ name: elements.case.value, files: [], value: Number(elements.value.value) });
  }

  // Sets the controls to the settings of the chosen method.
  set_method() {
    const { elements } = this.form;
    const chosen = this.chosen_case()?.methods.find(({ name }) => name === elements.method.value);
    for (const [name, value] of Object.entries(chosen?.settings ?? {})) if (value !== null) elements[name].value = value;
  }

  show_case_controls() {
    for (const label of this.element.querySelectorAll(".of-case")) label.hidden = !this.chosen_case();
  }

  // Returns to scenes of files, with the settings from before the first case.
  leave_case() {
    const { elements } = this.form;
    elements.case.value = "";
    for (const [name, value] of Object.entries(this.own_settings ?? {})) elements[name].value = value;
    this.own_settings = null;
    this.show_case_controls();
  }

  async choose_bundled() {
    this.leave_case();
    const name = this.form.elements.scene.value;
    const files = [".obj", ".mtl"].map(async (end) => {
      const answer = await fetch(`scenes/${name}${end}`);
      if (!answer.ok) throw new Error(`scenes/${name}${end} cannot be loaded`);
      return { name: `${name}${end}`, content: new Uint8Array(await answer.arrayBuffer()) };
    });
    return this.open({ name: `${name}.obj`, files: Promise.all(files) });
  }

  async choose_files(files) {
    const scene = files.find((file) => SCENE_NAME.test(file.name));
    const panorama = files.find((file) => PANORAMA_NAME.test(file.name))?.name;
    if (!scene && !panorama) return this.show_failure("None of these files is a scene or a panorama: give an .obj, a .glb or a .gltf, an .hdr or an .exr.");
    const contents = Promise.all(files.map(async (file) => ({ name: file.name, content: new Uint8Array(await file.arrayBuffer()) })));
    if (scene) {
      this.leave_case();
      return this.open({ name: scene.name, files: contents, panorama });
    }
    const { source } = this;
    const others = async () => [...(await source.files).filter(({ name }) => name !== source.panorama), ...(await contents)];
    return this.open({ ...source, files: others(), panorama });
  }

  // Opens a scene, fills the controls with what it has, and solves it.
  async open(source) {
    this.source = source;
    const turn = (this.turn = (this.turn ?? 0) + 1);
    this.stopping = false;
    this.wanted = false;
    if (this.running) this.program.end();
    this.set_state("opening");
    try {
      const files = await source.files;
      if (turn !== this.turn) return;
      const scene = await this.program.open({ ...source, files });
      if (turn !== this.turn) return;
      this.scene = scene;
    } catch (error) {
      if (turn === this.turn && !(error instanceof Ended)) this.show_failure(error.message);
      return;
    }
    await this.gpu_offered;
    if (turn !== this.turn) return;
    this.changes.clear();
    this.view = null;
    this.fill_controls();
    await this.solve();
  }

  fill_controls() {
    const { form, scene } = this;
    const fill = (select, groups) => {
      select.replaceChildren(...groups.map(({ name }) => new Option(name || "(no name)", name)));
      select.closest("fieldset").disabled = groups.length === 0;
    };
    const lamps = scene.groups.filter(({ power }) => power > 0);
    fill(form.elements.lamp, lamps);
    fill(form.elements.surface, scene.groups.filter(({ power }) => power === 0));
    const most = Math.sqrt(FIRST_TEXELS / scene.faces);
    form.elements.texels.value = Math.min(8, Math.max(1, Math.floor(most)));
    form.elements.patches.value = scene.faces > 200 ? 1 : 2;
    const chosen = this.chosen_case();
    if (chosen) {
      form.elements.texels.value = scene.texels;
      this.set_method();
    }
    const note = this.element.querySelector(".scene-note");
    const weakness = chosen ? [`Built to break: ${chosen.weakness}.`] : [];
    note.textContent = [`${scene.name}: ${scene.faces} ${scene.faces === 1 ? "face" : "faces"}.`, ...weakness, ...scene.notes.map(end_sentence)].join(" ");
    this.show_lamp();
    this.show_surface();
  }

  group(name) {
    return this.scene.groups.find((group) => group.name === name);
  }

  change(name) {
    return this.changes.get(name) ?? { name };
  }

  // Sets the lamp's sliders: it stays within the box of the scene.
  show_lamp() {
    const { elements } = this.form;
    const lamp = this.group(elements.lamp.value);
    if (!lamp) return;
    const { shift = [0, 0, 0], emission_factor = 1 } = this.change(lamp.name);
    ["x", "y", "z"].forEach((axis, k) => {
      const [low, high] = [0, 1].map((end) => this.scene.bounds[end][k] - lamp.bounds[end][k]);
      Object.assign(elements[axis], { min: low, max: high, step: "any" });
      elements[axis].value = shift[k];
    });
    elements.brightness.value = Math.log2(emission_factor);
  }

  show_surface() {
    const { elements } = this.form;
    const surface = this.group(elements.surface.value);
    if (!surface) return;
    const { reflectance = surface.reflectance } = this.change(surface.name);
    ["red", "green", "blue"].forEach((channel, k) => { elements[channel].value = reflectance[k]; });
  }

  change_lamp(name) {
    if (!this.group(name)) return;
    const { elements } = this.form;
    const shift = ["x", "y", "z"].map((axis) => Number(elements[axis].value));
    this.changes.set(name, { ...this.change(name), shift, emission_factor: 2 ** Number(elements.brightness.value) });
  }

  change_surface(name) {
    if (!this.group(name)) return;
    const { elements } = this.form;
    const reflectance = ["red", "green", "blue"].map((channel) => Number(elements[channel].value));
    this.changes.set(name, { ...this.change(name), reflectance });
  }

  // Undoes the changes of lamps and surfaces, and takes a panorama away.
  reset() {
    if (this.source.panorama) return this.open({ ...this.source, panorama: undefined });
    this.changes.clear();
    this.show_lamp();
    this.show_surface();
    return this.solve();
  }

  request() {
    const { elements } = this.form;
    const number = (name) => Number(elements[name].value);
    return {
      solver: elements.solver.value, texels: number("texels"), patches: number("patches"), samples: number("samples"),
      visibility: elements.visibility.value, pixels: number("pixels"), form_factor: elements.form_factor.value,
      epsilon: number("epsilon"), changes: [...this.changes.values()], view: this.view,
    };
  }

  // Solves what the controls say; while a solve runs, the latest wish waits.
  async solve() {
    if (!this.scene) return;
    this.wanted = true;
    if (this.running) {
      if (performance.now() - this.begun > PATIENCE_MILLISECONDS) this.program.stop(PATIENCE_MILLISECONDS);
      return;
    }
    this.running = true;
    while (this.wanted) {
      this.wanted = false;
      this.begun = performance.now();
      await this.solve_once().catch((error) => {
        if (!(error instanceof Ended)) this.fall_back(error.message);
        else if (this.stopping) this.show_end();
      });
      this.stopping = false;
    }
    this.running = false;
    this.button("stop").disabled = true;
    this.bar.value = 1;
  }

  // After a failure of the GPU the CPU solves; after one of the CPU nothing does.
  fall_back(message) {
    const { solver } = this.form.elements;
    if (solver.value !== "gpu") return this.show_failure(message);
    solver.value = "cpu";
    this.gpu_failure = message;
    this.wanted = true;
  }

  async solve_once() {
    this.set_state("solving");
    if (!this.solved) this.outcome.textContent = "Solving …";
    this.button("stop").disabled = false;
    const show = (share) => { this.bar.value = share; };
    const solve = await this.program.ask("solve", { request: this.request() }, show);
    this.view = solve.view;
    await this.show_record(solve.html);
    this.solved = solve;
    this.tell("");
    for (const name of ["reset", "picture", "lightmap", "glb"]) this.button(name).disabled = false;
    this.element.dataset.checksum = solve.checksum;
    this.set_state(solve.stopped ? "stopped" : "solved");
    for (const name of ["compare", "test"]) this.button(name).disabled = !this.has_gpu;
    this.stage_test.forget();
    this.forget_comparison(this.has_gpu ? "" : "This browser has no GPU with WebGPU, so only the CPU runs here.");
    if (this.wanted || solve.stopped) return;
    const answer = await this.tell_exact();
    if (answer) this.tell(answer);
    const error = await this.program.ask("estimate", {});
    this.tell(`${answer}${error === null ? "" : ` Estimated error: ${percent(error)}.`}`);
    this.set_state("estimated");
  }

  // Returns the solve of a case beside its exact answer, in words; nothing of other scenes.
  async tell_exact() {
    const chosen = this.chosen_case();
    if (!chosen) return "";
    const exact = await this.program.ask("exact", {});
    this.exact = exact;
    if (!exact && (this.changes.size > 0 || this.source.panorama)) return " Of a changed scene no exact answer is known.";
    if (!exact) return ` No exact answer is known: the atlas compares with ${chosen.truth}.`;
    const light = (mean) => `${number(Number(mean.toPrecision(4)))} W/m²`;
    return ` Exact answer (${chosen.truth}): B − E is ${light(exact.exact)} in the mean, and ${light(exact.found)} was found. Error ` +
      `(${exact.measure}): ${exact.error}; the atlas’s verdict: ${exact.verdict}.`;
  }

  // Says what ran and what came out.
  tell(end) {
    const { shots, stopped, seconds, power, outside, checksum, solver, adapter } = this.solved;
    const by = { cpu: "CPU, in WebAssembly with one thread", gpu: `GPU (${adapter}), by WebGPU` }[solver];
    const failure = this.gpu_failure ? `The GPU failed: ${end_sentence(this.gpu_failure)} ` : "";
    const share = (part) => percent(share_of(part, power.emitted));
    const light = outside ? ` From outside come ${watts(outside)}.` : " No light comes in from outside: the scene is closed.";
    const start = stopped ? `Stopped after ${shots} ${shots === 1 ? "shot" : "shots"}, ${share(power.unshot)} unshot. ` : "";
    this.outcome.textContent =
      `${failure}${start}${by}: ${shots} ${shots === 1 ? "shot" : "shots"} in ${number(Number(seconds.toPrecision(3)))} s. Of ${watts(power.emitted)} emitted, ${share(power.absorbed)} is absorbed, ` +
      `${share(power.escaped)} has escaped, ${share(power.unshot)} is unshot; closure (what the form factors lose) ${share(power.closure)}.` +
      `${outside === null ? "" : light}${end} Checksum of B, r and H: ${checksum}.`;
  }

  // Puts a record into the place of the one before, which stays until it can be drawn, with the same view of it.
  async show_record(html) {
    const coming = make("div", { class: "coming" });
    coming.innerHTML = html;
    this.record.append(coming);
    const next = coming.querySelector(".trace");
    await open_trace(next);
    const before = this.record.querySelector(".trace").page;
    const after = next.page;
    after?.go(after.last);
    if (before !== after) {
      if (this.shown_scene === this.scene) this.keep_view(before, after);
      before.close();
    }
    this.shown_scene = this.scene;
    for (const other of [...this.record.children]) if (other !== coming) other.remove();
    coming.className = "";
  }

  // Shows the new record as the one before: camera, exposure, shot, quantity.
  keep_view(before, next) {
    const [old, own] = [before.viewer, next.viewer];
    Object.assign(own, { eye: old.eye, target: old.target, seen: old.seen });
    for (const name of ["grid", "false_colours"]) if (old[name]) own.toggle(name);
    own.expose(old.stops);
    if (own.seen !== null && own.seen >= own.scene.texels) own.seen = null;
    next.go(before.done === before.last ? next.last : before.done);
    own.select(old.what);
    next.speed.value = before.speed.value;
  }

  // Fills the lists of the shaders that a reader can change, and of the faults.
  async list_shaders() {
    await this.program.started;
    this.shaders = await this.program.call("shaders", {});
    this.element.querySelector("[name=shader]").append(...this.shaders.map(({ name }) => new Option(`${name}.wgsl`, name)));
    this.faults = await this.program.call("faults", {});
    this.element.querySelector("[name=fault]").append(...this.faults.map(({ description }, number) => new Option(description, number)));
  }

  show_shader(name) {
    const text = this.element.querySelector(".wgsl");
    const shader = this.shaders.find((own) => own.name === name);
    text.hidden = !shader;
    text.value = shader?.text ?? "";
    this.element.querySelector("[name=fault]").value = "";
  }

  // Plants a fault in its shader; without one the shaders are as they were. A visibility that does not run it is changed.
  plant_fault(fault) {
    const { elements } = this.form;
    const chosen = this.element.querySelector("[name=fault]").value;
    this.element.querySelector("[name=shader]").value = fault?.file ?? "";
    this.show_shader(fault?.file ?? "");
    this.element.querySelector("[name=fault]").value = chosen;
    if (!fault) return;
    const text = this.element.querySelector(".wgsl");
    text.value = text.value.replace(fault.from, fault.to);
    if (fault.visibility && (fault.visibility === "rays") !== (elements.visibility.value === "rays")) {
      elements.visibility.value = fault.visibility;
      this.solve();
    }
  }

  // Returns the shader that the reader has changed, as a list.
  changed_shaders() {
    const { value: name } = this.element.querySelector("[name=shader]");
    const { value: text } = this.element.querySelector(".wgsl");
    return this.shaders.some((own) => own.name === name && own.text !== text) ? [{ name, text }] : [];
  }

  // Solves on the GPU, and on the CPU if it has not solved this yet, and shows both and their difference.
  async compare() {
    const solved = this.solved;
    this.forget_comparison("The GPU solves …");
    try {
      const compared = await this.program.ask("compare", { shaders: this.changed_shaders() });
      if (solved !== this.solved) return;
      this.show_comparison(compared);
    } catch (error) {
      if (!(error instanceof Ended)) this.say_verdict("disagree", `The GPU has no answer: ${error.message}`);
    }
  }

  show_comparison(compared) {
    const { adapter, shots, seconds, difference, agrees, wrong_stage, power, first_other_shooter, html } = compared;
    const stage = agrees ? "" : ` ${wrong_stage ? `The first stage that differs from its twin: ${wrong_stage}` : "No stage differs from its twin on the same input"}.`;
    const share = (part) => percent(share_of(part, power.emitted));
    this.say_verdict(agrees ? "agree" : "disagree",
      `${agrees ? "Agree" : "Differ"}: B of the GPU (${adapter}) and of the CPU differ by ${percent(difference)} (RMS). The GPU made ${shots} shots in ` +
      `${number(Number(seconds.toPrecision(3)))} s, shaders compiled; ` +
      `${first_other_shooter === null ? "the shooters are the same" : `shot ${first_other_shooter + 1} is of another shooter`}. ` +
      `Of the emitted power ${share(power.absorbed)} is absorbed, ${share(power.escaped)} has escaped; closure (what the form factors lose) ${share(power.closure)}.${stage}`);
    const place = this.element.querySelector(".compared");
    place.innerHTML = html;
    const own = place.querySelector(".viewer");
    own.viewer = new Viewer(own);
    own.viewer.select("difference");
    this.compared = compared;
  }

  say_verdict(tone, text) {
    this.verdict.className = `verdict ${tone}`;
    this.verdict.hidden = text === "";
    this.verdict.textContent = text;
  }

  // Removes a comparison that is of an earlier solve; says `text` instead.
  forget_comparison(text) {
    const place = this.element.querySelector(".compared");
    place.querySelector(".viewer")?.viewer?.close();
    place.replaceChildren();
    this.compared = null;
    this.say_verdict("", text);
  }

  // Stops the solve: the record is then that of the shots so far. What cannot stop is ended, and so is it by a second wish.
  stop() {
    this.wanted = false;
    const is_shooting = this.element.dataset.state === "solving" && !this.stopping;
    this.stopping = true;
    if (!is_shooting) return this.program.end();
    this.outcome.textContent = "Stopping after this shot …";
    return this.program.stop(STOP_MILLISECONDS);
  }

  // Says that the worker was ended, with all that it had solved.
  show_end() {
    this.set_state("stopped");
    for (const name of ["lightmap", "glb", "compare"]) this.button(name).disabled = true;
    this.outcome.textContent = this.solved ? "Ended: the record is that of the solve before." : "Ended.";
  }

  show_failure(message) {
    this.set_state("failed");
    this.outcome.textContent = message;
  }

  set_state(state) {
    this.element.dataset.state = state;
  }

  save_picture() {
    const { canvas } = this.record.querySelector(".viewer").viewer;
    canvas.toBlob((blob) => this.save("radiosity.png", blob), "image/png");
  }

  // Saves the file that the program makes of the latest solve.
  async save_answer(act, name, type) {
    try {
      this.save(name, new Blob([await this.program.ask(act, {})], { type }));
    } catch (error) {
      if (!(error instanceof Ended)) this.show_failure(error.message);
    }
  }

  save(name, blob) {
    const link = make("a", { href: URL.createObjectURL(blob), download: name });
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }
}

// Compiles the program once; every worker gets it.
async function compile_program() {
  const answer = await fetch("program_bg.wasm");
  if (!answer.ok) throw new Error("program_bg.wasm cannot be loaded");
  return WebAssembly.compile(await answer.arrayBuffer());
}

document.querySelectorAll(".studio").forEach(async (element) => {
  try {
    element.live = new LivePage(element, await compile_program());
  } catch (error) {
    element.dataset.state = "failed";
    element.querySelector(".outcome").textContent = `The page cannot run: ${error.message} It needs a web server, and a browser of 2023 or later.`;
  }
});
