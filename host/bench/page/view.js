// A scene seen while it is rendered. The state of the page is all that the server is told; it answers with pictures.
const state = report.state, home = report.home, SIDES = ["a", "b"], TAU = [0.01, 1e5];
const canvases = Object.fromEntries(SIDES.map(side => [side, element("canvas", { id: side, class: "picture", draggable: "false" })]));
const texts = Object.fromEntries(SIDES.map(side => [side, element("output", {})]));
const pictures = {}, status = element("output", { id: "status" });
let orbit = { ...home, target: { ...home.target } }, exposure = report.exposure, split = 0.5;

function draw(side) {
  if (!pictures[side]) return;
  drawPicture(canvases[side], pictures[side], exposure);
  Object.assign(canvases[side].dataset, { samples: pictures[side].samples, number: pictures[side].number });
  const error = pictures[side].error === null ? "" : `, estimated error ${number(pictures[side].error)}`;
  texts[side].textContent = `${pictures[side].samples} samples, ${pictures[side].seconds.toFixed(1)} s${error}`;
}

// One request at a time; what changes meanwhile goes with the next.
let isSending = false, isChanged = false;
async function send() {
  isChanged = true;
  if (isSending) return;
  isSending = true;
  while (isChanged) {
    isChanged = false;
    try {
      const answer = await fetch("state", { method: "POST", body: JSON.stringify(state) });
      if (!answer.ok) status.textContent = await answer.text();
      else document.body.dataset.number = (await answer.json()).number;
    } catch {
      status.textContent = "regulus view has ended.";
    }
  }
  isSending = false;
}

const option = (value, text) => element("option", { value }, text);
const label = (text, input) => element("label", {}, `${text} `, input);
function controls(side) {
  const own = state[side], id = name => `${name}-${side}`;
  const change = (input, apply, type = "change") => input.addEventListener(type, () => { apply(); send(); });
  const techniques = element("select", { id: id("techniques") }, ...report.techniques.map(t => option(t, t)));
  const tau = element("input", { id: id("tau"), type: "range", min: 0, max: 1, step: 0.01, value: Math.log(own.tau / TAU[0]) / Math.log(TAU[1] / TAU[0]) });
  const tauText = element("output", {}), showTau = () => { tauText.textContent = number(own.tau); };
  const regularized = element("input", { id: id("regularized"), type: "checkbox" });
  const view = element("select", { id: id("view") }, option("picture", "picture"), option("denoised", "denoised"),
    option("deviation", "standard deviation"));
  techniques.value = own.techniques;
  regularized.checked = own.is_regularized;
  view.value = own.shown;
  showTau();
  change(techniques, () => { own.techniques = techniques.value; });
  change(tau, () => { own.tau = TAU[0] * (TAU[1] / TAU[0]) ** Number(tau.value); showTau(); }, "input");
  change(regularized, () => { own.is_regularized = regularized.checked; });
  change(view, () => { own.shown = view.value; });
  return element("div", { class: "controls", id: id("controls") }, label("Techniques", techniques), label("Regularized", regularized), label("tau", tau), tauText, label("Show", view), texts[side]);
}

const box = element("div", { class: "compare view", id: "box", style: `width:${report.width}px;height:${report.height}px` }, canvases.a, canvases.b, element("div", { class: "bar" }));
const sliderOf = (id, from, to, step, value, apply) => {
  const slider = element("input", { id, type: "range", min: from, max: to, step, value });
  slider.addEventListener("input", () => apply(Number(slider.value)));
  return slider;
};
function showSplit() {
  const right = state.is_split ? 100 * (1 - split) : 0;
  canvases.b.style.display = box.querySelector(".bar").style.display = state.is_split ? "" : "none";
  canvases.b.style.clipPath = `inset(0 0 0 ${100 - right}%)`;
  box.querySelector(".bar").style.left = `${100 - right}%`;
  bControls.style.display = splitSlider.style.display = state.is_split ? "" : "none";
}

// Drag turns, with shift it shifts, the wheel goes near and far.
function move(apply) {
  apply();
  state.orbit = orbit;
  send();
}
const right = () => [Math.cos(orbit.yaw), 0, -Math.sin(orbit.yaw)];
const up = () => [-Math.sin(orbit.pitch) * Math.sin(orbit.yaw), Math.cos(orbit.pitch), -Math.sin(orbit.pitch) * Math.cos(orbit.yaw)];
box.addEventListener("pointerdown", event => box.setPointerCapture(event.pointerId));
box.addEventListener("pointermove", event => {
  if (event.buttons === 0) return;
  move(() => {
    if (event.shiftKey) {
      const [r, u] = [right(), up()], step = orbit.distance / report.height;
      ["x", "y", "z"].forEach((axis, i) => { orbit.target[axis] += step * (-event.movementX * r[i] + event.movementY * u[i]); });
    } else {
      orbit.yaw -= 0.01 * event.movementX;
      orbit.pitch = Math.max(-1.55, Math.min(1.55, orbit.pitch + 0.01 * event.movementY));
    }
  });
});
box.addEventListener("wheel", event => {
  event.preventDefault();
  move(() => { orbit.distance = Math.max(1e-6, Math.min(1e8, orbit.distance * (event.deltaY < 0 ? 1 / 1.1 : 1.1))); });
}, { passive: false });

const reset = element("button", { id: "reset" }, "The scene's camera");
reset.addEventListener("click", () => {
  orbit = { ...home, target: { ...home.target } };
  state.orbit = null;
  send();
});
const isSplit = element("input", { id: "split", type: "checkbox" });
isSplit.checked = state.is_split;
isSplit.addEventListener("change", () => { state.is_split = isSplit.checked; showSplit(); send(); });
const exposureSlider = sliderOf("exposure", -10, 10, 0.1, exposure, value => { exposure = value; SIDES.forEach(draw); });
const splitSlider = sliderOf("split-at", 0, 1, 0.01, split, value => { split = value; showSplit(); });
const bControls = controls("b");

const events = new EventSource("events");
events.addEventListener("status", event => { status.textContent = JSON.parse(event.data).text; });
events.addEventListener("picture", event => {
  const { side, rgbe, ...about } = JSON.parse(event.data), bytes = atob(rgbe);
  pictures[side] = { ...about, ...decodeFullRange(about.width, about.height, (i, k) => bytes.charCodeAt(4 * i + k)) };
  draw(side);
});

showReport("Drag to turn, with shift to shift, wheel to go near and far.", [element("section", {},
  element("div", { class: "controls" }, label("Exposure", exposureSlider), label("Side by side", isSplit), splitSlider, reset, status),
  controls("a"), bControls, box)]);
showSplit();
