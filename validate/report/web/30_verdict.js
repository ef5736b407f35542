// The first screen: what is judged, how far it is clean, what is worst.
function counts() {
  const proposed = report.rigs.filter((rig) => rig.role === "proposed");
  const sum = (key) => proposed.flatMap((rig) => rig.coverage).reduce((n, c) => n + c[key], 0);
  const count = (verdict) => report.findings.filter((f) => f.verdict === verdict && roleOf(f) === "proposed").length;
  return { fail: count("fail"), waived: count("waived"), stress: count("stress"),
    notMeasured: sum("not_measured"), notApplicable: sum("not_applicable"),
    reference: report.findings.filter((f) => f.verdict !== "pass" && roleOf(f) === "reference").length };
}

function verdictBand() {
  const n = counts();
  const ok = report.canaries.filter((c) => c.ok).length;
  const figure = (value, label, kind, href) => el("a", { class: "figure " + (kind || ""), href },
    el("strong", {}, value), el("span", {}, label));
  return el("section", { class: "verdict " + report.verdict, "aria-label": "verdict" },
    el("p", { class: "word" }, words(report.verdict)),
    el("div", { class: "say" },
      el("h1", {}, name(report.title)),
      report.headline !== report.title && el("p", { class: "headline" }, name(report.headline)),
      report.reasons.length > 0 && el("ul", { class: "reasons" }, report.reasons.map((r) => el("li", {}, name(r))))),
    el("div", { class: "figures" },
      // With a baseline nothing fails but what is new, or worse than approved.
      figure(n.fail, "baseline" in report.provenance ? "new or worse" : "in the required range", n.fail ? "bad" : "", "#findings?standing=fail"),
      figure(n.stress, "outside the required range", "", "#findings?standing=stress"),
      figure(n.waived, "waived", "", "#findings?standing=waived"),
      figure(n.notMeasured, "not measured", n.notMeasured ? "warn" : "", "#coverage"),
      figure(n.reference, "on comparison rigs", "", "#findings?role=reference"),
      figure(report.canaries.length ? ok + "/" + report.canaries.length : "–",
        report.canaries.length ? "self-tests passed" : "no self-test ran", ok < report.canaries.length ? "bad" : "", "#trust")));
}

/** Clean range as a bar from zero, with a tick where the envelope needs it to reach. */
function bullet(h) {
  const end = Math.max(h.tested_to_deg ?? 0, h.needs_deg ?? 0, 1);
  const part = (v) => Math.min(100, Math.max(0, (v ?? 0) / end * 100)) + "%";
  return el("span", { class: "bullet" + (falls(h) ? " short" : ""), "aria-hidden": "true",
    "--clean": h.measured ? part(h.clean_to_deg) : "0%", "--needs": part(h.needs_deg) });
}
const falls = (h) => !h.measured || h.headroom_deg == null || h.headroom_deg < 0;
const cleanText = (h) => !h.measured ? "?" :
  number(h.clean_to_deg) + (h.clean_to_deg >= h.tested_to_deg ? "+" : "");

