// Draws the whole report from the JSON in #report-data. No network, no dependency but dygraphs, which is embedded above.
"use strict";

const data = JSON.parse(document.getElementById("report-data").textContent);
const summary = data.summary;
const page = document.getElementById("report");
const openCharts = [];

const pipelineNames = { P0: "no prediction", P1: "constant velocity", P2: "Kalman without inertial", P3: "Kalman with inertial", P4: "late rotation", P5: "late depth warp", P6: "late depth warp per line" };
const seriesColors = { P0: "--p0", P1: "--p1", P2: "--s3", P3: "--p3", P4: "--s2", P5: "--s4", P6: "--s5", ablation: "--theory", theory: "--theory", a: "--p0", b: "--p1", c: "--s2", d: "--s3", e: "--s4", f: "--s5" };

// ---- small helpers -----------------------------------------------------------------------------------------------------------

/** Makes an element: el("p.note", {title: "x"}, "text", child). */
function el(spec, attributes, ...children) {
  const [tag, ...classes] = spec.split(".");
  const node = document.createElement(tag);
  if (classes.length) node.className = classes.join(" ");
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (value !== undefined && value !== null) node.setAttribute(key, value);
  }
  node.append(...children.filter((child) => child !== null && child !== undefined));
  return node;
}

/** A number with about three significant digits; a dash where it is undefined. */
function number(value, unit) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  let text;
  if (size !== 0 && (size < 0.001 || size >= 1e6)) text = value.toExponential(1).replace("e-", "e\u2212");
  else text = value.toFixed(size >= 100 ? 0 : size >= 10 ? 1 : size >= 1 ? 2 : 3);
  return (text.replace(/^-(?=.*[1-9])/, "\u2212").replace(/^-/, "")) + (unit ? "\u00a0" + unit : "");
}

/** Four significant digits, for numbers that are to be compared. */
function precise(value, unit) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "\u2013";
  const size = Math.abs(value);
  const text = size !== 0 && (size < 0.001 || size >= 1e6) ? value.toExponential(1) : String(+value.toPrecision(4));
  return text.replace("-", "\u2212") + (unit ? "\u00a0" + unit : "");
}
const tick = (value) => String(+value.toPrecision(4)).replace("-", "\u2212");
/** ASCII of names and units as a page writes it. */
const typeset = (text) => text.replaceAll("+-", "\u00b1").replaceAll(" deg/s", "\u00b0/s").replaceAll(" deg", "\u00b0");
const unitSign = (unit) => ({ "deg/s": "\u00b0/s", deg: "\u00b0" }[unit] || unit);

const color = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const seriesColor = (style) => color(seriesColors[style] || "--ink");
const ownDeflection = { P4: "rotation", P5: "depth", P6: "depth" };
/** "P4", or "P4 shift" when it deflects in another way than its own, or "P3 10 ms too far" when it predicts so. */
function variant(r) {
  const shifted = r.deflection === (ownDeflection[r.pipeline] || "none") ? "" : ` ${r.deflection}`;
  const wrong = r.interval_error_ms ? ` ${tick(Math.abs(r.interval_error_ms))} ms too ${r.interval_error_ms > 0 ? "far" : "short"}` : "";
  return r.pipeline + shifted + wrong;
}
const variantTitle = (r) => (r.ablation ? variant(r) : `${r.pipeline}, ${pipelineNames[r.pipeline]}`);
const sum = (list) => list.reduce((a, b) => a + b, 0);

function section(title, ...intro) {
  const node = el("section", {}, el("h2", {}, title), ...intro);
  page.append(node);
  return node;
}

// ---- charts ------------------------------------------------------------------------------------------------------------------

function legendEntry(series, value) {
  const mark = el("i" + (series.dashed ? ".dashed" : series.points ? ".points" : series.area ? ".area" : ""));
  mark.style.color = mark.style.borderColor = seriesColor(series.style);
  return el("span", {}, mark, series.name, value === undefined ? null : el("b", {}, value));
}

function fillLegend(legend, chart, row) {
  legend.replaceChildren();
  legend.append(el("span", {}, chart.x.label + (row ? "" : ` (${chart.x.unit})`), row ? el("b", {}, number(row[0], chart.x.unit)) : null));
  chart.series.forEach((series, i) => {
    legend.append(legendEntry(series, row ? number(row[i + 1], chart.y.unit) : undefined));
  });
}

