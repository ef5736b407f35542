// Two sides pose by pose: who is better where, and what speaks most against each.
const markOf = { "+": "a", "-": "b", x: "mixed", "=": "same", "?": "unpaired" };

/** What a mark says in words. */
function markText(c, mark) {
  return { a: c.a + " is better", b: c.b + " is better", mixed: "each is better in something", same: "neither has a fault less", unpaired: "without a partner" }[markOf[mark]];
}

/** One map for each twist of the grid: extension upwards, side across, a square a pose. */
function compareMaps(c) {
  const grid = c.sweeps.filter((s) => s.sweep.startsWith("grid ") && s.pose_deg.side && s.pose_deg.twist && s.pose_deg.extension);
  const of = (key) => [...new Set(grid.flatMap((s) => s.pose_deg[key].map(Math.round)))].sort((x, y) => x - y);
  const sides = of("side"), twists = of("twist"), bends = of("extension");
  if (grid.length === 0) return null;
  const cell = 18, edge = 34;
  const map = (twist) => {
    const shown = grid.filter((s) => Math.round(s.pose_deg.twist[0]) === twist);
    const squares = shown.flatMap((s) => [...s.marks].map((mark, i) => {
      const side = Math.round(s.pose_deg.side[i]), bend = Math.round(s.pose_deg.extension[i]);
      const text = "extension " + bend + ", side " + side + ", twist " + twist + ": " + markText(c, mark);
      const x = edge + sides.indexOf(side) * cell, y = (bends.length - 1 - bends.indexOf(bend)) * cell;
      return svg("g", { class: "mark " + markOf[mark] }, svg("title", {}, visible(text)),
        svg("rect", { x: x + 1, y: y + 1, width: cell - 2, height: cell - 2, rx: 2 }),
        svg("text", { x: x + cell / 2, y: y + cell / 2 + 4, "text-anchor": "middle" }, mark === "=" ? "" : mark.replace("-", "−")));
    }));
    return el("figure", { class: "map compare" }, el("figcaption", {}, el("b", {}, "twist " + number(twist) + "°")),
      svg("svg", { viewBox: "0 0 " + (edge + sides.length * cell + 4) + " " + (bends.length * cell + 22), role: "img",
        "aria-label": "extension against side at twist " + twist },
        squares,
        bends.filter((b, i) => i % 2 === 0).map((b) => svg("text", { x: edge - 5, y: (bends.length - 1 - bends.indexOf(b)) * cell + cell / 2 + 4, "text-anchor": "end" }, number(b))),
        sides.map((s, i) => svg("text", { x: edge + i * cell + cell / 2, y: bends.length * cell + 14, "text-anchor": "middle" }, number(s)))));
  };
  return [el("p", { class: "soft" }, "Up is extension, across is side, degrees; a square is a pose."), el("div", { class: "maps" }, twists.map(map))];
}

function compareTable(c) {
  const rows = c.metrics.filter((m) => m.a_better + m.b_better > 0);
  if (rows.length === 0) return null;
  return el("div", { class: "wide", tabindex: 0, role: "group", "aria-label": "metrics of the comparison" }, el("table", {},
    el("thead", {}, el("tr", {}, ["check", "better", "same", "worse", "median", "counts from"].map((h, i) => el("th", { class: i > 0 && "num", scope: "col" }, h)))),
    el("tbody", {}, rows.map((m) => el("tr", {},
      el("th", { scope: "row" }, code(m.code), " ", name(words(m.metric))),
      [m.a_better, m.same, m.b_better].map((n) => el("td", { class: "num" }, String(n))),
      el("td", { class: "num" }, m.median_gain == null ? "–" : (m.median_gain > 0 ? "+" : "") + quantity(m.median_gain, m.unit)),
      el("td", { class: "num" }, quantity(m.tolerance, m.unit)))))));
}

/** The frames of both sides at the poses that speak most against one. */
function damning(c, side, poses) {
  if (poses.length === 0) return el("p", { class: "soft" }, "No pose speaks against ", name(side), ".");
  return el("div", {}, el("h4", {}, "Against ", name(side)), el("div", { class: "pairs" }, poses.map((p) => el("article", { class: "card pair" + (p.a_path ? "" : " bare") },
    p.a_path && el("span", { class: "frames" }, [[p.a_path, c.a], [p.b_path, c.b]].map(([path, who]) => el("span", { class: "frame" },
      image(path, who + " at " + p.pose, { loading: "lazy" }), el("span", { class: "tag left" }, visible(who))))),
    el("div", { class: "text" }, el("h5", {}, code(p.code), " ", name(p.pose)),
      el("p", { class: "facts" }, name(c.a), " ", el("span", { class: "num" }, quantity(p.a, p.unit)), ", ", name(c.b), " ", el("span", { class: "num" }, quantity(p.b, p.unit)),
        el("span", { class: "soft" }, " limit " + quantity(p.limit, p.unit))),
      [p.a_command, p.b_command].filter(Boolean).map((command) => el("p", { class: "command" }, code(command), copyButton(command, "copy"))))))));
}

function compareSection() {
  if (report.comparisons.length === 0) return null;
  const several = report.comparisons.length > 1;
  const title = (c) => [name(c.a), " against ", name(c.b), c.mapping && el("span", { class: "soft" }, " ", name(c.mapping)), new Set(report.comparisons.map((x) => x.character)).size > 1 && [" on ", name(c.character)]];
  const outcome = (c) => (c.paired === 0 ? "nothing could be compared" : c.ahead ? visible(c[c.ahead]) + " is ahead" : "a draw");
  const block = (c) => el("article", { class: "comparison" },
    el("p", {}, el("b", {}, outcome(c)), ": over a limit in " + c.a_over + " of " + c.paired + " paired poses against " + c.b_over +
      (c.matched == null ? "" : "; " + number(100 * c.matched) + " % of the surface matched") + (c.unpaired ? "; " + plural(c.unpaired, "pose") + " without a partner" : "")),
    el("p", { class: "tally" }, [["a", c.a_better, c.a + " better"], ["same", c.same, "neither"], ["b", c.b_better, c.b + " better"], ["mixed", c.mixed, "each in something"]].map(([kind, n, what]) =>
      el("span", { class: "mark " + kind }, el("b", {}, String(n)), " ", visible(what)))),
    c.sampled && el("p", { class: "soft" }, visible(c.sampled)),
    compareTable(c), compareMaps(c), damning(c, c.a, c.worst_of_a), damning(c, c.b, c.worst_of_b));
  const shown = el("div", { class: "comparison" });
  const show = (i) => shown.replaceChildren(el("h3", {}, title(report.comparisons[i])), block(report.comparisons[i]));
  show(0);
  const table = several && el("div", { class: "wide", tabindex: 0, role: "group", "aria-label": "comparisons" }, el("table", {},
    el("thead", {}, el("tr", {}, ["comparison", "better", "same", "worse", "mixed", "over a limit", "outcome"].map((h, i) => el("th", { scope: "col", class: i > 0 && i < 6 && "num" }, h)))),
    el("tbody", {}, report.comparisons.map((c, i) => el("tr", {},
      el("th", { scope: "row" }, el("button", { type: "button", class: "quiet", onclick: () => { show(i); announce(outcome(c)); } }, title(c))),
      [c.a_better, c.same, c.b_better, c.mixed].map((n) => el("td", { class: "num" }, String(n))),
      el("td", { class: "num" }, c.a_over + " : " + c.b_over), el("td", {}, outcome(c)))))));
  return section("compare", "Pose by pose", table, shown);
}
