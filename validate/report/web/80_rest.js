// Rigs compared, what may be trusted, what was covered, media, and where it all came from.
function table(className, heads, rows, caption) {
  return el("div", { class: "wide", tabindex: 0, role: "region", "aria-label": "table: " + caption }, el("table", { class: className }, el("caption", { class: "unseen" }, caption),
    el("thead", {}, el("tr", {}, heads.map((head) => el("th", { scope: "col" }, head)))), el("tbody", {}, rows)));
}

function rigsSection() {
  if (report.rigs.length === 0) return null;
  const rigs = report.rigs.filter((rig) => rig.role !== "canary");
  const channels = [...new Set(rigs.flatMap((rig) => rig.headroom.map((h) => h.channel)))];
  const metrics = [...new Set(rigs.flatMap((rig) => Object.keys(rig.summary)))].sort();
  const several = new Set(rigs.map((rig) => rig.character)).size > 1;
  const unit = new Map(rigs.flatMap((rig) => rig.sweeps.flatMap((s) => Object.entries(s.metric_unit))));
  const rows = rigs.map((rig) => el("tr", { class: rig.role },
    several && el("td", {}, name(rig.character)),
    el("th", { scope: "row" }, rigLabel(rig), rig.system !== rig.rig && el("span", { class: "soft" }, " ", name(rig.system)),
      Object.keys(rig.options).length > 0 && el("details", {}, el("summary", {}, "options"), el("ul", {}, Object.entries(rig.options).map(([key, value]) => el("li", {}, name(key), " = ", name(value)))))),
    el("td", {}, rig.role), el("td", {}, badge(rig.verdict)),
    channels.map((channel) => {
      const h = rig.headroom.find((one) => one.channel === channel);
      return el("td", { class: "channel" }, h ? [bullet(h), el("span", { class: "num" + (falls(h) ? " over" : "") }, el("b", {}, cleanText(h)), h.measured && el("span", { class: "soft" }, " " + signed(h.headroom_deg)))] : "–");
    }),
    metrics.map((metric) => el("td", { class: "num" }, number(own(rig.summary, metric), 3)))));
  const label = (metric) => [name(words(metric)), unit.get(metric) && el("span", { class: "soft" }, " ", unit.get(metric) === "deg" ? "°" : name(unit.get(metric)))];
  return section("rigs", "Rigs compared",
    el("p", { class: "soft" }, "Each channel: how many degrees it is clean to, and what that leaves over the envelope's need (the tick). Each metric: its worst value over all sweeps."),
    table("compare", [...(several ? ["character"] : []), "rig", "role", "verdict", ...channels.map((c) => name(c)), ...metrics.map(label)], rows, "rigs compared"));
}

/** What was searched between the sweeps, and how much of the envelope is clean: proved and searched, each for itself. */
function searchedSection() {
  const rigs = report.rigs.filter((rig) => rig.hunt || rig.volume);
  if (rigs.length === 0) return null;
  const several = new Set(rigs.map((rig) => rig.character)).size > 1;
  // Never more than it is: 99.996 % is not all of it.
  const percent = (share) => number(Math.floor(1e4 * share + 1e-9) / 100) + " %";
  const checkText = (h) => [code(h.code), " ", name(checkOf.get(h.code)?.name ?? "", "soft"), " ", quantity(Number((h.value ?? NaN).toPrecision(4)), h.unit), " (limit ", number(h.limit), ") at ", name(h.pose)];
  const found = (hunt) => {
    if (!hunt || hunt.evaluations === 0) return "–";
    const news = hunt.worst.filter((h) => h.sweep), known = hunt.worst.filter((h) => h.over && !h.sweep);
    return [news.length > 0 ? el("ul", {}, news.map((h) => el("li", { class: "over" }, checkText(h)))) : "nothing over a limit that the sweeps do not show",
      known.length > 0 && el("p", { class: "soft" }, "over the limit as in the sweeps, which judge it: ", known.map((h) => h.code).join(", "))];
  };
  const rows = rigs.map((rig) => {
    const v = rig.volume, s = v?.searched;
    return el("tr", { class: rig.role }, several && el("td", {}, name(rig.character)), el("th", { scope: "row" }, rigLabel(rig)),
      el("td", {}, rig.hunt?.evaluations > 0 ? [plural(rig.hunt.evaluations, "pose"), el("span", { class: "soft" }, " of ", name(rig.hunt.box))] : "–",
        (rig.hunt?.notes ?? []).map((note) => el("p", { class: "soft" }, name(note)))),
      el("td", {}, found(rig.hunt)),
      el("td", { class: "num" }, s?.poses > 0 ? [`${s.clean} of ${s.poses}`, el("span", { class: "soft" }, ` (at least ${percent(s.at_least)})`)] : "–"),
      el("td", {}, !v ? "–" : v.certified ? [percent(v.certified.share), v.certified.refuted > 0 && el("span", { class: "over" }, `, refuted ${percent(v.certified.refuted)}`)]
        : el("span", { class: "soft" }, name(v.not_certified))));
  });
  return section("searched", "Searched between the sweeps",
    el("p", { class: "soft" }, "Poses that the search did not look at may fail. Random poses: how many are within every limit, and the share of the envelope's volume that is at least clean, by 95 %. Certified: the share of the volume where no joint jumps or turns faster than BB002 allows, proved of the joints alone."),
    table("plain", [...(several ? ["character"] : []), "rig", "searched", "found", "random poses clean", "joints certified"], rows, "what was searched"));
}