/** One finger reads values and leaves the page free to scroll; two fingers zoom. */
function touchModel(showAt, clear) {
  const pinch = Dygraph.defaultInteractionModel;
  const show = (event) => showAt(event.touches[0]);
  return {
    ...pinch,
    touchstart: (event, g, context) => (event.touches.length > 1 ? pinch.touchstart(event, g, context) : show(event)),
    touchmove: (event, g, context) => (event.touches.length > 1 ? pinch.touchmove(event, g, context) : show(event)),
    touchend: (event, g, context) => { if (context.initialTouches) pinch.touchend(event, g, context); else clear(); },
  };
}

/** Each curve's median, of those that are more than rounding. */
function medians(chart) {
  return chart.series.map((series, i) => {
    const ys = chart.rows.map((row) => row[i + 1]).filter((y) => Number.isFinite(y)).sort((a, b) => a - b);
    return ys.length ? ys[ys.length >> 1] : 0;
  }).filter((median) => median > 1e-6);
}

/** Whether curves differ so much that the small ones would lie on the axis. */
const differsByDecades = (chart) => Math.max(...medians(chart)) > 20 * Math.min(...medians(chart));

/** A logarithm has no zero: what is smaller than a tenth of the lowest curve's median, or than a ten-thousandth of all, is drawn at that. */
function forLog(chart) {
  const most = chart.rows.reduce((m, row) => row.slice(1).reduce((n, y) => (y > n ? y : n), m), 1e-9);
  const least = Math.max(1e-4 * most, 0.1 * Math.min(...medians(chart), most));
  return chart.rows.map(([x, ...ys]) => [x, ...ys.map((y) => (Number.isFinite(y) ? Math.max(y, least) : y))]);
}

function chartOptions(chart, legend, reset) {
  const options = {
    labels: [chart.x.label, ...chart.series.map((s) => s.name)],
    legend: "never",
    xlabel: `${chart.x.label} (${chart.x.unit})`,
    ylabel: `${chart.y.label} (${chart.y.unit})`,
    strokeWidth: 1.8,
    highlightCircleSize: 4,
    stackedGraph: Boolean(chart.stacked),
    fillAlpha: 0.55,
    connectSeparatedPoints: true,
    includeZero: chart.includeZero !== false,
    logscale: Boolean(chart.y.log || chart.logarithmic),
    digitsAfterDecimal: 3,
    xRangePad: chart.x.log ? 0 : 4,
    yRangePad: 6,
    axes: {
      x: { logscale: Boolean(chart.x.log), axisLabelFormatter: tick, pixelsPerLabel: 64 },
      y: { axisLabelWidth: chart.y.log ? 60 : 48, axisLabelFormatter: tick },
    },
    series: Object.fromEntries(chart.series.map((s) => [s.name, {
      color: seriesColor(s.style),
      strokePattern: s.dashed ? [6, 5] : null,
      strokeWidth: s.points ? 0 : s.dashed ? 1.5 : 1.8,
      drawPoints: Boolean(s.points),
      pointSize: 3,
      fillGraph: Boolean(s.area || chart.stacked),
    }])),
    axisLineColor: color("--line"),
    gridLineColor: color("--grid"),
    highlightCallback: (event, x, points, row) => fillLegend(legend, chart, chart.rows[row]),
    unhighlightCallback: () => fillLegend(legend, chart, null),
    zoomCallback: () => { reset.hidden = false; },
  };
  return options;
}

function drawChart(chart, parent) {
  const reset = el("button", { type: "button", hidden: "" }, "Reset zoom");
  chart.logarithmic ??= Boolean(chart.logToggle) && differsByDecades(chart);
  const log = chart.logToggle ? el("button", { type: "button", "aria-pressed": String(chart.logarithmic), title: "What is small beside the largest shows on a logarithmic scale" }, "Log scale") : null;
  const legend = el("div.legend", { "aria-live": "off" });
  const plot = el("div.plot", { role: "img", "aria-label": `${chart.title}: ${chart.caption}` });
  const caption = el("figcaption", {}, chart.caption);
  const box = el("figure.card.chart" + (chart.half ? ".half" : ""), { id: "chart-" + chart.id },
    el("header", {}, el("h3", {}, chart.title), el("span.buttons", {}, reset, log)), legend, plot, caption);
  parent.append(box);
  fillLegend(legend, chart, null);
  const graph = new Dygraph(plot, chart.logarithmic ? forLog(chart) : chart.rows, chartOptions(chart, legend, reset));
  graph.updateOptions({ interactionModel: matchMedia("(pointer: coarse)").matches
    ? touchModel((touch) => graph.mouseMove_(touch), () => { graph.clearSelection(); fillLegend(legend, chart, null); })
    : Dygraph.defaultInteractionModel });
  reset.addEventListener("click", () => { graph.resetZoom(); reset.hidden = true; });
  if (log) log.addEventListener("click", () => {
    chart.logarithmic = !chart.logarithmic;
    log.setAttribute("aria-pressed", String(chart.logarithmic));
    graph.updateOptions({ logscale: chart.logarithmic, file: chart.logarithmic ? forLog(chart) : chart.rows });
  });
  // The box gets its width when all charts are in the page, and again when the window changes.
  const observer = new ResizeObserver(() => graph.resize());
  observer.observe(plot);
  openCharts.push({ graph, chart, legend, reset, observer });
}

