// How wide each frame's page is, everything unfolded; is handed over once all are there.
window.addEventListener("load", () => {
  const frames = [...document.querySelectorAll("iframe")];
  const outcome = frames.map((frame) => {
    const page = frame.contentDocument.documentElement;
    page.querySelectorAll("details").forEach((details) => { details.open = true; });
    return { name: frame.title, frame: frame.contentWindow.innerWidth, wide: page.scrollWidth, tall: page.scrollHeight };
  });
  hand_over(outcome);
});
