// Errors above this are no number any more; below the other they are exact in double precision.
const MOST = 10, LEAST = 1e-20;
const clipped = v => v === null ? MOST : Math.min(MOST, v <= 0 ? LEAST : Math.max(LEAST, v));

const DEVICE = COLORS[0], REFERENCE = COLORS[2], BOUND = COLORS[1];

const curvesOf = sweep => [
  { points: sweep.points.map(p => [p.parameter, clipped(p.bound)]), color: BOUND, isDashed: true, hasDots: false },
  { points: sweep.points.map(p => [p.parameter, clipped(p.reference)]), color: REFERENCE },
  { points: sweep.points.map(p => [p.parameter, clipped(p.device)]), color: DEVICE },
];

const dot = (color, text) => [element("span", { style: `color:${color}` }, "● "), text];

function table(sweeps) {
  const bounds = [...new Set(sweeps.map(s => s.bound_source))];
  const letter = s => String.fromCharCode(97 + bounds.indexOf(s.bound_source));
  const head = element("tr", {}, ...["", "cases", ["device", DEVICE], "of its bound", ["reference", REFERENCE], "of its bound",
    "device within 1 %", "not finite", "lost", "bound"]
    .map(text => element("th", {}, ...(Array.isArray(text) ? dot(text[1], text[0]) : [text]))));
  const rows = sweeps.map(s => {
    const broken = s.holds ? "" : "font-weight:bold;color:" + BOUND;
    const range = s.accurate === null ? "nowhere" : `${number(s.accurate[0])} … ${number(s.accurate[1])}`;
    return element("tr", { style: broken, title: s.worst_case }, element("td", {}, s.name), element("td", {}, String(s.cases)),
      ...[s.device, s.device_ratio, s.reference, s.reference_ratio].map(v => element("td", {}, number(v))),
      element("td", {}, range), element("td", {}, `${s.non_finite_device} + ${s.non_finite_reference}`),
      element("td", {}, String(s.lost)), element("td", {}, letter(s)));
  });
  return element("div", {}, element("table", {}, head, ...rows),
    ...bounds.map((text, i) => element("p", {}, `Bound ${String.fromCharCode(97 + i)}: ${text}.`)));
}

function show(family) {
  const sweeps = report.sweeps.filter(s => s.family === family);
  const plots = sweeps.map(s => element("figure", {}, logLogPlot(curvesOf(s), s.parameter, "relative error"),
    element("figcaption", {}, s.name)));
  return element("section", {}, element("h2", {}, family), table(sweeps), element("div", { class: "strip" }, ...plots));
}

showReport(`Device: ${report.device} (${report.driver}), ${report.extent} run. Largest relative error at each parameter: ` +
  "of the device in single precision (blue), of the reference in double precision (green), and the device's bound (dashed). " +
  "Columns: largest errors and what share of the bound they take, worst case; where the device stays within 1 %. " +
  "A row's worst case is its tooltip.",
  [...new Set(report.sweeps.map(s => s.family))].map(show));
