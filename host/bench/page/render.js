// What a render did: its picture, what was chosen and why, what it took, how its error fell.
const s = report.statistics;
const cells = (...texts) => element("tr", {}, ...texts.map(text => element("td", {}, text)));
const table = (...rows) => element("table", {}, ...rows);
const section = (title, ...content) => element("section", {}, element("h2", {}, title), ...content);
const shownValue = value => value === null || value === undefined ? "–" : typeof value === "number" && !Number.isInteger(value) ? number(value) :
  Array.isArray(value) ? value.join(", ") || "none" : typeof value === "object" ? JSON.stringify(value) : String(value);
const bytes = count => count >= 2 ** 30 ? `${(count / 2 ** 30).toFixed(2)} GiB` : `${(count / 2 ** 20).toFixed(1)} MiB`;
const whole = value => Number(value).toLocaleString("en");

function pictureSection() {
  const canvas = element("canvas", { id: "picture", class: "picture" });
  const slider = element("input", { id: "exposure", type: "range", min: -10, max: 10, step: 0.1, value: report.exposure });
  const text = element("output", {});
  const image = element("img", { alt: "" });
  image.addEventListener("load", () => {
    const picture = decodePicture(image);
    canvas.style.width = `${Math.max(picture.width, 480)}px`;
    const draw = () => {
      drawPicture(canvas, picture, Number(slider.value));
      text.textContent = `${Number(slider.value).toFixed(1)} stops`;
    };
    slider.addEventListener("input", draw);
    draw();
  });
  image.src = report.picture;
  const aovs = report.aovs.map(aov => element("figure", {}, element("img", { src: aov.png, alt: aov.name }), element("figcaption", {}, `${aov.name}: ${aov.text}`)));
  return section("Picture", element("p", {}, report.summary), element("div", { class: "controls" }, element("label", {}, "Exposure ", slider), text), canvas,
    ...(report.reduction > 1 ? [element("p", {}, `Shown at one pixel in ${report.reduction} each way.`)] : []),
    ...(aovs.length ? [element("div", { class: "strip" }, ...aovs)] : []));
}

function choiceSection() {
  const settings = s.settings;
  if (!settings) return section("Settings", table(...Object.entries(s).map(([name, value]) => cells(name, shownValue(value)))));
  const rows = [["techniques", settings.techniques.join(", "), settings.techniques_rule],
    ["regularization", settings.regularization, settings.regularization === "none" ? "" : `tau ${shownValue(settings.tau)}, ${settings.tau_schedule}`],
    ["light sampling", settings.light_sampling, `${s.scene.lights} light${s.scene.lights === 1 ? "" : "s"}`],
    ["guided camera walks", settings.walk_guide === "off" ? "off" : "on", settings.walk_guide_rule],
    ["guided emission", settings.light_guide === "off" ? "off" : "on", settings.light_guide_rule],
    ["merge radius", settings.merge_radius > 0 ? `${number(settings.merge_radius)} m` : "none", settings.merge_radius_rule],
    ["rays by", s.rays.by, ""]];
  const content = [table(...rows.map(([what, value, why]) => element("tr", {}, element("td", {}, what), element("td", { class: "text" }, value), element("td", { class: "text" }, why))))];
  if (report.candidates.length) {
    const least = report.candidates[0].relative_squared_error * report.candidates[0].cost;
    content.push(element("p", {}, "Among these, of one sample of every pixel each:"), table(
      element("tr", {}, ...["techniques", "regularized", "squared error", "cost", "error at equal time"].map(text => element("th", {}, text))),
      ...report.candidates.map(c => cells(c.techniques, c.regularized ? "yes" : "no", number(c.relative_squared_error), number(c.cost),
        least > 0 && c.relative_squared_error !== null ? number(c.relative_squared_error * c.cost / least) : "–"))));
  }
  if (s.dropped.length) content.push(element("p", {}, "Asked for and not done:"), element("ul", {}, ...s.dropped.map(d => element("li", {}, `${d.what}: ${d.why}`))));
  content.push(element("details", {}, element("summary", {}, "All settings"), table(...Object.entries(settings).map(([name, value]) => cells(name, shownValue(value))))));
  return section("What was chosen, and why", ...content);
}

function convergenceSection() {
  const curve = axis => [{ points: report.convergence.map(p => [p[axis], p.error]), color: COLORS[0] }];
  const text = report.convergence.length ? "Estimated relative error, from states of the film (root of the mean of variance / (pixel² + 0.01))." :
    "No estimate: it takes a device, the whole film, and two samples of every pixel.";
  return section("Convergence", element("p", {}, text), ...(report.convergence.length ? [element("div", { class: "columns" },
    logLogPlot(curve("seconds"), "seconds of rendering", "estimated error"), logLogPlot(curve("samples"), "samples per pixel", "estimated error"))] : []));
}

function timeSections() {
  if (!s.stages) return [];
  const names = { load: "loading", bvh: "acceleration structure, choices", pipelines: "kernels", render: "rendering (wall)", device: "on the device", cpu: "processor, all threads" };
  const run = s.stages.filter(stage => !stage.skipped), longest = Math.max(...run.map(stage => stage.device_ms + stage.host_ms), 1e-9);
  const stageRow = stage => {
    const ms = stage.device_ms + stage.host_ms, bar = element("div", { class: "amount", style: `width:${(12 * ms / longest).toFixed(2)}rem` });
    return element("tr", {}, element("td", {}, stage.name), ...[whole(stage.dispatches), whole(stage.items), number(stage.device_ms), number(stage.host_ms)].map(text => element("td", {}, text)),
      element("td", { class: "text" }, bar));
  };
  const scene = s.scene;
  return [section("Time", table(...Object.entries(s.seconds).map(([name, value]) => cells(names[name] ?? name, `${number(value)} s`))),
    table(element("tr", {}, ...["stage", "dispatches", "items", "device ms", "host ms", ""].map(text => element("th", {}, text))), ...run.map(stageRow)),
    element("p", {}, "Stages that nothing needed: ", s.stages.filter(stage => stage.skipped).map(stage => stage.name).join(", ") || "none", ".")),
  section("Rays and memory", table(cells("closest hits", whole(s.rays.closest)), cells("visibility", whole(s.rays.visibility)), cells("camera paths", whole(s.samples)),
    cells("light paths", whole(s.light_paths)), cells("samples per second", whole(Math.round(s.samples_per_second))), cells("device memory, peak", bytes(s.device_peak_bytes)),
    cells("host memory, peak", bytes(s.host_peak_bytes)), cells("paths in flight", `${whole(s.wave_paths)} of ${whole(s.bytes_per_path)} bytes`),
    cells("samples dropped as not finite", whole(s.non_finite)))),
  section("Features", element("p", {}, "The scene has: ", shownValue(scene.features), "."),
    element("p", { id: "skipped" }, "Left out of the kernels, because it has none: ", shownValue(scene.features_absent), "."),
    element("p", {}, `Material classes: ${shownValue(scene.material_classes)}. ${whole(scene.triangles)} triangles, ${whole(scene.materials)} materials, ${whole(scene.textures)} textures, ${whole(scene.lights)} lights.`))];
}

const warnings = section("Warnings", report.warnings.length ? element("ul", {}, ...report.warnings.map(text => element("li", {}, text))) : element("p", {}, "None."));
showReport(report.about, [pictureSection(), choiceSection(), convergenceSection(), ...timeSections(), warnings]);
