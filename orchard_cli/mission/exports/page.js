// Zoom and drag of the map: it only ever changes the picture's view box.
const svg = document.querySelector(".map svg");
const whole = svg.viewBox.baseVal;
const home = [whole.x, whole.y, whole.width, whole.height];
let view = [...home];
const show = () => svg.setAttribute("viewBox", view.join(" "));
const zoom = (factor, fx = 0.5, fy = 0.5) => {
  const width = Math.min(home[2], Math.max(home[2] / 40, view[2] * factor));
  const height = width * home[3] / home[2];
  view = [view[0] + fx * (view[2] - width), view[1] + fy * (view[3] - height), width, height];
  keep();
};
const keep = () => {
  view[0] = Math.min(home[0] + home[2] - view[2], Math.max(home[0], view[0]));
  view[1] = Math.min(home[1] + home[3] - view[3], Math.max(home[1], view[1]));
  svg.parentElement.style.touchAction = view[2] < home[2] ? "none" : "pan-y";
  show();
};
document.querySelectorAll(".zoom button").forEach((button) => {
  button.addEventListener("click", () => {
    if (button.value === "all") { view = [...home]; keep(); } else zoom(Number(button.value));
  });
});
svg.addEventListener("wheel", (event) => {
  if (!event.ctrlKey && view[2] === home[2]) return;
  event.preventDefault();
  const box = svg.getBoundingClientRect();
  zoom(event.deltaY < 0 ? 0.8 : 1.25,
    (event.clientX - box.left) / box.width, (event.clientY - box.top) / box.height);
}, { passive: false });
let last = null;
svg.addEventListener("pointerdown", (event) => {
  if (view[2] === home[2]) return;
  last = [event.clientX, event.clientY];
  svg.setPointerCapture(event.pointerId);
});
svg.addEventListener("pointermove", (event) => {
  if (!last) return;
  const scale = view[2] / svg.getBoundingClientRect().width;
  view[0] -= (event.clientX - last[0]) * scale;
  view[1] -= (event.clientY - last[1]) * scale;
  last = [event.clientX, event.clientY];
  keep();
});
svg.addEventListener("pointerup", () => { last = null; });