function headroomTiles() {
  const rigs = report.rigs.filter((rig) => rig.role === "proposed");
  const channels = new Map();
  for (const rig of rigs) {
    for (const h of rig.headroom) {
      if (!channels.has(h.channel)) channels.set(h.channel, []);
      channels.get(h.channel).push({ rig, h });
    }
  }
  if (channels.size === 0) return null;
  const several = new Set(rigs.map((rig) => rig.character)).size > 1;
  const severalRigs = new Set(rigs.map((rig) => rig.rig)).size > 1;
  const who = ({ rig }) => visible([several && rig.character, severalRigs && rig.rig, rig.mapping].filter(Boolean).join(" "));
  const rowOf = (label, h, kind = "") => el("div", { class: "row" + kind }, el("span", { class: "who", title: label }, label), bullet(h),
    el("span", { class: "num" }, "clean to ", el("b", {}, cleanText(h)), ", required ", number(h.needs_deg)));
  const tile = ([channel, rows]) => {
    const order = (h) => h.measured && h.headroom_deg != null ? h.headroom_deg : -Infinity;
    rows.sort((a, b) => order(a.h) - order(b.h));
    const h = rows[0].h;
    const shown = rows.slice(0, 3);
    return el("div", { class: "tile" + (falls(h) ? " short" : "") },
      el("h3", {}, name(channel)),
      // Clean to the end of what was tested, and that is what is required: there is no figure for
      // what lies beyond.
      h.measured && h.headroom_deg === 0 && h.clean_to_deg >= h.tested_to_deg
        ? el("p", { class: "room met" }, "met", el("span", { class: "falls soft" }, " not tested further"))
        : el("p", { class: "room" }, h.measured ? signed(h.headroom_deg) + "°" : "not measured",
          falls(h) && el("span", { class: "falls" }, h.measured ? " short" : "")),
      headroomSpark(rows[0].rig, channel),
      shown.map((row) => [rowOf(who(row), row.h), ...(row.rig.beside ?? []).map((other) => {
        const h = other.headroom.find((one) => one.channel === channel);
        return h && rowOf(visible(other.system), h, " beside");
      })]),
      rows.length > 3 && el("a", { href: "#rigs" }, plural(rows.length - 3, "more row")));
  };
  const cornered = rigs.filter((rig) => rig.corners && (rig.corners.needed || rig.corners.poses > 0));
  const open = (rig) => rig.corners.poses === 0 || rig.corners.clean < rig.corners.poses;
  const share = (c) => c.poses === 0 ? "not measured" : Math.floor(100 * c.clean / c.poses) + " %";
  const cornerTile = () => {
    const rows = [...cornered].sort((a, b) => a.corners.clean_percent - b.corners.clean_percent);
    return el("div", { class: "tile" + (open(rows[0]) ? " short" : "") },
      el("h3", {}, "corners"),
      el("p", { class: "room" }, share(rows[0].corners), rows[0].corners.poses > 0 && el("span", { class: "falls" }, " clean")),
      rows.slice(0, 3).map((rig) => el("div", { class: "row" }, el("span", { class: "who" }, who({ rig })),
        el("span", { class: "poses" }, `${rig.corners.clean} of ${plural(rig.corners.poses, "pose")} clean`,
          rig.corners.worst && ", worst: " + visible(rig.corners.worst)))));
  };
  return section("headroom", "Headroom of the proposed rig" + (severalRigs ? "s" : ""),
    el("div", { class: "tiles" }, [...channels].map(tile), cornered.length > 0 && cornerTile()));
}

function picturesOf(finding) {
  const p = finding.pictures, what = finding.rig + " at " + finding.pose;
  const from = p.view ? ", " + p.view : "";
  const both = p.before && p.after, otherRig = p.other_rig || "other rig";
  const all = [];
  const add = (key, path, label, alt) => { if (path) all.push({ key, path, label, alt }); };
  add("before", p.before, both ? "before" : finding.rig + from, what + (both ? ", before" : ""));
  add("after", p.after, both ? "after" : finding.rig, what + (both ? ", after" : ""));
  add("other", p.other, otherRig, otherRig + " at " + finding.pose);
  add("heat", p.heat, p.heat_of ?? "heat map", (p.heat_of ?? "heat map") + ", " + what);
  return all;
}

function findingTitle(finding) {
  return [code(finding.code), " ", name(checkName(finding)), " ", el("span", { class: "at" }, name(finding.pose))];
}
/** As value_text in digest.h: 63° (limit 25). */
function limitText(finding) {
  const { value, limit, unit } = finding;
  if (value == null) return "not measured";
  let digits = Math.abs(value) >= 100 ? 4 : 3;
  while (limit != null && value !== limit && digits < 9 && number(value, digits) === number(limit)) ++digits;
  const text = finding.code === "BB030" ? number(value, digits) + " of rest"
    : unit === "ratio" ? "× " + number(value, digits) : unit === "count" ? number(value, digits)
    : quantity(Number(value.toPrecision(digits)), unit);
  return limit == null ? text : text + " (limit " + number(limit) + ")";
}
function seenText(finding) {
  const image = finding.image;
  if (image === "not_measured" || !image.measured) return "image not measured";
  if (!image.visible) return "not visible in pictures";
  return "visible: " + number(image.pixels) + " px, " + visible(image.camera);
}

