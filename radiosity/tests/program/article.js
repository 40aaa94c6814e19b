// Opens every figure of the article in its frame, and follows a link into two of them; what came of it is handed over.
window.addEventListener("load", async () => {
  const outcome = { pages: [], figures: [], followed: [], requests: [], failed: null };
  const wait = (milliseconds) => new Promise((done) => setTimeout(done, milliseconds));
  // What a window loaded that is no file of the site.
  const requests = (view) => view.performance.getEntriesByType("resource").map(({ name }) => name).filter((name) => !name.startsWith("file:"));
  try {
    const pages = [...document.querySelectorAll("iframe")];
    const [article] = pages.map((frame) => frame.contentDocument);
    const figures = [...article.querySelectorAll("iframe")];
    const opened = figures.map((figure) => new URL(figure.src).hash);
    figures.forEach((figure) => { figure.loading = "eager"; });
    const ready = (figure) => figure.contentDocument.querySelector(".trace")?.dataset.ready !== undefined;
    for (let tries = 0; !figures.every(ready) && tries < 300; tries++) await wait(50);
    await wait(500);
    figures.forEach((figure, k) => {
      const view = figure.contentWindow;
      const root = figure.contentDocument.documentElement;
      const { viewer } = figure.contentDocument.querySelector(".step:not([hidden]) .viewer, .trace:not(.links) .viewer");
      viewer.draw();
      const { gl, canvas } = viewer;
      const pixels = new Uint32Array(canvas.width * canvas.height);
      gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(pixels.buffer));
      const panels = [...root.querySelectorAll(".panel .content")].map((panel) => panel.textContent.length);
      outcome.figures.push({
        name: figure.name, ready: ready(figure), colours: new Set(pixels).size, panels: Math.max(...panels), frame: view.innerWidth, wide: root.scrollWidth,
        opened: opened[k], address: view.location.hash,
      });
      outcome.requests.push(...requests(view));
    });
    pages.forEach((frame) => {
      const root = frame.contentDocument.documentElement;
      root.querySelectorAll("details").forEach((details) => { details.open = true; });
      outcome.pages.push({ wide: root.scrollWidth, tall: root.scrollHeight });
      outcome.requests.push(...requests(frame.contentWindow));
    });
    const follow = async (name, place) => {
      article.querySelector(`a[target=${name}][href$="${place}"]`).click();
      await wait(500);
      return figures.find((figure) => figure.name === name).contentDocument.querySelector(".trace").page;
    };
    outcome.followed.push((await follow("furnace", "shot=6")).done, (await follow("links", "part=coarse")).part);
  } catch (error) {
    outcome.failed = String(error.stack || error);
  }
  hand_over(outcome);
});