function trustSection() {
  const canary = (c) => el("tr", {}, el("td", {}, badge(c.ok ? "pass" : "fail")), el("th", { scope: "row" }, name(c.rig)), el("td", {}, code(c.code)), el("td", {}, name(c.joint)),
    el("td", { class: "num" }, number(c.expected_deg, 7) + " ± " + number(c.tolerance_deg)), el("td", { class: "num" }, c.found ? number(c.found_deg, 8) : "not found"),
    el("td", {}, c.twin_clean ? "clean" : el("b", { class: "over" }, "not clean")), el("td", {}, name(c.detail)));
  const calibrated = (c) => el("tr", {}, el("th", { scope: "row" }, name(c.detector)), el("td", {}, code(c.code)), el("td", {}, name(c.body)),
    el("td", { class: "num" }, quantity(c.threshold, c.threshold_unit)), el("td", { class: "num" }, c.clean_poses),
    el("td", { class: "num" + (c.false_alarms > 0 ? " over" : "") }, c.false_alarms),
    el("td", { class: "num" + (c.ok ? "" : " over") }, c.smallest == null ? "none" : quantity(c.smallest, c.unit)),
    el("td", { class: "num" }, quantity(c.target, c.unit)),
    el("td", { class: "num" }, c.compared > 0 ? c.alike + " of " + c.compared : ""), el("td", {}, badge(c.ok ? "pass" : "fail")));
  return section("trust", "Tool self-check",
    el("h3", {}, "Canaries: rigs with a known fault, which must be found, and their repaired twins, which must be clean"),
    report.canaries.length ? table("plain", ["result", "self-test", "must show", "at", "expected, °", "found, °", "twin", "what happened"], report.canaries.map(canary), "canaries")
      : el("p", { class: "over" }, "No self-test ran: nothing shows in this run that the detectors work."),
    el("h3", {}, "Detectors: the smallest planted fault found, with no false alarm"),
    report.detectors.length ? el("ul", {}, report.detectors.map((d) => el("li", {}, name(d)))) : el("p", { class: "soft" }, "Not calibrated in this run."),
    report.calibration?.length > 0 && table("plain calibration", ["detector", "check", "tried on", "alarms over", "clean poses", "of those flagged", "smallest found", "must find", "pictures and geometry alike", "verdict"], report.calibration.map(calibrated), "calibration of the detectors"));
}

