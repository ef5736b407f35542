// One finding, or one pair of pictures, over the whole page: pictures on the left, facts on the right.
const viewer = stage({ wheel: true });
const viewed = { list: report.findings, finding: null };

const dialogTitle = el("h2", { id: "case-title" });
const dialogFacts = el("div", { class: "case-facts" });
const dialogPlots = el("div", { class: "plots" });
const pictureChoice = el("span", { class: "picks" });
const previous = el("button", { type: "button", class: "quiet", onclick: () => step(-1), "aria-label": "previous finding", title: "previous finding (k)" }, "‹");
const next = el("button", { type: "button", class: "quiet", onclick: () => step(1), "aria-label": "next finding", title: "next finding (j)" }, "›");
const position = el("span", { class: "soft num" });
const dialog = el("dialog", { id: "case", "aria-labelledby": "case-title", oncancel: (event) => { event.preventDefault(); closeFinding(); } },
  el("header", {}, previous, next, position, dialogTitle, pictureChoice,
    el("button", { type: "button", class: "quiet close", onclick: () => closeFinding(), "aria-label": "close" }, "close")),
  el("div", { class: "case-body" }, el("div", { class: "case-left" }, viewer.node, dialogPlots), dialogFacts));

/** Two menus that say which pictures stand left and right. */
function pickers(pictures, left, right) {
  const pick = (label, value, onchange) => el("label", {}, label + " ", el("select", { "aria-label": label, onchange },
    pictures.filter((p) => p.key !== "heat").map((p) => el("option", { value: p.key, selected: p.key === value }, visible(p.label)))));
  const of = (key) => pictures.find((p) => p.key === key);
  viewer.node.hidden = pictures.length === 0;
  const update = () => viewer.show({ a: of(left), b: of(right), heat: of("heat") });
  pictureChoice.replaceChildren(...(pictures.filter((p) => p.key !== "heat").length > 2 ? [
    pick("left", left, (e) => { left = e.target.value; update(); }),
    pick("right", right, (e) => { right = e.target.value; update(); })] : []));
  update();
}

function row(label, ...content) {
  return content.flat().some((c) => c != null && c !== false && c !== "") && el("div", {}, el("dt", {}, label), el("dd", {}, content));
}
function imageFacts(image) {
  if (image === "not_measured") return row("pictures", "not measured");
  if (!image.measured) return row("pictures", "not measured: ", name(image.note));
  return row("pictures", image.visible ? "visible" : "not visible", ", ", name(image.camera), ": ",
    name(image.metric), " " + number(image.value), image.threshold != null && " against " + number(image.threshold),
    ", " + number(image.pixels) + " px changed", image.note && [", ", name(image.note)]);
}
function scaleBar(finding) {
  const { value, limit } = finding;
  if (value == null || limit == null || value < 0 || limit <= 0) return null;
  const end = Math.max(value, limit) * 1.1;
  return el("span", { class: "measure", "aria-hidden": "true", "--value": value / end * 100 + "%", "--limit": limit / end * 100 + "%" });
}

const solidAt = (finding) => meshViews.findIndex((m) => report.findings[m.finding] === finding);

const cureWords = new Map([
  ["repair", ["Repair", "Changes these weights, measures all poses again, keeps only what makes no check worse, and says what is left. Add --dry-run to look first."]],
  ["tune", ["Tune", "Searches this rig's options for more headroom at little change of shape, measures each choice, and shows a few. Add --dry-run to see what would be varied."]],
  ["export", ["Export", "Writes the spine even as a native rig on these joints, for Blender; --to maya and --to json are the others."]],
]);
/** A command that may cure the finding, and what was measured that speaks for it. */
function cureOf(cure) {
  const [title, means] = cureWords.get(cure.command.split(" ")[1]) ?? ["Cure", ""];
  return el("div", { class: "reproduce" }, el("h3", {}, title), el("p", { class: "soft" }, means),
    cure.gives && el("p", { class: "gives" }, "Measured: ", name(cure.gives), "."),
    el("pre", {}, visible(cure.command)), copyButton(cure.command, "copy " + title.toLowerCase() + " command"));
}

