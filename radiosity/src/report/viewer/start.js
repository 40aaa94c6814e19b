// Each viewer is opened when it first becomes visible.
const watch = new IntersectionObserver((entries) => {
  for (const { target, isIntersecting } of entries) {
    if (!isIntersecting) continue;
    watch.unobserve(target);
    target.open();
  }
});
document.querySelectorAll(".viewer").forEach((element) => {
  element.open = () => (element.viewer ??= new Viewer(element));
  watch.observe(element);
});