function coverageSection() {
  const rigs = report.rigs.filter((rig) => rig.coverage.length > 0);
  if (rigs.length === 0) return section("coverage", "Coverage", el("p", { class: "over" }, "This report does not say what was planned."));
  const codes = [...new Set(rigs.flatMap((rig) => rig.coverage.map((c) => c.code)))].sort();
  const cell = (c) => {
    if (!c) return el("td", {}, "–");
    const sums = c.planned === c.measured + c.not_measured + c.not_applicable;
    return el("td", { class: "num" + (c.not_measured > 0 || !sums ? " over" : "") },
      c.planned > 0 && c.not_applicable === c.planned ? el("span", { class: "soft" }, "n/a") : [c.measured + "/" + c.planned,
        c.not_measured > 0 && el("span", {}, ", " + c.not_measured + " not"), c.not_applicable > 0 && el("span", { class: "soft" }, ", " + c.not_applicable + " n/a"), !sums && " does not add up"]);
  };
  const several = new Set(rigs.map((rig) => rig.character)).size > 1;
  return section("coverage", "Coverage: measured of planned",
    table("plain", [...(several ? ["character"] : []), "rig", ...codes.map((c) => [code(c), " ", name(checkOf.get(c)?.name ?? "", "soft")])],
      rigs.map((rig) => el("tr", {}, several && el("td", {}, name(rig.character)), el("th", { scope: "row" }, rigLabel(rig)),
        codes.map((c) => cell(rig.coverage.find((one) => one.code === c))))), "coverage"));
}

function mediaSection() {
  if (report.media.length === 0) return null;
  const item = (m) => {
    const path = source(m.path);
    const caption = el("figcaption", {}, el("a", { href: path || null }, name(m.title)), " ", el("span", { class: "soft" }, words(visible(m.kind))));
    if (!path) return el("figure", {}, el("p", { class: "soft" }, "not in this folder"), caption);
    // Rigs side by side need the whole width.
    return el("figure", { class: m.kind === "video" || m.kind === "review" ? "broad" : null }, m.kind === "video" || m.path.endsWith(".mp4")
      ? el("video", { src: path, controls: true, preload: "metadata", loop: true, muted: true, "aria-label": visible(m.title) })
      : el("a", { href: path }, image(m.path, m.title, { loading: "lazy" })), caption);
  };
  return section("media", "Sheets and films", el("div", { class: "media" }, report.media.map(item)));
}

function characterSection() {
  if (report.characters.length === 0) return null;
  const chain = (joints) => joints.length ? joints.map((joint, i) => [i > 0 && el("span", { class: "soft" }, " › "), name(joint)]) : el("b", { class: "over" }, "not found");
  return section("characters", "Characters as found", report.characters.map((c) => el("article", { class: "character" },
    el("h3", {}, name(c.name), " ", el("span", { class: "soft" }, name(c.file))),
    el("dl", {}, row("body", plural(c.meshes, "mesh", "meshes") + ", " + c.vertices.toLocaleString("en") + " vertices, " + c.triangles.toLocaleString("en") + " triangles, " + plural(c.joints, "joint")),
      row("size", number(c.height) + " m tall, spine " + number(c.spine_length) + " m"),
      row("spine", chain(c.spine), c.sure ? " (sure)" : el("b", { class: "over" }, " (uncertain: confirm with inspect --save)")),
      c.doubts.length > 0 && row("doubts", el("ul", {}, c.doubts.map((doubt) => el("li", {}, name(doubt))))),
      row("arms", c.arms.left.length + c.arms.right.length ? [chain(c.arms.left), " and ", chain(c.arms.right)] : el("span", { class: "soft" }, "none")), row("envelope", name(c.envelope)), row("file", code(c.hash)),
      c.notes.length > 0 && row("notes", el("ul", {}, c.notes.map((note) => el("li", {}, name(note)))))))));
}

function aboutSection() {
  const check = (c) => el("tr", {}, el("th", { scope: "row" }, code(c.code), " ", name(c.name)), el("td", {}, name(c.measures)), el("td", { class: "num" }, c.limit == null ? "–" : quantity(c.limit, c.unit)), el("td", {}, name(c.reason)));
  return section("about", "Checks, provenance, next",
    report.checks.length > 0 && table("plain legend", ["check", "what is measured", "default limit", "why there"], report.checks.map(check), "table of checks"),
    el("h3", {}, "Provenance"),
    el("dl", { class: "provenance" }, row("suite", name(report.suite)), row("exit code", String(report.exit_code)),
      Object.entries(report.provenance).map(([key, value]) => row(name(key), code(value)))),
    report.next.length > 0 && [el("h3", {}, "What to type next"), el("ul", { class: "commands" }, report.next.map((command) => el("li", {}, code(command), copyButton(command, "copy"))))]);
}
