// Failures that somebody accepts: ticked here, saved as a file, taken over by `backbend approve FILE`,
// which checks the hashes that stand in it.
const hashes = JSON.parse(document.getElementById("hashes").textContent);
const approved = new Set();
const mayApprove = (f) => decides(f) && f.value != null && !(f.code === "BB001" && f.inside_envelope);

/** What the file says; the order of the report. */
function approvalsText(author, reason, until) {
  return JSON.stringify({ schema: "backbend.approvals/1", report: hashes.report, suite: report.suite, author, reason, until,
    cases: report.findings.flatMap((f, i) => approved.has(f) ? [{ finding: i, hash: hashes.findings[i] }] : []) }, null, 1) + "\n";
}

function tick(finding) {
  const box = el("input", { type: "checkbox", checked: approved.has(finding), onchange: () => {
    if (box.checked) approved.add(finding);
    else approved.delete(finding);
    approvals.refresh();
  } });
  return el("label", { class: "approve" }, box, " waive");
}

const approvals = approvalsSection();
function approvalsSection() {
  const open = report.findings.filter(mayApprove);
  if (open.length === 0) return null;
  const author = el("input", { type: "text", autocomplete: "name", oninput: refresh });
  const reason = el("input", { type: "text", size: 40, oninput: refresh });
  const until = el("input", { type: "date", oninput: refresh });
  const save = el("button", { type: "button", onclick: download }, "save approvals.json");
  const command = el("code", {}, "backbend approve approvals.json --run RUN_FOLDER");
  const list = el("ul", { class: "ticked" });
  const all = el("button", { type: "button", class: "quiet", onclick: () => {
    const every = open.every((f) => approved.has(f));
    for (const f of open) if (every) approved.delete(f); else approved.add(f);
    refresh();
  } }, "all or none");
  function download() {
    const link = el("a", { download: "approvals.json", href: URL.createObjectURL(new Blob([approvalsText(author.value.trim(), reason.value.trim(), until.value)], { type: "application/json" })) });
    document.body.append(link);
    link.click();
    link.remove();
    announce("saved");
  }
  function refresh() {
    save.disabled = approved.size === 0 || !author.value.trim() || !reason.value.trim();
    list.replaceChildren(...[...approved].slice(0, 200).map((f) => el("li", {}, el("a", { href: "#finding/" + addressOf.get(f) }, findingTitle(f)), " ", el("span", { class: "num soft" }, limitText(f)))));
    heading.textContent = approved.size + " of " + plural(open.length, "failure") + " ticked";
  }
  const heading = el("output", {});
  const node = section("approve", "Accept failures",
    el("p", { class: "soft" }, "Open a finding and tick it, or take all. The file holds this report's hashes; the command refuses it for any other. From then on only new or worse fails."),
    el("div", { class: "approve-form" }, el("label", {}, "who ", author), el("label", {}, "why ", reason), el("label", {}, "until ", until), all, save, heading), list, el("p", {}, command));
  node.refresh = refresh;
  refresh();
  return node;
}