/** What stands at a bar or in a table: whole numbers as such, and two digits or three of the others. */
const brief = (value) => (Number.isInteger(value) ? tick(value) : Math.abs(value) < 0.1 && Math.abs(value) >= 1e-5 ? tick(+value.toPrecision(2)) : number(value));

/** 1, 2 or 5 times a power of ten: about five of them up to `most`. */
function linearTicks(most) {
  const power = 10 ** Math.floor(Math.log10(most / 4));
  const step = power * [1, 2, 5, 10].find((s) => s * power * 5 >= most);
  return Array.from({ length: Math.floor(most / step + 1e-9) + 1 }, (_, i) => i * step);
}

/** Bars that lie: rows of {group, label, values}, in each a bar for each of the chart's series. */
function drawBars(chart, parent) {
  const values = chart.rows.flatMap((r) => r.values).filter((v) => v > 0);
  const most = Math.max(...values, 1e-9);
  const low = chart.x.log ? 10 ** Math.floor(Math.log10(0.8 * Math.min(...values))) : 0;
  const ticks = chart.x.log ? Array.from({ length: Math.floor(Math.log10(most / low)) + 1 }, (_, i) => low * 10 ** i) : linearTicks(most);
  const part = (v) => (chart.x.log ? Math.max(0, Math.log(v / low) / Math.log(most / low)) : v / most);
  const bar = (v, i) => el("div", {}, el("i", { style: `--part:${v > 0 ? part(v) : 0};background:var(${seriesColors[chart.series[i].style]})` }), el("b", {}, brief(v)));
  const box = el("div.bars");
  let group = "";
  for (const r of chart.rows) {
    if (r.group !== group) box.append(el("h4", {}, r.group));
    group = r.group;
    box.append(el("span", {}, r.label), el("div.track", {}, ...ticks.map((t) => el("u", { style: `--part:${part(t)}` })), ...r.values.map(bar)));
  }
  box.append(el("span"), el("div.scale", {}, ...ticks.map((t) => el("span", { style: `--part:${part(t)}` }, tick(t)))),
    el("span"), el("div.soft", {}, `${chart.x.label} (${unitSign(chart.x.unit)})`));
  parent.append(el("figure.card.chart" + (chart.half ? ".half" : ""), { id: "chart-" + chart.id }, el("header", {}, el("h3", {}, chart.title)),
    el("div.legend.brief", {}, ...chart.series.map((s) => legendEntry(s))), box, el("figcaption", {}, typeset(chart.caption))));
}

function destroyCharts(inside) {
  for (let i = openCharts.length - 1; i >= 0; --i) {
    if (!inside.contains(openCharts[i].graph.graphDiv)) continue;
    openCharts[i].observer.disconnect();
    openCharts[i].graph.destroy();
    openCharts.splice(i, 1);
  }
}

matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => {
  for (const { graph, chart, legend, reset } of openCharts) {
    graph.updateOptions(chartOptions(chart, legend, reset));
    fillLegend(legend, chart, null);
  }
});

// ---- pictures ----------------------------------------------------------------------------------------------------------------

/** Arrows (from where the real disc is to where its virtual twin is drawn), in picture pixels with y downward. */
function arrowLayer(picture, zoom) {
  const ns = "http://www.w3.org/2000/svg";
  const svg = document.createElementNS(ns, "svg");
  svg.setAttribute("viewBox", `0 0 ${picture.width} ${picture.height}`);
  svg.setAttribute("aria-hidden", "true");
  const unit = picture.width / 320 / zoom;
  for (const [x0, y0, x1, y1] of picture.arrows || []) {
    const length = Math.hypot(x1 - x0, y1 - y0);
    const dot = document.createElementNS(ns, "circle");
    for (const [k, v] of Object.entries({ cx: x0, cy: y0, r: 2 * unit, fill: "#fff", stroke: "#111", "stroke-width": 0.7 * unit })) dot.setAttribute(k, v);
    if (length > 2.5 * unit) {
      const ux = (x1 - x0) / length, uy = (y1 - y0) / length, head = Math.min(6 * unit, 0.5 * length);
      const bx = x1 - ux * head, by = y1 - uy * head, w = 0.5 * head;
      const path = document.createElementNS(ns, "path");
      path.setAttribute("d", `M${x0} ${y0}L${bx} ${by}M${x1} ${y1}L${bx - uy * w} ${by + ux * w}L${bx + uy * w} ${by - ux * w}Z`);
      for (const [k, v] of Object.entries({ stroke: "#fff", fill: "#fff", "stroke-width": 1.6 * unit, "stroke-linejoin": "round", "paint-order": "stroke" })) path.setAttribute(k, v);
      svg.append(path);
    }
    svg.append(dot);
  }
  return svg;
}

