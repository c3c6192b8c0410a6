// Error against time: curves, tables and pictures of each section.
const AXES = { seconds: "seconds", cpu_seconds: "CPU seconds", samples: "samples per pixel" };

// relmse over `axis`, one curve a run.
const plot = (section, axis) => logLogPlot(section.runs.map((run, i) => ({
  points: run.points.map(p => [p[axis], p.relmse]), color: COLORS[i % COLORS.length], isDashed: i >= COLORS.length,
})), AXES[axis], "relmse");

function table(section) {
  const head = element("tr", {}, ...["", "options", "samples", "seconds", "CPU seconds", "MSE", "relmse", "trimmed relmse", "FLIP", "variance", "bias²", "mean / reference"]
    .map(text => element("th", { class: text }, text)));
  const rows = section.runs.map((run, i) => {
    const last = run.points[run.points.length - 1];
    const name = element("td", {}, element("span", { style: `color:${COLORS[i % COLORS.length]}` }, "● "), run.name);
    return element("tr", {}, name, element("td", { class: "options" }, ...run.options.split(/ (?=-)/).flatMap(option => [element("span", { class: "option" }, option), " "])),
      ...[last.samples, last.seconds, last.cpu_seconds, run.mse, run.relmse, run.trimmed_relmse, run.flip, run.variance, run.squared_bias].map(v => element("td", {}, number(v))),
      element("td", {}, run.mean_ratio === null ? "–" : run.mean_ratio.toFixed(4)));
  });
  return element("table", {}, head, ...rows);
}

const figure = (src, alt, ...caption) => element("figure", {}, element("img", { src, alt }), element("figcaption", {}, ...caption));

// Two pictures with a bar between them; the wheel zooms, both alike.
function compare(section) {
  const pictures = [["reference", section.reference_png], ...section.runs.map(run => [run.name, run.png])];
  const width = Math.max(480, Math.min(640, 2 * section.width)), height = width * section.height / section.width;
  const box = element("div", { class: "compare", style: `width:${width}px;height:${height}px` });
  const images = [element("img", { alt: "right picture", draggable: "false" }), element("img", { alt: "left picture", draggable: "false" })];
  const bar = element("div", { class: "bar" });
  box.append(...images, bar);
  let split = 0.5, zoom = 1, originX = 0, originY = 0;
  const draw = () => {
    const transform = `translate(${originX}px,${originY}px) scale(${zoom})`;
    for (const image of images) image.style.transform = transform;
    const at = (split * width - originX) / (width * zoom) * 100;
    images[1].style.clipPath = `inset(0 ${Math.min(100, Math.max(0, 100 - at))}% 0 0)`;
    bar.style.left = `${split * width - 1}px`;
  };
  box.addEventListener("pointermove", event => {
    split = Math.min(1, Math.max(0, (event.clientX - box.getBoundingClientRect().left) / width));
    draw();
  });
  box.addEventListener("wheel", event => {
    event.preventDefault();
    const bounds = box.getBoundingClientRect(), x = event.clientX - bounds.left, y = event.clientY - bounds.top;
    const next = Math.min(32, Math.max(1, zoom * (event.deltaY < 0 ? 1.25 : 0.8)));
    originX = Math.min(0, Math.max(width * (1 - next), x - (x - originX) * next / zoom));
    originY = Math.min(0, Math.max(height * (1 - next), y - (y - originY) * next / zoom));
    zoom = next;
    draw();
  }, { passive: false });
  const selects = [1, 0].map((side, k) => {
    const select = element("select", { "aria-label": k === 0 ? "left" : "right" }, ...pictures.map(([name], i) => element("option", { value: i }, name)));
    select.value = k === 0 ? Math.min(1, pictures.length - 1) : 0;
    select.addEventListener("change", () => { images[side].src = pictures[select.value][1]; });
    images[side].src = pictures[select.value][1];
    return select;
  });
  draw();
  return element("div", {}, element("div", { class: "controls" }, selects[0], "left, right", selects[1], "(move to slide, wheel to zoom)"), box);
}

function pictureStrips(section) {
  const pictures = element("div", { class: "strip" }, ...section.runs.map(run => figure(run.png, `picture by ${run.name}`, run.name)),
    figure(section.reference_png, "reference", "reference"));
  const strip = element("div", { class: "strip" }, ...section.runs.map(run => figure(run.heat_png, `relative error of ${run.name}`, run.name)));
  const ticks = element("div", { class: "ticks" }, ...["0.001", "0.01", "0.1", "1"].map(t => element("span", {}, t)));
  return element("div", {}, element("p", {}, "One seed of each:"), pictures, element("p", {}, "Relative error of each pixel:"), element("div", { class: "scale" }), ticks, strip);
}

function show(section) {
  const axis = element("select", {}, ...Object.entries(AXES).map(([value, text]) => element("option", { value }, text)));
  axis.value = report.axis;
  const holder = element("div", {}, plot(section, axis.value));
  axis.addEventListener("change", () => holder.replaceChildren(plot(section, axis.value)));
  return element("section", {}, element("h2", {}, section.title), element("p", {}, section.text),
    element("p", {}, `${section.scene}, ${section.width} × ${section.height}; expected relmse of the reference itself ${number(section.reference_relmse)}`),
    table(section),
    element("div", { class: "columns" }, element("div", {}, element("div", { class: "controls" }, "relmse over", axis), holder), compare(section)),
    pictureStrips(section));
}

showReport(`Device: ${report.device}. ${report.machine_note}`, report.sections.map(show));
