"use strict";
const report = JSON.parse(document.getElementById("report").textContent);
const COLORS = ["#1f77b4", "#d62728", "#2ca02c", "#ff7f0e", "#9467bd", "#8c564b", "#e377c2", "#17becf", "#bcbd22", "#7f7f7f"];

// element("tag", {attribute: value}, child...): children are nodes or plain text, never markup.
function element(tag, attributes = {}, ...children) {
  const svg = ["svg", "path", "line", "text", "circle", "g"].includes(tag);
  const node = svg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) node.setAttribute(name, value);
  node.append(...children);
  return node;
}
const number = x => x === null ? "–" : x === 0 ? "0" : Math.abs(x) >= 0.01 && Math.abs(x) < 1000 ? x.toPrecision(3) : x.toExponential(2);

// Log-log: curves of points [x, y]. A curve has a colour, and may be dashed or without dots; what is not positive is left out.
function logLogPlot(curves, xText, yText) {
  const W = 520, H = 340, L = 60, R = 10, T = 10, B = 40;
  const shownOf = curve => curve.points.filter(([x, y]) => x > 0 && y > 0);
  const points = curves.flatMap(shownOf);
  // From one of 1, 2, 5, 10, ... to another, at least half a decade.
  const round = (v, rounding) => {
    const decade = 10 ** Math.floor(Math.log10(v)), steps = [1, 2, 5, 10].map(step => step * decade);
    return rounding > 0 ? steps.find(step => step >= v * 0.999) : steps.findLast(step => step <= v * 1.001);
  };
  const range = values => {
    const low = round(Math.min(...values), -1), high = round(Math.max(...values), 1);
    return [Math.log10(low), Math.max(Math.log10(high), Math.log10(low) + 0.5)];
  };
  const ticks = (low, high) => {
    const decades = Array.from({ length: Math.ceil(high) - Math.floor(low) + 1 }, (_, i) => Math.floor(low) + i);
    const steps = high - low > 2.5 ? [1] : [1, 2, 5];
    const every = Math.ceil((high - low) / 12);
    return decades.filter(e => e % every === 0).flatMap(e => steps.map(step => step * 10 ** e)).filter(v => Math.log10(v) > low - 0.01 && Math.log10(v) < high + 0.01);
  };
  const tickText = v => v >= 0.01 && v < 1e4 ? String(Number(v.toPrecision(1))) : v.toExponential(0);
  const node = element("svg", { viewBox: `0 0 ${W} ${H}`, width: W, height: H, class: "plot" });
  if (points.length === 0) return node;
  const [x0, x1] = range(points.map(p => p[0])), [y0, y1] = range(points.map(p => p[1]));
  const x = v => L + (Math.log10(v) - x0) / (x1 - x0) * (W - L - R);
  const y = v => H - B - (Math.log10(v) - y0) / (y1 - y0) * (H - T - B);
  for (const v of ticks(x0, x1)) {
    node.append(element("line", { x1: x(v), x2: x(v), y1: T, y2: H - B, stroke: "var(--line)" }),
      element("text", { x: x(v), y: H - B + 15, "text-anchor": "middle" }, tickText(v)));
  }
  for (const v of ticks(y0, y1)) {
    node.append(element("line", { x1: L, x2: W - R, y1: y(v), y2: y(v), stroke: "var(--line)" }),
      element("text", { x: L - 5, y: y(v) + 4, "text-anchor": "end" }, tickText(v)));
  }
  node.append(element("text", { x: (L + W - R) / 2, y: H - 6, "text-anchor": "middle" }, xText),
    element("text", { x: 14, y: (T + H - B) / 2, transform: `rotate(-90 14 ${(T + H - B) / 2})`, "text-anchor": "middle" }, yText));
  for (const curve of curves) {
    const shown = shownOf(curve);
    const d = shown.map((p, k) => `${k === 0 ? "M" : "L"}${x(p[0]).toFixed(1)},${y(p[1]).toFixed(1)}`).join("");
    node.append(element("path", { d, class: "curve", stroke: curve.color, "stroke-dasharray": curve.isDashed ? "5 3" : "none" }));
    if (curve.hasDots !== false) for (const p of shown) node.append(element("circle", { cx: x(p[0]), cy: y(p[1]), r: 2.5, fill: curve.color }));
  }
  return node;
}

// Heading and the sections of the report.
function showReport(about, sections) {
  document.title = report.title;
  document.querySelector("h1").textContent = report.title;
  document.getElementById("about").textContent = about;
  document.querySelector("main").append(...sections);
}