/** The picture with its arrows; `close`, {zoom, middle}, magnifies the surroundings of a place. */
function pictureLayers(picture, alt, close) {
  const layers = el("span.layers", {}, el("img", { src: picture.src, alt, width: picture.width, height: picture.height }),
    picture.arrows ? arrowLayer(picture, close ? close.zoom : 1) : null);
  if (close) {
    const [x, y] = [100 * close.middle[0] / picture.width, 100 * close.middle[1] / picture.height];
    layers.style.transformOrigin = `${x}% ${y}%`;
    layers.style.transform = `translate(${50 - x}%, ${50 - y}%) scale(${close.zoom})`;
  }
  return layers;
}

function pictureButton(picture, alt, caption, close) {
  return el("button.picture", { type: "button", "aria-label": `Enlarge: ${alt}`, onclick: () => enlarge(picture, alt, caption, close) },
    pictureLayers(picture, alt, close));
}

function enlarge(picture, alt, caption, closeUp) {
  const box = document.getElementById("lightbox");
  const close = () => box.close();
  box.firstElementChild.replaceChildren(
    el("button.picture", { type: "button", "aria-label": "Close", onclick: close }, pictureLayers(picture, alt, closeUp)),
    el("figcaption", {}, caption || alt));
  box.onclick = (event) => { if (event.target === box) close(); };
  box.showModal();
}

const sheetModes = { close: "Close-up", detail: "Detail", whole: "Whole view", alone: "Virtual alone" };

function contactSheet(sheet, parent) {
  const head = el("tr", {}, el("th"), ...sheet.times_s.map((t) => el("th", {}, tick(t) + "\u00a0s")));
  const body = el("tbody");
  const tabs = el("div.tabs.small", { role: "group", "aria-label": "What the sheet shows" });
  const cell = (row, mode, i) => {
    const detail = mode === "close" ? row.detail[i] : null;
    const picture = detail || (row[mode] || row.detail)[i] || row.whole[i];
    const moment = `${row.label} at ${tick(sheet.times_s[i])} s`;
    const error = row.rms_px[i];
    return el("td", {}, pictureButton(picture, moment, `${row.label}${row.note ? ", " + row.note : ""}, ${tick(sheet.times_s[i])} s. ${picture.caption || ""}`,
      detail ? { zoom: 4, middle: sheet.middles[i] } : null), error === undefined ? null : el("small", {}, number(error, "px")));
  };
  const show = (mode) => {
    for (const tab of tabs.children) tab.setAttribute("aria-pressed", String(tab.dataset.mode === mode));
    body.replaceChildren(...sheet.rows.map((row) => el("tr", {}, el("th", { scope: "row" }, row.label, el("span", {}, row.note || "")),
      ...sheet.times_s.map((t, i) => cell(row, mode, i)))));
  };
  for (const [mode, name] of Object.entries(sheetModes)) {
    if ((mode === "detail" || mode === "close") && !sheet.rows.some((row) => row.detail.some((picture) => picture))) continue;
    tabs.append(el("button", { type: "button", "data-mode": mode, onclick: () => show(mode) }, name));
  }
  parent.append(tabs, el("div.scroll.sheet", { tabindex: "0", role: "region", "aria-label": "Contact sheet" },
    el("table", {}, el("thead", {}, head), body)), el("p.note", {}, sheet.caption));
  show(tabs.firstElementChild.dataset.mode);
}

// ---- the parts of the page ---------------------------------------------------------------------------------------------------

function row(pipeline, motion) {
  const head = data.headline;
  return summary.rows.find((r) => r.motion === (motion || head.motion) && r.pipeline === pipeline && !r.ablation &&
    r.latency_ms === head.latency_ms && r.lens === head.lens && r.eye === head.eye && r.display === head.display);
}

/** Degrees from a tenth of one up; the number and its unit never part. */
function angle(arcmin) { return arcmin >= 6 ? number(arcmin / 60) + "\u00b0" : number(arcmin, "arcmin"); }

