// Where in pose space a rig was looked at, and where it fails: bending against side and twist.
const mapAxes = [["side", "side"], ["twist", "twist"]];
const bendOf = (at) => (at.extension ?? 0) - (at.flexion ?? 0);

/** Degrees of each channel at a control angle of a sweep, between its poses too; null where the report does not say. */
function channelsAt(series, control) {
  const all = Object.entries(series.pose_deg), at = series.control_deg;
  if (!all.length || control == null || !at.length) return null;
  const rising = at[at.length - 1] >= at[0];
  const next = at.findIndex((c) => (rising ? c >= control : c <= control)), j = next < 0 ? at.length - 1 : next, i = Math.max(0, j - 1);
  const share = i === j || next < 0 ? 1 : (control - at[i]) / (at[j] - at[i]);
  return Object.fromEntries(all.map(([channel, deg]) => [channel, deg[i] + (deg[j] - deg[i]) * share]));
}

function poseMap(rig, findings, [across, label]) {
  const size = 260, edge = 34;
  const poses = rig.sweeps.flatMap((s) => s.control_deg.map((c) => channelsAt(s, c))).filter(Boolean);
  const marked = findings.map((f) => {
    const series = rig.sweeps.find((s) => s.sweep === f.sweep);
    return { f, at: series && channelsAt(series, f.control_deg) };
  }).filter((m) => m.at);
  const value = { x: (at) => at[across] ?? 0, y: bendOf };
  const need = (channel) => rig.headroom.find((h) => h.channel === channel)?.needs_deg ?? 0;
  const reach = (of, needs) => Math.max(30, ...needs, ...poses.map((p) => Math.abs(of(p))), ...marked.map((m) => Math.abs(of(m.at))));
  const rx = reach(value.x, [need(across)]), ry = reach(value.y, [need("extension"), need("flexion")]);
  const px = (v) => edge + (v / rx + 1) / 2 * (size - edge - 10), py = (v) => 10 + (1 - v / ry) / 2 * (size - edge - 10);
  const ticksOf = (r) => angleTicks(-r, r);
  const worst = { fail: 0, not_measured: 1, waived: 2, stress: 3 };
  marked.sort((a, b) => (worst[b.f.verdict] ?? 4) - (worst[a.f.verdict] ?? 4));
  const title = (f) => visible(f.code + " " + f.pose) + ": " + words(standing(f));
  return el("figure", { class: "map" }, el("figcaption", {}, el("b", {}, "bend × " + label), " ", el("span", { class: "soft" }, plural(poses.length, "pose") + ", " + plural(marked.length, "finding"))),
    svg("svg", { viewBox: "0 0 " + size + " " + size, role: "group", "aria-label": "bend against " + label },
      svg("rect", { class: "envelope", x: px(-need(across)), width: px(need(across)) - px(-need(across)), y: py(need("extension")), height: py(-need("flexion")) - py(need("extension")) }),
      ticksOf(rx).map((a) => [svg("line", { class: "grid", x1: px(a), x2: px(a), y1: 10, y2: size - edge + 10 }), svg("text", { x: px(a), y: size - 8, "text-anchor": "middle" }, number(a))]),
      ticksOf(ry).map((a) => [svg("line", { class: "grid", x1: edge, x2: size - 10, y1: py(a), y2: py(a) }), svg("text", { x: edge - 5, y: py(a) + 3.5, "text-anchor": "end" }, number(a))]),
      poses.map((p) => svg("circle", { class: "pose", cx: px(value.x(p)), cy: py(value.y(p)), r: 1.3 })),
      marked.slice(-200).map(({ f, at }) => svg("a", { href: "#finding/" + addressOf.get(f), "aria-label": title(f) },
        svg("circle", { class: "mark " + standing(f), cx: px(value.x(at)), cy: py(value.y(at)), r: 5 }, svg("title", {}, title(f)))))));
}

function mapSection() {
  const rigs = report.rigs.filter((rig) => rig.role !== "canary" && rig.sweeps.some((s) => Object.keys(s.pose_deg).length > 0));
  if (rigs.length === 0) return null;
  const several = new Set(rigs.map((rig) => rig.character)).size > 1;
  const maps = el("div", { class: "maps" });
  const show = (rig) => maps.replaceChildren(...mapAxes.map((axis) => poseMap(rig, report.findings.filter((f) => rigKey(f) === rigKey(rig) && f.verdict !== "pass"), axis)));
  const pick = el("select", { "aria-label": "rig on the map", onchange: () => show(rigs[pick.selectedIndex]) },
    rigs.map((rig) => el("option", {}, visible([several && rig.character, rig.rig, rig.mapping].filter(Boolean).join(" ")))));
  const first = worst(1)[0], at = rigs.findIndex((rig) => first && rigKey(rig) === rigKey(first));
  pick.selectedIndex = Math.max(0, at);
  show(rigs[pick.selectedIndex]);
  return section("map", "Pose space", el("p", { class: "soft" }, "Up is extension, down is flexion, degrees. Small dots were measured and are clean; the shaded box is what the envelope needs. A mark opens its finding."),
    el("div", { class: "sweep-bar" }, el("label", {}, "rig ", pick)), maps);
}
