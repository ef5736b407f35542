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
      figure(n.fail, "baseline" in report.provenance ? "new or worse" : "inside the envelope", n.fail ? "bad" : "", "#findings?standing=fail"),
      figure(n.stress, "beyond it", "", "#findings?standing=stress"),
      figure(n.waived, "waived", "", "#findings?standing=waived"),
      figure(n.notMeasured, "not measured", n.notMeasured ? "warn" : "", "#coverage"),
      figure(n.reference, "on references", "", "#findings?role=reference"),
      figure(report.canaries.length ? ok + "/" + report.canaries.length : "–",
        report.canaries.length ? "canaries did their duty" : "no canary ran", ok < report.canaries.length ? "bad" : "", "#trust")));
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
  const tile = ([channel, rows]) => {
    const order = (h) => h.measured && h.headroom_deg != null ? h.headroom_deg : -Infinity;
    rows.sort((a, b) => order(a.h) - order(b.h));
    const h = rows[0].h;
    const shown = rows.slice(0, 3);
    return el("div", { class: "tile" + (falls(h) ? " short" : "") },
      el("h3", {}, name(channel)),
      el("p", { class: "room" }, h.measured ? signed(h.headroom_deg) + "°" : "not measured",
        falls(h) && el("span", { class: "falls" }, h.measured ? " short" : "")),
      headroomSpark(rows[0].rig, channel),
      shown.map((row) => el("div", { class: "row" }, el("span", { class: "who" }, who(row)), bullet(row.h),
        el("span", { class: "num" }, "clean to ", el("b", {}, cleanText(row.h)), ", needs ", number(row.h.needs_deg)))),
      rows.length > 3 && el("a", { href: "#rigs" }, plural(rows.length - 3, "more row")));
  };
  const cornered = rigs.filter((rig) => rig.corners && (rig.corners.needed || rig.corners.poses > 0));
  const open = (rig) => rig.corners.poses === 0 || rig.corners.clean < rig.corners.poses;
  const share = (c) => c.poses === 0 ? "not measured" : Math.floor(100 * c.clean / c.poses) + " %";
  const cornerTile = () => {
    const rows = [...cornered].sort((a, b) => a.corners.clean_percent - b.corners.clean_percent);
    return el("div", { class: "tile" + (open(rows[0]) ? " short" : "") },
      el("h3", {}, "corners"),
      el("p", { class: "room" }, share(rows[0].corners), open(rows[0]) && el("span", { class: "falls" }, " short")),
      rows.slice(0, 3).map((rig) => el("div", { class: "row" }, el("span", { class: "who" }, who({ rig })),
        el("span", { class: "num" }, `${rig.corners.clean} of ${plural(rig.corners.poses, "pose")} clean`,
          rig.corners.worst && ", worst: " + visible(rig.corners.worst)))));
  };
  return section("headroom", "Headroom of the proposed rig" + (severalRigs ? "s" : ""),
    el("div", { class: "tiles" }, [...channels].map(tile), cornered.length > 0 && cornerTile()));
}

function picturesOf(finding) {
  const p = finding.pictures, what = finding.rig + " at " + finding.pose;
  const both = p.before && p.after, otherRig = p.other_rig || "other rig";
  const all = [];
  const add = (key, path, label, alt) => { if (path) all.push({ key, path, label, alt }); };
  add("before", p.before, both ? "before" : finding.rig, what + (both ? ", before" : ""));
  add("after", p.after, both ? "after" : finding.rig, what + (both ? ", after" : ""));
  add("other", p.other, otherRig, otherRig + " at " + finding.pose);
  add("heat", p.heat, "heat map", "heat map of " + what);
  return all;
}

function findingTitle(finding) {
  return [code(finding.code), " ", name(checkName(finding)), " ", el("span", { class: "at" }, name(finding.pose))];
}
function limitText(finding) {
  if (finding.value == null) return "not measured";
  if (finding.limit == null) return quantity(finding.value, finding.unit);
  const sign = finding.value > finding.limit ? ">" : finding.value < finding.limit ? "<" : "=";
  return number(finding.value) + " " + sign + " " + quantity(finding.limit, finding.unit);
}
function seenText(finding) {
  const image = finding.image;
  if (image === "not_measured" || !image.measured) return "image not measured";
  if (!image.visible) return "not visible in pictures";
  return "visible: " + number(image.pixels) + " px, " + visible(image.camera);
}

function worstCard(finding, large) {
  const pictures = picturesOf(finding).filter((p) => p.key === "before" || p.key === "after" || (p.key === "other" && large));
  const href = "#finding/" + addressOf.get(finding);
  const shown = large ? (pictures.length > 2 ? pictures.slice(0, 2) : pictures) : pictures.slice(-1);
  return el("article", { class: "card" + (large ? " large" : "") + (shown.length ? "" : " bare") },
    shown.length > 0 && el("a", { class: "frames", href },
      shown.map((p) => el("span", { class: "frame" }, image(p.path, p.alt),
        large && el("span", { class: "tag left" }, visible(p.label))))),
    el("div", { class: "text" },
      el("h3", {}, el("a", { href }, findingTitle(finding))),
      el("p", { class: "facts" }, badge(standing(finding)), el("span", { class: "num value" }, limitText(finding)),
        finding.owner !== "none" && el("span", { class: "owner" }, finding.owner), placeText(finding) && el("span", {}, placeText(finding)),
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