/** "cuts it to 12 arcmin, 11 times less", or "makes it larger: ..." */
function comparison(before, after) {
  const a = before.registration.peak_arcmin, b = after.registration.peak_arcmin;
  if (!(a > 0) || !(b > 0)) return null;
  const ratio = a / b;
  if (ratio > 1.1) return el("p", {}, "Predicting the head's motion at constant velocity (P1) cuts the largest error to ", el("strong", {}, angle(b)), `, ${number(ratio)} times less.`);
  if (ratio < 0.9) return el("p", {}, "Predicting at constant velocity (P1) makes it worse here: ", el("strong", {}, angle(b)), `, ${number(1 / ratio)} times more. The motion changes too fast for so long a prediction.`);
  return el("p", {}, "Predicting at constant velocity (P1) changes little here: ", el("strong", {}, angle(b)), ".");
}

/** What a filter of all poses makes of it, beside constant velocity. */
function filtering(filtered, predicted) {
  const a = filtered && filtered.registration.peak_arcmin, b = predicted && predicted.registration.peak_arcmin;
  if (!(a > 0)) return null;
  const beside = b > 0 ? (a < 0.95 * b ? ", which is less" : a > 1.05 * b ? ", which is more: it holds on to an acceleration that is over" : ", about as much") : "";
  return el("p", {}, "A Kalman filter of all poses measured so far (P2) also estimates how the velocity changes. It leaves at most ", el("strong", {}, angle(a)), `${beside}.`);
}

/** What inertial sensors add to that. */
function feeling(felt, best) {
  const a = felt && felt.registration.peak_arcmin, b = best && best.registration.peak_arcmin;
  if (!(a > 0)) return null;
  const beside = b > 0 ? (a < 0.95 * b ? `, ${number(b / a)} times less` : a > 1.05 * b ? ", which is more: it takes the jerk of a start or stop for the beginning of more" : ", about as much") : "";
  return el("p", {}, "With gyros and accelerometers on the head (P3, simulated) the filter feels a turn begin before poses show it. It leaves at most ", el("strong", {}, angle(a)), `${beside}.`);
}

/** What a late correction of the finished picture leaves, and what each further step of it removes. */
function lateCorrection(predicted) {
  const turned = row("P4"), moved = row("P5"), lines = row("P6");
  const first = turned || moved || lines;
  if (!first) return null;
  const peak = (r) => el("strong", {}, angle(r.registration.peak_arcmin));
  const text = el("p", {}, `A finished picture can still be corrected just before it is shown, with a pose measured only ${tick(first.late_ms)} ms before the display starts to scan it out. `);
  if (turned) text.append("Turning it to that pose (P4, late rotation) leaves at most ", peak(turned), ". ");
  if (moved) text.append("Moving every point by its own distance as well (P5, late depth warp) leaves ", peak(moved), ". ");
  if (lines && lines.display === "rolling") text.append("Doing so for each line at its own time (P6) leaves ", peak(lines), ". ");
  else if (lines && moved) text.append("Line by line (P6) is the same here, as this display lights all lines at once. ");
  const worst = [turned, moved].filter(Boolean).find((r) => predicted && r.registration.peak_arcmin > predicted.registration.peak_arcmin);
  if (worst) text.append(`Here ${worst.pipeline} is no better than prediction alone. `);
  return text;
}

function inertialNote() {
  if (!summary.inertial) return null;
  return el("p.note", {}, `A motion is a trajectory alone. The inertial sensors of P3 to P6 are ${summary.inertial.readings.replace("m/s2", "m/s\u00b2")}; the poses that all pipelines measure have no noise.`);
}

/** On a display that lights all lines at once, line by line (P6) is P5. */
const isRepeated = (r) => r.pipeline === "P6" && r.display !== "rolling" && row("P5");