/** Since when: the version that made the channel worse, or the pose from which the limit is passed. */
function sinceText(finding) {
  const trend = trendOf.get(trendKey(finding, "headroom " + finding.sweep));
  const step = trend?.steps.findLast((s) => s.worse && !s.recovered);
  if (step) return "since " + visible(step.version);
  const first = finding.geometry.first_deg;
  if (first == null) return "";
  // A corner's name is a pose, not a channel.
  const channel = finding.sweep.includes(" ") ? "" : visible(finding.sweep) + " ";
  return "from " + channel + number(first) + (channel ? " on" : "° of the way on");
}

function worstCard(finding, large) {
  // A flip is two pictures; anything else the close-up and its own metric as colours.
  const all = picturesOf(finding), of = (key) => all.find((p) => p.key === key);
  const pictures = of("before") && of("after") ? [of("before"), of("after")] : [of("before") ?? of("after"), of("heat") ?? of("other")].filter(Boolean);
  const href = "#finding/" + addressOf.get(finding);
  const shown = large ? pictures : pictures.slice(-1);
  return el("article", { class: "card" + (large ? " large" : "") + (shown.length ? "" : " bare") },
    shown.length > 0 && el("a", { class: "frames", href },
      shown.map((p) => el("span", { class: "frame" }, image(p.path, p.alt),
        large && el("span", { class: "tag left" }, visible(p.label))))),
    el("div", { class: "text" },
      el("h3", {}, el("a", { href }, findingTitle(finding))),
      el("p", { class: "facts" }, badge(standing(finding)), el("span", { class: "num value" }, limitText(finding)),
        placeText(finding) && el("span", { class: "where" }, placeText(finding)),
        finding.owner !== "none" && el("span", { class: "owner" }, finding.owner), sinceText(finding) && el("span", {}, sinceText(finding)),
        el("span", {}, rigLabel(finding)), el("span", { class: "soft" }, seenText(finding))),
      el("p", { class: "detail" }, name(finding.detail)),
      large && finding.reproduce && el("p", { class: "command" }, code(finding.reproduce), copyButton(finding.reproduce, "copy"))));
}
function rigLabel(x) {
  return el("span", { class: "rig ink" + rigInk(x.rig) }, el("i", { class: "swatch", "aria-hidden": "true" }),
    name(x.rig), x.mapping ? [el("span", { class: "soft" }, " "), name(x.mapping, "soft")] : null);
}

const worstTitle = (shown) => shown.length === 1 ? "What is worst" : "The worst " + ["", "", "two", "three"][shown.length];

function worstSection() {
  const shown = worst(3);
  if (shown.length === 0) return null;
  // A run without pictures gives its room to the words.
  if (shown.every((f) => picturesOf(f).length === 0)) {
    return section("worst", worstTitle(shown), el("div", { class: "worst bare" }, shown.map((f) => worstCard(f, false))));
  }
  return section("worst", worstTitle(shown),
    el("div", { class: "worst" }, worstCard(shown[0], true),
      el("div", { class: "rest" }, shown.slice(1).map((f) => worstCard(f, false)))));
}

function pairsSection() {
  if (report.pairs.length === 0) return null;
  const card = (pair, index) => el("article", { class: "card pair" },
    el("a", { class: "frames", href: "#pair/" + index },
      [["a", pair.a_path, pair.a_label], ["b", pair.b_path, pair.b_label]].filter(([, path]) => path).map(([, path, label]) =>
        el("span", { class: "frame" }, image(path, pair.title + ", " + label, { loading: "lazy" }),
          el("span", { class: "tag left" }, visible(label))))),
    el("div", { class: "text" }, el("h3", {}, el("a", { href: "#pair/" + index }, name(pair.title))), el("p", { class: "detail" }, name(pair.caption))));
  return section("pairs", "Side by side", el("div", { class: "pairs" }, report.pairs.map(card)));
}
