// Steps, scrubs, plays and points on the page of a trace; what came of it goes into #outcome.
(async () => {
  const outcome = { moves: {}, lines: [], lit: [], read: [], failed: null };
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
    key("Home");
    done("home");
    const slider = element.querySelector("input.shot");
    slider.value = 7;
    slider.dispatchEvent(new Event("input", { bubbles: true }));
    done("slider");
    click("back");
    done("back");
    click("forward");
    done("forward");
    // The numbers of the texels under a lattice of points.
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const numbers = (text) => text.trim().split(/\s+/).map(Number);
    for (let j = 1; j < 8; j++) for (let i = 1; i < 8; i++) {
      const [x, y] = [left + (0.2 + 0.075 * i) * width, top + (j / 8) * height];
      canvas.dispatchEvent(new PointerEvent("pointermove", { pointerId: 7, clientX: x, clientY: y, bubbles: true }));
      const row = [...viewer.told.children].find((line) => line.querySelector("b")?.textContent === "ΔB = Δr");
      const text = row?.querySelector("span").textContent ?? "";
      const parts = /\((.*?)\) · (\S+) · (\S+) · \((.*?)\) = \((.*?)\)/.exec(text);
      const factors = parts && [numbers(parts[1]), Number(parts[2]), Number(parts[3]), numbers(parts[4]), numbers(parts[5])];
      outcome.read.push({ texel: viewer.told.dataset.texel, factors });
    }
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
  const told = document.createElement("pre");
  told.id = "outcome";
  told.textContent = JSON.stringify(outcome).replace(/</g, "");
  document.body.append(told);
})();