function introduction() {
  const head = data.headline, still = row("P0"), predicted = row("P1"), first = still || predicted || summary.rows[0];
  page.append(el("p.eyebrow", {}, "Holdfast \u00b7 swim report"));
  if (!first) return;
  const peak = first.registration.peak_arcmin;
  page.append(el("h1", {}, still ? `At ${tick(head.latency_ms)} ms, the virtual world slips by up to ${angle(peak)}` : `Swim of ${first.pipeline} at ${tick(head.latency_ms)} ms`));
  page.append(el("p.lead", {}, "A see-through headset draws virtual things over the real room. When you move your head, they must move the other way in the picture, " +
    "or they will not stay put. But every picture is a little late: it was drawn for where the head was a moment ago. So virtual things slide over the real ones while you move, " +
    "and slip back when you stop. That sliding is called ", el("strong", {}, "swim"), "."));
  page.append(el("p", {}, "How large it is here: in ", el("strong", {}, typeset(head.motion_title)), ` the head turns at up to ${number(head.peak_head_deg_s, "\u00b0/s")}. At ` +
    `${tick(head.latency_ms)} ms of latency ${still ? "and no prediction (P0) " : ""}the virtual world stands up to `,
    el("strong", {}, angle(peak)), ` away from where it belongs (${number(first.registration.peak_px, "px")} in the picture) and slides at up to `,
    el("strong", {}, number(first.swim.peak_deg_s, "\u00b0/s")), ". The width of your thumb at arm's length is about 2\u00b0. ", head.shown));
  const change = still && predicted ? comparison(still, predicted) : null;
  if (change) page.append(change);
  const filter = filtering(row("P2"), predicted);
  if (filter) page.append(filter);
  const felt = feeling(row("P3"), row("P2") || predicted);
  if (felt) page.append(felt);
  const late = lateCorrection(row("P3") || predicted);
  if (late) page.append(late);
  const cards = el("div.cards");
  for (const r of ["P0", "P1", "P2", "P3", "P4", "P5", "P6"].map((id) => row(id)).filter((r) => r && !isRepeated(r))) {
    const mark = el("i.dot"); mark.style.color = seriesColor(r.pipeline);
    cards.append(el("div.card", {}, el("header", {}, mark, el("strong", {}, variantTitle(r))),
      el("dl.figures", {}, ...[["largest error", angle(r.registration.peak_arcmin), number(r.registration.peak_px, "px")],
        ["fastest swim", number(r.swim.peak_deg_s, "\u00b0/s"), "RMS " + number(r.swim.rms_deg_s, "\u00b0/s")],
        ["eff. latency", r.effective_latency_ms !== null && Math.abs(r.effective_latency_ms) < 0.01 ? "0.00\u00a0ms" : number(r.effective_latency_ms, "ms"), `of ${tick(r.latency_ms)} ms`]]
        .map(([name, value, more]) => el("div", {}, el("dt", {}, name), el("dd", {}, el("b", {}, value), el("small", {}, more)))))));
  }
  page.append(cards);
  const simulated = inertialNote();
  if (simulated) page.append(simulated);
  if (data.heroes && data.heroes.length) {
    page.append(el("div.pictures", {}, ...data.heroes.map((hero) => el("figure", {}, pictureButton(hero, hero.title, hero.caption),
      el("figcaption", {}, el("strong", {}, hero.title + ". "), hero.caption)))));
  }
}

function verdict(word) {
  return el("span.verdict." + word, {}, el("i.dot"), { pass: "pass", warn: "warn", fail: "FAIL", none: "no expectation" }[word] || word);
}

function table(columns, rows, label) {
  const head = el("tr", {}, ...columns.map((c) => el("th" + (c.text ? ".text" : ""), { scope: "col" }, c.name, c.unit ? el("small", {}, c.unit) : null)));
  const body = rows.map((r) => el("tr", {}, ...columns.map((c) => el("td" + (c.text ? ".text" : "") + (c.wrap ? ".wrap" : c.narrow ? ".narrow" : ""), {}, c.value(r)))));
  return el("div.scroll", { tabindex: "0", role: "region", "aria-label": label }, el("table", {}, el("thead", {}, head), el("tbody", {}, ...body)));
}

function checks() {
  if (!summary.checks || !summary.checks.length) return;
  const passed = summary.checks.filter((c) => c.verdict === "pass").length;
  const node = section("What theory demands",
    el("p", {}, `Each run first measures cases with known answers. ${passed === summary.checks.length ? "All" : passed + " of"} ${passed === summary.checks.length ? passed : summary.checks.length} agree with them. ` +
      "The number is the line of the evaluation plan under \u201cValues that theory demands\u201d."));
  node.append(table([
    { name: "Value", text: true, value: (c) => String(c.value) },
    { name: "What", text: true, wrap: true, value: (c) => c.what },
    { name: "Expected", value: (c) => (c.comparison === "at_most" ? "\u2264 " : "") + precise(c.expected, unitSign(c.unit)) },
    { name: "Measured", value: (c) => precise(c.measured, unitSign(c.unit)) },
    { name: "Tolerance", value: (c) => (c.comparison === "at_most" ? "\u2013" : "\u00b1" + number(c.tolerance, unitSign(c.unit))) },
    { name: "Verdict", text: true, value: (c) => verdict(c.verdict) },
  ], summary.checks, "Values that theory demands"));
}

