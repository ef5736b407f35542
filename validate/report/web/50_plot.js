// One metric over one sweep, a line per rig: where it goes over its limit, and where the scrubber is.
const plotBox = { left: 46, right: 10, top: 10, bottom: 22, height: 150 };

/** About `count` round numbers that cover [low, high]. */
function ticks(low, high, count) {
  const span = high - low || 1;
  const raw = span / count, power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 2.5, 5, 10].map((m) => m * power).find((s) => s >= raw);
  const out = [];
  for (let i = Math.ceil(low / step - 1e-9); i * step <= high + step * 1e-9; ++i) out.push(Number((i * step).toPrecision(12)));
  return out;
}
const angleTicks = (low, high) => {
  const step = [5, 10, 15, 30, 45, 60, 90, 180, 360].find((s) => (high - low) / s <= 8) ?? 360;
  const out = [];
  for (let a = Math.ceil(low / step) * step; a <= high; a += step) out.push(a);
  return out;
};

/** Vertical scale. A flip is a hundred times everything else: then the scale is logarithmic. */
function valueScale(values, limit) {
  const finite = values.filter((v) => v != null).sort((a, b) => a - b);
  if (finite.length === 0) return { low: 0, high: 1, log: false, marks: [0, 1], to: (v) => v };
  const high = Math.max(finite.at(-1), limit ?? -Infinity), low = Math.min(finite[0], limit ?? Infinity);
  const typical = finite[Math.floor(finite.length / 2)];
  if (low >= 0 && high > 15 * Math.max(typical, limit ?? 0) && high > 0) {
    const floor = Math.max(Math.min(limit ?? high, typical || high) / 10, high / 1e6);
    const bottom = Math.log10(floor), top = Math.log10(high * 1.3);
    const marks = [];
    for (let p = Math.ceil(bottom); p <= top; ++p) marks.push(10 ** p);
    return { log: true, marks, to: (v) => (Math.log10(Math.max(v, floor)) - bottom) / (top - bottom) };
  }
  const pad = (high - low || Math.abs(high) || 1) * 0.08;
  const from = low >= 0 && low < 0.35 * high ? 0 : low - pad, till = high + pad;
  return { log: false, marks: ticks(from, till, 4), to: (v) => (v - from) / (till - from) };
}

/** Path data of a line that breaks where nothing was measured. */
function linePath(xs, ys) {
  let path = "", pen = false;
  xs.forEach((x, i) => {
    if (ys[i] == null) { pen = false; return; }
    path += (pen ? "L" : "M") + x.toFixed(1) + " " + ys[i].toFixed(1);
    pen = true;
  });
  return path;
}

/**
 * plot({title, unit, limit, series: [{rig, x, y}], needs: [low, high], onscrub}) gives {node, cursor(x)}.
 * `needs`: the range the envelope asks for, shaded.
 */
function plot({ title, unit, limit, series, needs, onscrub }) {
  const all = series.flatMap((s) => s.y);
  const xs = series.flatMap((s) => s.x);
  const low = Math.min(...xs), high = Math.max(...xs);
  const scale = valueScale(all, limit);
  const drawing = svg("svg", { "aria-hidden": "true", focusable: "false" });
  const readout = el("div", { class: "readout num" });
  const summary = series.map((s) => {
    const known = s.y.filter((v) => v != null);
    return visible(s.rig) + (known.length ? " from " + number(Math.min(...known)) + " to " + number(Math.max(...known)) : " not measured");
  }).join("; ");
  const canvas = el("div", { class: "plot-area", role: "img", "aria-label": visible(words(title)) + ": " + summary }, drawing);
  const node = el("figure", { class: "plot" }, el("figcaption", {}, el("b", {}, name(words(title))), " ",
    el("span", { class: "soft" }, visible(unit === "deg" ? "degrees" : unit || ""), limit != null && ", limit " + number(limit), scale.log && ", logarithmic"), readout), canvas);
  let width = 0, line = null, at = low;
  const px = (x) => plotBox.left + (x - low) / (high - low || 1) * (width - plotBox.left - plotBox.right);
  const py = (v) => plotBox.height - plotBox.bottom - Math.min(1.02, scale.to(v)) * (plotBox.height - plotBox.bottom - plotBox.top);

  function draw() {
    const base = plotBox.height - plotBox.bottom, right = width - plotBox.right;
    const parts = [];
    if (needs) {
      const from = Math.max(low, needs[0]), till = Math.min(high, needs[1]);
      if (till > from) parts.push(svg("rect", { class: "envelope", x: px(from), y: plotBox.top, width: px(till) - px(from), height: base - plotBox.top }));
    }
    for (const mark of scale.marks) {
      parts.push(svg("line", { class: "grid", x1: plotBox.left, x2: right, y1: py(mark), y2: py(mark) }),
        svg("text", { x: plotBox.left - 6, y: py(mark) + 3.5, "text-anchor": "end" }, number(mark)));
    }
    for (const angle of angleTicks(low, high)) {
      parts.push(svg("line", { class: "grid", x1: px(angle), x2: px(angle), y1: base, y2: base + 4 }),
        svg("text", { x: px(angle), y: plotBox.height - 6, "text-anchor": "middle" }, number(angle)));
    }
    if (limit != null) parts.push(svg("line", { class: "limit", x1: plotBox.left, x2: right, y1: py(limit), y2: py(limit) }));
    for (const s of series) {
      parts.push(svg("path", { class: "series ink" + rigInk(s.rig), d: linePath(s.x.map(px), s.y.map((v) => v == null ? null : py(v))) }));
      if (s.y.some((v) => v != null)) continue;
      parts.push(svg("text", { class: "absent", x: px(low) + 6, y: plotBox.top + 14 }, visible(s.rig) + ": not measured"));
    }
    line = svg("line", { class: "cursor", y1: plotBox.top, y2: base });
    drawing.setAttribute("viewBox", "0 0 " + width + " " + plotBox.height);
    drawing.replaceChildren(...parts, line);
    cursor(at);
  }
  function cursor(x) {
    at = x;
    if (!line) return;
    line.setAttribute("x1", px(x));
    line.setAttribute("x2", px(x));
    readout.replaceChildren(...series.map((s) => {
      const value = s.y[nearest(s.x, x)];
      return el("span", { class: "ink" + rigInk(s.rig) }, el("i", { class: "swatch", "aria-hidden": "true" }), el("span", {}, number(value, 3)));
    }));
  }
  const scrub = (event) => {
    const box = canvas.getBoundingClientRect();
    const x = low + (event.clientX - box.left - plotBox.left) / (width - plotBox.left - plotBox.right) * (high - low);
    onscrub(Math.min(high, Math.max(low, x)));
  };
  canvas.addEventListener("pointerdown", (event) => {
    if (event.button !== 0) return;
    canvas.setPointerCapture(event.pointerId);
    scrub(event);
    canvas.addEventListener("pointermove", scrub);
  });
  for (const end of ["pointerup", "pointercancel"]) canvas.addEventListener(end, () => canvas.removeEventListener("pointermove", scrub));
  new ResizeObserver(([entry]) => {
    const now = Math.round(entry.contentRect.width);
    if (now > 0 && now !== width) {
      width = now;
      draw();
    }
  }).observe(canvas);
  return { node, cursor, px: (x) => px(x) };
}

/** Index of the entry of the rising list `xs` that is closest to `x`. */
function nearest(xs, x) {
  let best = 0;
  for (let i = 1; i < xs.length; ++i) if (Math.abs(xs[i] - x) < Math.abs(xs[best] - x)) best = i;
  return best;
}
