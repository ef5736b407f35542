// How metrics went over the nights: sparks in the headroom tiles, and a table with every lasting change.
const trendKey = (x, metric) => JSON.stringify([x.character, x.rig, x.mapping, metric]);
const trendOf = new Map(report.trends.map((trend) => [trendKey(trend, trend.metric), trend]));

/** The last `nights` values as a line, broken where nothing was measured; a dot is tonight, ticks are steps. */
function spark(trend, nights, width = 120, height = 24) {
  const from = Math.max(0, trend.value.length - nights), values = trend.value.slice(from);
  const known = values.filter((v) => v != null);
  if (known.length === 0) return null;
  const low = Math.min(...known), span = Math.max(...known) - low;
  const x = (i) => 3 + (width - 6) * (values.length > 1 ? i / (values.length - 1) : 1);
  const y = (v) => span > 0 ? height - 4 - (height - 8) * (v - low) / span : height / 2;
  const steps = trend.steps.filter((s) => s.night >= from);
  const label = values.length + " nights, from " + number(Math.min(...known)) + " to " + number(Math.max(...known)) + ", last " + number(values.at(-1)) +
    (steps.length ? "; " + plural(steps.length, "step") : "");
  return svg("svg", { class: "spark", viewBox: "0 0 " + width + " " + height, role: "img", "aria-label": label },
    steps.map((s) => svg("line", { class: s.worse ? "worse" : "better", x1: x(s.night - from), x2: x(s.night - from), y1: 1, y2: height - 1 })),
    svg("path", { d: linePath(values.map((v, i) => x(i)), values.map((v) => v == null ? null : y(v))) }),
    values.at(-1) != null && svg("circle", { cx: x(values.length - 1), cy: y(values.at(-1)), r: 2.5 }));
}

/** A tile's spark: its channel's headroom over the last thirty nights. */
function headroomSpark(rig, channel) {
  const trend = trendOf.get(trendKey(rig, "headroom " + channel));
  return trend && trend.value.length > 1 ? spark(trend, 30) : null;
}

function stepText(trend, step) {
  const much = number(step.before) + " → " + quantity(step.after, trend.unit);
  return el("li", {}, el("span", { class: "badge " + (!step.worse ? "pass" : step.recovered ? "waived" : "fail") }, step.worse ? "✕ worse" : "✓ better"), " ",
    el("span", { class: "num" }, much), " from ", name(step.version),
    step.last_before && el("span", { class: "soft" }, ", last before ", name(step.last_before)),
    step.recovered && [", recovered at ", name(step.recovered)]);
}

function trendSection() {
  if (report.trends.length === 0) return null;
  const several = new Set(report.trends.map((t) => t.character)).size > 1;
  const line = (trend) => el("tr", {}, several && el("td", {}, name(trend.character)), el("td", {}, rigLabel(trend)), el("th", { scope: "row" }, name(words(trend.metric))),
    el("td", {}, spark(trend, report.nights.length, 240)), el("td", { class: "num" }, quantity(trend.value.at(-1), trend.unit)),
    el("td", {}, trend.steps.length ? el("ul", {}, trend.steps.map((s) => stepText(trend, s))) : el("span", { class: "soft" }, "steady")));
  const heads = [...(several ? ["character"] : []), "rig", "metric", plural(report.nights.length, "night"), "tonight", "lasting changes"];
  const moved = report.trends.filter((t) => t.steps.length > 0), steady = report.trends.filter((t) => t.steps.length === 0);
  return section("trend", "Trend",
    el("p", { class: "soft" }, "From ", name(report.nights[0]), " to ", name(report.nights.at(-1)), ". A step is a lasting change, named by the night and version where it began."),
    moved.length > 0 ? table("plain trend", heads, moved.map(line), "metrics that changed") : el("p", {}, "No lasting change."),
    steady.length > 0 && steadyTrends());

  // A studio's night has thousands of them: made when somebody looks.
  function steadyTrends() {
    const node = el("details", { ontoggle: () => {
      if (node.open && node.children.length === 1) node.append(table("plain trend", heads, steady.map(line), "steady metrics"));
    } }, el("summary", {}, plural(steady.length, "steady metric")));
    return node;
  }
}