function motions() {
  const ids = Object.keys(data.motions);
  if (!ids.length) return;
  const node = section("Motion by motion", el("p", {}, "Hover over a chart to read values, drag across it to zoom, double-click to go back. On a phone, slide a finger along it."));
  const tabs = el("div.tabs", { role: "tablist" });
  const panel = el("div", { role: "tabpanel", "aria-live": "off" });
  const show = (id) => {
    destroyCharts(panel);
    panel.replaceChildren();
    for (const tab of tabs.children) tab.setAttribute("aria-selected", String(tab.dataset.id === id));
    const motion = data.motions[id];
    panel.append(el("p.soft", {}, motion.about + " " + motion.shown));
    const grid = el("div.charts.two");
    panel.append(grid);
    for (const chart of motion.charts) drawChart(chart, grid);
    if (motion.sheet) {
      const title = el("h3", {}, "What the eye sees");
      title.style.marginTop = "32px";
      panel.append(title);
      contactSheet(motion.sheet, panel);
    }
  };
  for (const id of ids) {
    tabs.append(el("button", { type: "button", role: "tab", "data-id": id, "aria-selected": "false", onclick: () => show(id) }, typeset(data.motions[id].tab)));
  }
  node.append(tabs, panel);
  show(data.headline.motion in data.motions ? data.headline.motion : ids[0]);
}

function sweeps() {
  if (!data.sweeps || !data.sweeps.length) return;
  const node = section("Slow and fast movements", el("p", {}, "The same pipelines and latency, for small turns of the head of every frequency. Slow movements are shown faithfully; fast ones come late, and prediction exaggerates them."));
  const grid = el("div.charts.two");
  node.append(grid);
  for (const chart of data.sweeps) drawChart(chart, grid);
}

function expectedText(r) {
  if (!r.expected) return "\u2013";
  return Object.entries(r.expected).map(([key, v]) => `${key.replace(/^pose\.|^registration\./, "").replace(/_(px|arcmin|deg_s|ms|mm|deg)$/, "").replaceAll("_", " ")} ` +
    `${precise(v.measured)} / ${precise(v.expected, unitOf(key))}`).join("; ");
}
function unitOf(key) {
  const found = key.match(/_(px|arcmin|deg_s|ms|mm|deg)$/);
  return found ? { deg_s: "\u00b0/s", deg: "\u00b0" }[found[1]] || found[1] : "";
}

function results() {
  const node = section("Every row", el("p", {}, "One row is one motion seen by one pipeline, eye, lens, display and latency. Theory stands beside the measurement where a closed form exists."));
  const of = (key) => (r) => number(r[key]);
  node.append(table([
    { name: "Motion", text: true, value: (r) => r.motion },
    { name: "Pipeline", text: true, value: variant },
    { name: "Late correction", text: true, value: (r) => (r.late_ms === null ? "\u2013" : `${r.deflection}${r.per_scanline ? " per line" : ""}, ${tick(r.late_ms)}\u00a0ms`) },
    { name: "Eye", text: true, value: (r) => r.eye },
    { name: "Lens", text: true, value: (r) => r.lens },
    { name: "Display", text: true, value: (r) => r.display },
    { name: "Latency", unit: "ms", value: of("latency_ms") },
    { name: "Error RMS", unit: "px", value: (r) => number(r.registration.rms_px) },
    { name: "peak", unit: "px", value: (r) => number(r.registration.peak_px) },
    { name: "RMS", unit: "arcmin", value: (r) => number(r.registration.rms_arcmin) },
    { name: "peak", unit: "arcmin", value: (r) => number(r.registration.peak_arcmin) },
    { name: "RMS", unit: "mm", value: (r) => number(r.registration.rms_mm) },
    { name: "Swim RMS", unit: "\u00b0/s", value: (r) => number(r.swim.rms_deg_s) },
    { name: "peak", unit: "\u00b0/s", value: (r) => number(r.swim.peak_deg_s) },
    { name: "Effective latency", unit: "ms", value: of("effective_latency_ms") },
    { name: "Peak yaw error", unit: "arcmin", value: (r) => number(r.pose.peak_yaw_arcmin) },
    { name: "View missing", unit: "%", value: of("coverage_missing_pct") },
    { name: "revealed", unit: "%", value: of("disocclusion_pct") },
    { name: "Measured / theory", text: true, value: expectedText },
    { name: "Picture against theory", unit: "px RMS", value: of("picture_vs_theory_px") },
    { name: "Verdict", text: true, value: (r) => verdict(r.verdict) },
  ], summary.rows, "All rows"));
}

