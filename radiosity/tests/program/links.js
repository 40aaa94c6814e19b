// Moves through steps and parts and points at texels on the page of a solve to an error; what came of it is handed over.
(async () => {
  const outcome = { moves: [], read: [], failed: null };
  const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  try {
    const element = document.querySelector(".trace.links");
    for (let tries = 0; element.dataset.ready === undefined && tries < 100; tries++) await wait(50);
    const { page } = element;
    const shown = () => element.querySelector(".step:not([hidden])").dataset.step;
    const told = { direct: "that lamps send", coarse: "from bounce to bounce", final: "of the last bounce" };
    const tells = () => Object.keys(told).find((part) => page.content.querySelector("p").textContent.includes(told[part]));
    const moved = (name) => outcome.moves.push([name, page.step, shown(), tells(), element.querySelector(".algorithm .lit").dataset.line]);
    const key = (name) => document.body.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, cancelable: true }));
    moved("start");
    for (const name of ["ArrowRight", "n", "n", "ArrowLeft", "n"]) {
      key(name);
      moved(name);
    }
    element.querySelector(`[data-go="${page.steps.length}"]`).click();
    moved("last step");
    element.querySelector("[data-show=final]").click();
    moved("final");
    outcome.address = location.hash.slice(1).split("&");
    // Points at a lattice of places in both gathers.
    const numbers = (text) => (text.match(/-?\d[\d.e+-]*/g) ?? []).map(Number);
    const row = (name) => [...page.content.querySelectorAll("tr")].find((tr) => tr.querySelector("b").textContent === name)?.lastChild.textContent;
    const { canvas } = page.viewer;
    const { left, top, width, height } = canvas.getBoundingClientRect();
    for (const part of ["direct", "final"]) {
      page.show_part(part);
      for (let j = 1; j < 8; j++) for (let i = 1; i < 8; i++) {
        const place = { clientX: left + (0.2 + 0.075 * i) * width, clientY: top + (j / 8) * height };
        canvas.dispatchEvent(new PointerEvent("pointermove", { pointerId: 7, ...place, bubbles: true }));
        const { viewer } = page;
        if (viewer.seen === null || viewer.receiver === null) continue;
        const { step, received } = viewer;
        outcome.read.push({
          part, texel: viewer.seen, links: received.length, weight: numbers(row("Σ w"))[0],
          mean: numbers(row("Σ w B̄")).slice(0, 3), slopes: numbers(row("Σ w g·o")).slice(0, 3), sum: numbers(row("H")).slice(0, 3),
          whole: numbers(row("H in all") ?? ""), is_leaf: step.nodes[viewer.receiver].texel === viewer.seen,
          weighed: received.reduce((sum, { w }) => sum + w, 0), lines: viewer.lines.segments.length,
          bars: page.content.querySelectorAll(".bar").length,
        });
      }
    }
    const bar = page.content.querySelector(".bar");
    const before = page.viewer.lines.segments.length;
    bar.dispatchEvent(new PointerEvent("pointerenter"));
    outcome.outlined = page.viewer.lines.segments.length - before;
    // The sum of the weights of each spot of each gather, and its texel or none.
    outcome.sums = page.links.map((step) => Object.entries(step.gathers).map(([part, { spots }]) => spots.map(({ node, block }, number) => {
      let sum = 0;
      for (let k = 0; k < block.links; k++) sum += step.weight(part, number, k);
      return [step.nodes[node].texel, sum];
    })));
    outcome.requests = performance.getEntriesByType("resource").length;
  } catch (error) {
    outcome.failed = String(error.stack || error);
  }
  hand_over(outcome);
})();