function factsOf(finding) {
  const check = checkOf.get(finding.code);
  const series = seriesOf(finding);
  return [
    el("p", { class: "facts" }, badge(standing(finding)), finding.owner !== "none" && el("span", { class: "owner" }, finding.owner),
      el("span", { class: "num value" }, limitText(finding))),
    scaleBar(finding),
    el("p", { class: "detail" }, name(finding.detail)),
    el("dl", {},
      row("rig", rigLabel(finding)), row("character", name(finding.character)),
      row("pose", name(finding.pose), finding.frame != null && " (frame " + finding.frame + ")"),
      row("place", placeText(finding), placeNumbers(finding) && placeNumbers(finding) !== placeText(finding) && el("span", { class: "soft" }, " (" + placeNumbers(finding) + ")")),
      row("range", finding.inside_envelope ? "in the required range" : "outside the required range: shown, does not decide"),
      imageFacts(finding.image),
      Object.keys(finding.geometry).length > 0 && row("geometry", el("table", { class: "plain" }, el("tbody", {},
        Object.entries(finding.geometry).map(([key, value]) => el("tr", {}, el("th", { scope: "row" }, name(key)), el("td", { class: "num" }, number(value, 8))))))),
      check && row("check", name(check.measures), check.limit != null && "; default limit " + quantity(check.limit, check.unit), check.reason && ["; ", name(check.reason)])),
    finding.reproduce && el("div", { class: "reproduce" }, el("h3", {}, "See it again"), el("pre", {}, visible(finding.reproduce)), copyButton(finding.reproduce, "copy command")),
    ...(finding.cures ?? []).map(cureOf),
    ...Object.entries(finding.artist ?? {}).map(([program, line]) => el("div", { class: "reproduce" }, el("h3", {}, "Your rig in this pose: ", name(program)),
      el("pre", {}, visible(line)), copyButton(line, "copy line for " + visible(program)))),
    mayApprove(finding) && tick(finding),
    el("p", { class: "links" }, solidAt(finding) >= 0 && el("a", { href: "#mesh/" + solidAt(finding) }, "turn it in 3D"), series && el("a", { href: sweepAddress(finding.character, finding.mapping, finding.sweep, finding.control_deg) }, "show in its sweep"),
      copyButton(location.href.split("#")[0] + "#finding/" + addressOf.get(finding), "copy link"))];
}

/** The finding's sweep under the pictures, with the cursor where it was found. */
function plotsOf(finding) {
  const series = finding && seriesOf(finding);
  if (!series) return [];
  const plots = plotsOfSweep(series, (x) => go(sweepAddress(finding.character, finding.mapping, finding.sweep, x)));
  for (const one of plots) one.cursor(finding.control_deg);
  return plots.map((one) => one.node);
}

function showFinding(finding) {
  viewed.finding = finding;
  dialogTitle.replaceChildren(...findingTitle(finding).flat());
  dialogFacts.replaceChildren(...factsOf(finding).filter(Boolean));
  dialogPlots.replaceChildren(...plotsOf(finding));
  const at = viewed.list.indexOf(finding);
  previous.hidden = next.hidden = position.hidden = at < 0 || viewed.list.length < 2;
  previous.disabled = at <= 0;
  next.disabled = at + 1 >= viewed.list.length;
  position.textContent = at + 1 + " of " + viewed.list.length;
  const pictures = picturesOf(finding);
  const has = (key) => pictures.some((p) => p.key === key);
  const left = has("before") ? "before" : "after";
  pickers(pictures, left, left === "before" && has("after") ? "after" : "other");
  openDialog();
  announce(visible(finding.code + " " + finding.pose));
}

function showPair(pair) {
  viewed.finding = null;
  dialogTitle.replaceChildren(name(pair.title));
  previous.hidden = next.hidden = position.hidden = true;
  const finding = report.findings[pair.finding] ?? report.findings.find((f) => f.pictures.before === pair.a_path && f.pictures.after === pair.b_path);
  dialogFacts.replaceChildren(el("p", { class: "detail" }, name(pair.caption)), ...(finding ? factsOf(finding).filter(Boolean) : []));
  dialogPlots.replaceChildren(...plotsOf(finding));
  pictureChoice.replaceChildren();
  viewer.node.hidden = false;
  const picture = (path, label) => path ? { path, label, alt: pair.title + ", " + label } : undefined;
  viewer.show({ a: picture(pair.a_path, pair.a_label), b: picture(pair.b_path, pair.b_label), heat: picture(pair.heat_path, "heat map") });
  openDialog();
}

let openedFrom = null;
function openDialog() {
  if (dialog.open) return;
  openedFrom = document.activeElement;
  dialog.showModal();
}
function closeFinding() {
  if (!dialog.open) return;
  dialog.close();
  viewer.stop();
  if (/^#(finding|pair)\//.test(location.hash)) note("#findings");
  if (openedFrom?.isConnected) openedFrom.focus({ preventScroll: true });
}
function step(by) {
  const to = viewed.list[viewed.list.indexOf(viewed.finding) + by];
  if (viewed.finding && to) go("#finding/" + addressOf.get(to), true);
}

routes.set("finding", (parts) => {
  const address = parts.join("/");
  const finding = findingAt.get(address) ?? [...findingAt].find(([key]) => decoded(key) === decoded(address))?.[1];
  if (finding) return showFinding(finding);
  closeFinding();
  notice("This report has no such finding: " + visible(decoded(address)));
});
routes.set("pair", ([index]) => {
  const pair = report.pairs[Number(index)];
  if (pair) showPair(pair);
  else notice("This report has no such pair.");
});

dialog.addEventListener("keydown", (event) => {
  if (event.target.closest("input, select, textarea") || event.ctrlKey || event.metaKey || event.altKey || !shortcuts.on) return;
  const mode = stageModes[Number(event.key) - 1];
  if (event.key === "j" || event.key === "ArrowRight") step(1);
  else if (event.key === "k" || event.key === "ArrowLeft") step(-1);
  else if (mode) viewer.set(mode[0]);
  else return;
  event.preventDefault();
});
