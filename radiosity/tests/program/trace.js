// Steps, scrubs, plays and points on the page of a trace; what came of it is handed over.
(async () => {
  const outcome = { moves: {}, lines: [], lit: [], failed: null };
  const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  try {
    const element = document.querySelector(".trace");
    for (let tries = 0; element.dataset.ready === undefined && tries < 100; tries++) await wait(50);
    const { viewer } = element.querySelector(".viewer");
    const { trace } = viewer;
    const canvas = viewer.canvas;
    const done = (name) => { outcome.moves[name] = viewer.state.done; };
    const key = (name) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, cancelable: true }));
    const click = (name) => element.querySelector(`[data-act=${name}]`).click();
    done("start");
    for (const [name, at] of [["ArrowRight", "right"], ["ArrowRight", "right again"], ["ArrowLeft", "left"], ["End", "end"]]) {
      key(name);
      done(at);
    }
    const vectors = (values) => Array.from({ length: values.length / 3 }, (_, k) => Array.from(values.subarray(3 * k, 3 * k + 3)));
    outcome.last = vectors(viewer.state.radiosity);
    outcome.energy = trace.energy_after(trace.shots.length);
    outcome.emitted = trace.emitted;
    outcome.curve = element.querySelector("[data-panel=curve] p").textContent;
    outcome.change_line = element.querySelector("[data-line=change] button").textContent;
    outcome.shares = { least: Infinity, most: -Infinity };
    for (let n = 1; n <= trace.shots.length; n++) for (let k = 0; k < trace.scene.texels; k++) {
      const { share } = trace.link(n, k);
      outcome.shares.least = Math.min(outcome.shares.least, share);
      outcome.shares.most = Math.max(outcome.shares.most, share);
    }
    key("Home");
    done("home");
    // Reads the numbers of the texels under a lattice of points.
    const numbers = (text) => text.trim().split(/\s+/).map(Number);
    const read_texels = () => {
      const { left, top, width, height } = canvas.getBoundingClientRect();
      const read = [];
      for (let j = 1; j < 8; j++) for (let i = 1; i < 8; i++) {
        const [x, y] = [left + (0.2 + 0.075 * i) * width, top + (j / 8) * height];
        canvas.dispatchEvent(new PointerEvent("pointermove", { pointerId: 7, clientX: x, clientY: y, bubbles: true }));
        const row = [...viewer.told.children].find((line) => line.querySelector("b")?.textContent === "ΔB = Δr");
        const text = row?.querySelector("span").textContent ?? "";
        const parts = /\((.*?)\) · (\S+) · (\S+) · \((.*?)\)(?: \/ (\S+))? = \((.*?)\)/.exec(text);
        const factors = parts && [numbers(parts[1]), Number(parts[2]), Number(parts[3]), numbers(parts[4]), Number(parts[5] ?? 1), numbers(parts[6])];
        const { marked: pixel } = element.page.panels.hemisphere;
        read.push({ texel: viewer.told.dataset.texel, face: viewer.seen === null ? null : viewer.shape.face_of[viewer.seen], factors, pixel });
      }
      return read;
    };
    element.page.go(1);
    outcome.open = trace.patches[trace.shot(1).patch].open;
    outcome.read_first = read_texels();
    // Pixels of the shooter's item buffer: those of texels in the picture, and those under the pointer.
    const { hemisphere } = element.page.panels;
    outcome.shooter = trace.shot(1).patch;
    outcome.ids = Array.from(hemisphere.view.ids);
    outcome.pixels = read_texels().filter(({ pixel }) => pixel);
    outcome.pointed = [];
    const place = hemisphere.canvas.getBoundingClientRect();
    for (let y = 4; y < 64; y += 8) for (let x = 4; x < 64; x += 8) {
      const [clientX, clientY] = [place.left + ((x + 0.5) / 64) * place.width, place.top + ((y + 0.5) / 64) * place.height];
      hemisphere.canvas.dispatchEvent(new PointerEvent("pointermove", { pointerId: 7, clientX, clientY, bubbles: true }));
      outcome.pointed.push({ pixel: [x, y], face: viewer.outlined, lines: viewer.lines.segments.length, says: hemisphere.says.textContent });
    }
    const slider = element.querySelector("input.shot");
    slider.value = 7;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    done("slider");
    click("back");
    done("back");
    click("forward");
    done("forward");
    outcome.read = read_texels();
    // Each line of the algorithm, and the first of the next shot.
    for (let line = 0; line < 7; line++) {
      click("line");
      outcome.lines.push(viewer.what);
      const lit = element.querySelector(".algorithm .lit").textContent;
      outcome.lit.push(["i ←", "V ←", "F ←", "ΔB ←", "B ←", "r ←"].find((sign) => lit.includes(sign)));
    }
    location.hash = "#shot=9";
    await wait(100);
    done("address");
    await wait(500);
    outcome.hash = location.hash;
    key(" ");
    await wait(1500);
    key(" ");
    outcome.played = viewer.state.done;
    outcome.requests = performance.getEntriesByType("resource").length;
  } catch (error) {
    outcome.failed = String(error.stack || error);
  }
  hand_over(outcome);
})();