function glossary() {
  section("The words");
  page.lastElementChild.append(el("dl.terms", {}, ...[
    ["Registration error", "how far a virtual disc stands from its real twin in the picture: in pixels, as an angle, and in millimetres at the disc's depth."],
    ["Swim velocity", "how fast that error changes. A constant error is a misplaced object; a changing one is an object that slides."],
    ["Latency", "time between the tracker's measurement and the light of the frame that used it."],
    ["Effective latency", "the delay by which the displayed motion really trails the true one. Prediction brings it towards zero."],
    ["arcmin", "a sixtieth of a degree. Sharp eyes resolve about one."],
    ["P0, no prediction", "the picture is drawn for the pose that was measured."],
    ["P1, constant velocity", "the pose is carried on over the latency at the velocity measured last."],
    ["P2, Kalman without inertial", "a filter of all poses measured so far estimates velocity and acceleration, and carries the pose on by both. It needs no rate gyro; P1 is given the exact velocity of a generated motion."],
    ["Late pose", "what the tracker knows shortly before the display starts to show the picture, carried on to the moment of light in the same way."],
    ["P3, Kalman with inertial", "the same with gyros and accelerometers, whose errors are found on the way. How much of the newest acceleration is carried on is learnt from what would have been best in the last seconds."],
    ["P4, late rotation", "drawn as P3, somewhat wider than the view; then the finished picture is turned to the late pose. It corrects the head's turning at any distance, not its moving."],
    ["P5, late depth warp", "each point of the finished picture is moved by its own distance, so that the head's moving is corrected too."],
    ["P6, per line", "the same, with the pose of each line's own moment: for displays that light line after line."],
    ["Shift", "an ablation: the picture slides as a whole instead of being turned. Right at its centre, wrong towards its edges."],
    ["Too far, too short", "an ablation: the predictor takes the light to come so much later, or sooner, than it does. The picture then leads or trails by that time."],
    ["View missing, revealed", "part of the view for which the picture had no pixel, as it was not drawn wide enough; and part that was hidden behind something when it was drawn."],
    ["Theory", "the closed form for that motion: for a sine of frequency f and latency T, no prediction errs by 2\u00a0sin(\u03c0\u00a0f\u00a0T) of the amplitude."],
  ].flatMap(([term, text]) => [el("dt", {}, term), el("dd", {}, text)])));
}

function making() {
  const e = summary.environment, t = summary.timing;
  const node = section("How it was made");
  node.append(el("pre", {}, summary.command || ""));
  const facts = [["Renderer", [e.gl_renderer, e.gl_version, e.backend].filter(Boolean).join(" \u00b7 ") || "no pictures were drawn"], ["Display", e.display], ["Scene", e.scene], ["Seed", String(summary.seed)], ["Holdfast", e.holdfast_version]];
  if (t) {
    facts.push(["Bare draw and readback", number(t.draw_readback_ms, "ms")], ["Whole frame loop", `${number(t.frame_loop_ms, "ms")} for ${t.pictures} pictures, ${number(t.ratio)} times the bare time`],
      ["Metrics of all frames", number(t.metrics_ms, "ms")],
      ["Encoding apart", `${number(t.encode_ms, "ms")}`]);
  }
  node.append(el("dl.terms", {}, ...facts.filter(([, text]) => text).flatMap(([term, text]) => [el("dt", {}, term), el("dd", {}, text)])));
  node.append(el("p.note", {}, "Charts are drawn by dygraphs (MIT licence), embedded in this file. Latency is not the only error of a real headset; this report shows what the chosen settings leave."));
}

const toldTable = (t) => table(t.columns.map((c, i) => ({ ...c, unit: unitSign(c.unit), value: (r) => (c.text ? r[i] : brief(r[i])) })), t.rows, t.label);

/** A page that brings its own words: title, paragraphs, a table, charts, pictures as SVG, further tables. */
function tell(told) {
  document.title = `${told.title} - Holdfast`;
  page.append(el("p.eyebrow", {}, `Holdfast \u00b7 ${told.eyebrow}`), el("h1", {}, told.title),
    ...told.paragraphs.map((text, i) => el(i ? "p" : "p.lead", {}, text)));
  page.append(toldTable(told.table));
  const grid = el("div.charts.halves");
  grid.style.marginTop = "24px";
  page.append(grid);
  for (const chart of told.charts) (chart.bars ? drawBars : drawChart)(chart, grid);
  for (const p of told.pictures) {
    grid.append(el("figure.card.chart", {}, el("header", {}, el("h3", {}, p.title)),
      el("img", { src: "data:image/svg+xml," + encodeURIComponent(p.svg), alt: `${p.title}: ${p.caption}`, style: "max-width:100%" }), el("figcaption", {}, p.caption)));
  }
  for (const t of told.tables || []) section(t.title, el("p", {}, t.caption), toldTable(t));
  section("How it was made", el("pre", {}, told.command), el("p.note", {}, "Charts are drawn by dygraphs (MIT licence), embedded in this file."));
}

if (data.page) {
  tell(data.page);
} else {
  introduction();
  motions();
  sweeps();
  checks();
  results();
  glossary();
  making();
}
document.documentElement.dataset.ready = "true";
