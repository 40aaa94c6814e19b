// Hover, orbit, pan, zoom, toggles and keys on the page's viewer; what came of it is handed over.
(async () => {
  const outcome = { hovered: [], vertices: [], drawn: {}, failed: null };
  const wait = () => new Promise((done) => setTimeout(done, 60));
  try {
    const element = document.querySelector(".viewer");
    const viewer = element.open();
    const canvas = element.querySelector("canvas");
    const { left, top, width, height } = canvas.getBoundingClientRect();
    const send = (type, x, y, more = {}) => canvas.dispatchEvent(new PointerEvent(type, {
      pointerId: 7, clientX: left + x * width, clientY: top + y * height, bubbles: true, cancelable: true, ...more,
    }));
    const key = (name, more = {}) => canvas.dispatchEvent(new KeyboardEvent("keydown", { key: name, bubbles: true, cancelable: true, ...more }));
    // A sum over the pixels as they are drawn.
    const drawn = async (name) => {
      await wait();
      viewer.draw();
      const { gl } = viewer;
      const pixels = new Uint8Array(4 * canvas.width * canvas.height);
      gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
      let sum = 2166136261;
      for (const byte of pixels) sum = Math.imul(sum ^ byte, 16777619) >>> 0;
      outcome.drawn[name] = String(sum);
    };
    await drawn("first");
    // Every seventh vertex: its texel, place and light.
    const { place, ids, vertices } = viewer.fan;
    for (let v = 0; v < vertices; v += 7) {
      const texel = ids[4 * v] + (ids[4 * v + 1] << 8) + (ids[4 * v + 2] << 16) - 1;
      outcome.vertices.push([texel, ...place.subarray(3 * v, 3 * v + 3), ...viewer.light.subarray(3 * v, 3 * v + 3)]);
    }
    for (let j = 1; j < 8; j++) for (let i = 1; i < 8; i++) {
      send("pointermove", 0.3 + 0.05 * i, j / 8);
      const told = element.querySelector(".told");
      const texel = told.dataset.texel === undefined ? null : Number(told.dataset.texel);
      const row = [...told.children].find((line) => line.querySelector("b").textContent === "B");
      outcome.hovered.push({ texel, told: row ? row.querySelector("span").textContent.replace("W/m²", "").trim() : "" });
    }
    send("pointerdown", 0.5, 0.5, { buttons: 1 });
    send("pointermove", 0.55, 0.52, { buttons: 1 });
    send("pointerup", 0.55, 0.52);
    await drawn("orbit");
    send("pointerdown", 0.5, 0.5, { buttons: 2 });
    send("pointermove", 0.6, 0.5, { buttons: 2 });
    send("pointerup", 0.6, 0.5);
    await drawn("pan");
    canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -400, bubbles: true, cancelable: true }));
    await drawn("wheel");
    for (const what of ["irradiance", "error"]) {
      element.querySelector(`[data-what=${what}]`).click();
      await drawn(what);
    }
    element.querySelector("[data-what=radiosity]").click();
    for (const what of ["grid", "false_colours"]) {
      element.querySelector(`[data-toggle=${what}]`).click();
      await drawn(what);
    }
    for (const name of ["ArrowLeft", "ArrowUp", "-", "]"]) {
      key(name);
      await drawn(name);
    }
    key("ArrowLeft", { shiftKey: true });
    await drawn("shift");
    key("f");
    key("2");
    await drawn("key 2");
  } catch (error) {
    outcome.failed = String(error.stack || error);
  }
  hand_over(outcome);
})();
