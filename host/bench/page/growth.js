// Time and memory over size: plots and exponents of each sweep.
const QUANTITIES = [["render", "render_seconds", `${report.seconds} of rendering`], ["prepare", "prepare_seconds", `${report.seconds} of preparing`],
  ["memory", "device_bytes", "bytes of the device"]];

const exponentText = fit => `${fit.exponent.toFixed(2)} ± ${fit.deviation.toFixed(2)}, last ${fit.last.toFixed(2)}`;

function show(sweep) {
  const head = element("tr", {}, ...[sweep.name, ...QUANTITIES.map(([, , text]) => text)].map(text => element("th", {}, text)));
  const rows = sweep.points.map(p => element("tr", {}, element("td", {}, number(p.size)), ...QUANTITIES.map(([, key]) => element("td", {}, number(p[key])))));
  const exponents = element("tr", {}, element("th", {}, "exponent"), ...QUANTITIES.map(([fit]) => element("td", { class: "exponent" }, exponentText(sweep[fit]))));
  const plots = QUANTITIES.map(([fit, key, text], i) => element("figure", {},
    logLogPlot([{ points: sweep.points.map(p => [p.size, p[key]]), color: COLORS[i] }], sweep.name, text), element("figcaption", {}, exponentText(sweep[fit]))));
  return element("section", {}, element("h2", {}, sweep.name), element("p", {}, `${sweep.text}. n log n has exponent ${sweep.n_log_n.toFixed(2)} between the last two sizes.`),
    element("table", {}, head, ...rows, exponents), element("div", { class: "strip" }, ...plots));
}

showReport(`Device: ${report.device}. Exponents of c n^k by least squares over all sizes, with their standard error, and between the last two sizes.`,
  report.sweeps.map(show));
