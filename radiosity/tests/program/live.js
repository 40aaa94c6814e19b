// Works the live page in frames, as a reader would; what came of it is handed over.
(async () => {
  const outcome = { scenes: {}, failed: null };
  const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  const open_frame = async (width, address) => {
    const frame = document.createElement("iframe");
    Object.assign(frame, { width, height: 900, src: address });
    document.body.append(frame);
    await new Promise((done) => { frame.onload = done; });
    return frame;
  };
  try {
    const frame = await open_frame(1280, "live.html?scene=facing_plates");
    const page = frame.contentDocument;
    const view = frame.contentWindow;
    const studio = page.querySelector(".studio");
    const until = async (...states) => {
      for (let tries = 0; !states.includes(studio.dataset.state); tries++) {
        if (tries > 2400) throw new Error(`the page stays ${studio.dataset.state}, not ${states}: ${told()}`);
        await wait(50);
      }
    };
    const told = () => studio.querySelector(".outcome").textContent;
    const set = async (name, value, ...states) => {
      const control = studio.querySelector(`[name=${name}]`);
      control.value = value;
      control.dispatchEvent(new view.Event("input", { bubbles: true }));
      if (states.length > 0) {
        await wait(20);
        await until(...states);
      }
    };
    const trace = () => studio.querySelector(".record .trace");
    await until("estimated");
    for (const { value } of [...studio.querySelector("[name=scene]").options]) {
      await set("scene", value, "estimated");
      const { shots, solver } = studio.live.solved;
      outcome.scenes[value] = { shots, solver, checksum: studio.dataset.checksum, told: told() };
    }
    // The record: the last shot is shown, and a step back and a scrub move.
    await set("scene", "cornell_box", "estimated");
    outcome.record = studio.live.solved.html;
    outcome.view = studio.live.solved.view;
    outcome.records = studio.querySelectorAll(".record .trace").length;
    const shots = trace().page.last;
    trace().querySelector("[data-act=back]").click();
    const stepped = trace().page.done;
    const slider = trace().querySelector("input.shot");
    slider.value = 3;
    slider.dispatchEvent(new view.Event("input"));
    const scrubbed = trace().page.done;
    trace().querySelector("[data-act=play]").click();
    await wait(1200);
    outcome.moved = { shots, stepped, scrubbed, played: trace().page.done > 3 };
    trace().querySelector("[data-act=last]").click();
    // A texel that is pointed at tells the light of the last state.
    const { viewer } = trace().page;
    const { width, height } = viewer.canvas.getBoundingClientRect();
    viewer.look(width / 2, 0.8 * height);
    const row = [...viewer.told.children].find((line) => line.querySelector("b").textContent === "B");
    outcome.pointed = { texel: viewer.seen, told: row.querySelector("span").textContent, state: Array.from(viewer.state.radiosity.subarray(3 * viewer.seen, 3 * viewer.seen + 3)) };
    const drawn = () => {
      const { gl, canvas } = trace().page.viewer;
      trace().page.viewer.draw();
      const pixels = new Uint32Array(canvas.width * canvas.height);
      gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(pixels.buffer));
      return new Set(pixels).size;
    };
    outcome.colours = drawn();
    // A lamp is moved and dimmed, a wall painted, and all undone.
    const state = () => ({ checksum: studio.dataset.checksum, power: studio.live.solved.power });
    outcome.first = state();
    const x = studio.querySelector("[name=x]");
    await set("x", x.min, "estimated");
    outcome.lamp_moved = { ...state(), shift: Number(x.value) };
    await set("brightness", -1, "estimated");
    outcome.lamp_dimmed = state();
    await set("surface", studio.querySelector("[name=surface]").options[2].value);
    await set("red", 0, "estimated");
    outcome.wall_painted = state();
    studio.querySelector("[data-do=reset]").click();
    await wait(20);
    await until("estimated");
    outcome.undone = state();
    // The scene is saved with its light: as its file, and, with a lamp that has moved, as its faces.
    const save_scene = async () => {
      const saved = new Promise((done) => { studio.live.save = async (name, blob) => done({ name, bytes: [...new Uint8Array(await blob.arrayBuffer())] }); });
      studio.querySelector("[data-do=glb]").click();
      const { name, bytes } = await saved;
      delete studio.live.save;
      const size = bytes.slice(12, 16).reduceRight((all, byte) => 256 * all + byte, 0);
      return { name, length: bytes.length, json: JSON.parse(new TextDecoder().decode(new Uint8Array(bytes.slice(20, 20 + size)))) };
    };
    outcome.saved = { whole: await save_scene() };
    await set("x", x.min, "estimated");
    outcome.saved.moved = await save_scene();
    studio.querySelector("[data-do=reset]").click();
    await wait(20);
    await until("estimated");
    // The GPU solves the same; a shader that is changed differs, and one that is wrong is refused.
    const verdict = async () => {
      studio.querySelector("[data-do=compare]").click();
      const said = studio.querySelector(".verdict");
      for (let tries = 0; !/agree|disagree/.test(said.className); tries++) {
        if (tries > 2400) throw new Error(`the GPU says nothing: ${said.textContent}`);
        await wait(50);
      }
      const { html, ...compared } = studio.live.compared ?? {};
      return { ...compared, said: said.textContent, tone: said.className, viewers: studio.querySelectorAll(".compared .viewer").length };
    };
    const change_shader = async (name, from, to) => {
      await set("shader", name);
      const text = studio.querySelector(".wgsl");
      if (!text.value.includes(from)) throw new Error(`${name}.wgsl has no ${from}`);
      text.value = text.value.replace(from, to);
    };
    outcome.gpu = { has: !!view.navigator.gpu, as_it_is: await verdict() };
    const plant = async (description, ...states) => {
      const { faults } = studio.live;
      await set("fault", faults.findIndex((fault) => fault.description === description), ...states);
    };
    await plant("half of what is visible is lost");
    outcome.gpu.changed = await verdict();
    await change_shader("select", "if power > best {", "if power < best {");
    outcome.gpu.chosen = await verdict();
    await change_shader("deposit", "fn ", "fnord ");
    outcome.gpu.refused = await verdict();
    await set("shader", "");
    // The GPU solves in the place of the CPU; the CPU does where the GPU fails.
    await set("solver", "gpu", "estimated");
    const { solver, shots: made, power } = studio.live.solved;
    outcome.gpu_solve = { solver, power, shots: made, shown: trace().page.last, told: told(), verdict: await verdict() };
    const { program } = studio.live;
    const { ask } = program;
    program.ask = (act, content, show) => {
      if (act === "solve" && content.request.solver === "gpu") return Promise.reject(new Error("the device is lost"));
      return ask.call(program, act, content, show);
    };
    await set("solver", "gpu", "estimated");
    outcome.gpu_failed = { ...state(), solver: studio.live.solved.solver, told: told() };
    delete program.ask;
    await set("solver", "cpu", "estimated");
    // Every stage beside its twin, on a small scene; with a changed shader its stage is wrong.
    const test_stages = async () => {
      const button = studio.querySelector("[data-do=test]");
      button.click();
      for (let tries = 0; button.disabled; tries++) {
        if (tries > 4800) throw new Error("the test of the stages has no end");
        await wait(50);
      }
      const count = (name) => studio.querySelectorAll(`.stages td.${name}`).length;
      const { report } = studio.live.stage_test;
      return { report, said: studio.querySelector(".hardware .told").textContent, cells: { right: count("agree"), wrong: count("disagree") } };
    };
    await set("scene", "facing_plates", "estimated");
    await set("texels", "4", "estimated");
    outcome.stages = { as_it_is: await test_stages() };
    await change_shader("link", "next.seen += g;", "next.seen += 0.5 * g;");
    outcome.stages.changed = await test_stages();
    await set("shader", "");
    await set("scene", "cornell_box", "estimated");
    // A coarse item buffer errs where rays do not.
    await set("visibility", "paper");
    await set("pixels", "16", "estimated");
    trace().querySelector("[data-what=error]").click();
    outcome.item_buffer = { what: trace().page.viewer.what, wrong: trace().page.viewer.largest_error() };
    await set("visibility", "rays", "estimated");
    // A case of the failure atlas: its method, its exact answer, and what another method makes of it.
    const tell_case = () => {
      const { html, ...solved } = studio.live.solved;
      return { ...solved, exact: studio.live.exact, note: studio.querySelector(".scene-note").textContent, told: told() };
    };
    await set("case", "closeness", "estimated");
    const values = [...studio.querySelector("[name=value]").options].map((option) => Number(option.value));
    const methods = [...studio.querySelector("[name=method]").options].map((option) => option.value);
    const { value: first } = studio.querySelector("[name=method]");
    outcome.cases = { count: studio.live.cases.length, values, methods, first, opened: tell_case() };
    await set("method", "hemisphere", "estimated");
    outcome.cases.hemisphere = tell_case();
    await set("method", "paper", "estimated");
    outcome.cases.paper = tell_case();
    await set("value", "1", "estimated");
    await set("method", "fine", "estimated");
    outcome.cases.fine = tell_case();
    await set("brightness", -1, "estimated");
    outcome.cases.changed = tell_case();
    await set("case", "open", "estimated");
    outcome.cases.dense = tell_case();
    await set("case", "", "estimated");
    outcome.cases.left = { note: studio.querySelector(".scene-note").textContent, hidden: studio.querySelector(".of-case").hidden };
    // A long solve is stopped: its record has the shots so far, the GPU makes as many, and the page goes on.
    await set("texels", "48");
    await set("samples", "16");
    await until("solving");
    await wait(2500);
    const texels = studio.live.program.ask("lightmap", {});
    studio.querySelector("[data-do=stop]").click();
    const last_words = told();
    let frames = 0;
    const count_frame = () => { frames += 1; if (studio.dataset.state === "solving") view.requestAnimationFrame(count_frame); };
    count_frame();
    await until("stopped");
    const { html: partial, ...stopped } = studio.live.solved;
    outcome.stopped = { ...stopped, last_words, frames, shown: trace().page.last, told: told(), energy: trace().querySelector(".trace-panels").textContent };
    outcome.stopped.lightmap = (await texels).length;
    outcome.stopped.gpu = await verdict();
    // What does not answer is ended by a second wish.
    await set("samples", "15");
    await until("solving");
    studio.querySelector("[data-do=stop]").click();
    studio.querySelector("[data-do=stop]").click();
    await until("stopped");
    outcome.ended = { told: told(), lightmap: studio.querySelector("[data-do=lightmap]").disabled };
    await set("samples", "1");
    await set("texels", "8", "estimated");
    outcome.resumed = state();
    // Files are dropped: one without light, and one that is damaged.
    const drop = (files) => {
      const dropped = new view.DataTransfer();
      for (const [name, text] of files) dropped.items.add(new view.File([text], name));
      page.dispatchEvent(new view.DragEvent("drop", { dataTransfer: dropped, bubbles: true, cancelable: true }));
    };
    drop([["tent.obj", "o tent\nv 0 0 0\nv 2 0 0\nv 2 0 2\nv 0 0 2\nv 1 2 1\nf 1 4 3 2\nf 1 2 5\nf 2 3 5\nf 3 4 5\nf 4 1 5\n"]]);
    await wait(20);
    await until("estimated");
    outcome.dropped = { note: studio.querySelector(".scene-note").textContent, lamps: [...studio.querySelector("[name=lamp]").options].map((option) => option.value), told: told() };
    // A panorama lights an open scene from outside; into a closed one nothing comes.
    const panorama = new Uint8Array([...new TextEncoder().encode("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8 +X 16\n"), ...Array(128).fill([128, 128, 128, 129]).flat()]);
    outcome.lit = {};
    for (const scene of ["facing_plates", "furnace"]) {
      await set("scene", scene, "estimated");
      drop([["sky.hdr", panorama]]);
      await wait(20);
      await until("estimated");
      outcome.lit[scene] = { outside: studio.live.solved.outside, note: studio.querySelector(".scene-note").textContent, told: told() };
    }
    studio.querySelector("[data-do=reset]").click();
    await wait(20);
    await until("estimated");
    outcome.lit.reset = studio.live.solved.outside;
    drop([["sky.hdr", "?"]]);
    await wait(20);
    await until("failed");
    outcome.lit.damaged = told();
    drop([["damaged.obj", "v 0 0 0\nv 1 0\n"]]);
    await wait(20);
    await until("failed");
    outcome.damaged = told();
    drop([["picture.xyz", "?"]]);
    await until("failed");
    outcome.unknown = told();
    await set("scene", "furnace", "estimated");
    const phone = await open_frame(390, "live.html?scene=cornell_box");
    const small = phone.contentDocument.querySelector(".studio");
    for (let tries = 0; small.dataset.state !== "estimated" && tries < 1200; tries++) await wait(50);
    outcome.phone = { state: small.dataset.state, wide: phone.contentDocument.documentElement.scrollWidth };
    outcome.desktop = page.documentElement.scrollWidth;
    const loaded = [...view.performance.getEntriesByType("resource")].map(({ name }) => name);
    outcome.elsewhere = loaded.filter((name) => new URL(name).origin !== location.origin && !name.startsWith("blob:"));
  } catch (error) {
    outcome.failed = String(error.stack || error);
  }
  await fetch("outcome", { method: "POST", body: JSON.stringify(outcome) });
})();
