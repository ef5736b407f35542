// Puts the page together: header, theme, keys, help, and the address it was opened with.
function stored(key, value) {
  try {
    if (value === undefined) return localStorage.getItem(key);
    localStorage.setItem(key, value);
  } catch {
    // Some browsers give pages from file:// no storage: the choice then lasts as long as the page.
  }
  return null;
}

const dark = window.matchMedia("(prefers-color-scheme: dark)");
function theme(choice) {
  document.documentElement.dataset.theme = choice ?? stored("backbend.theme") ?? (dark.matches ? "dark" : "light");
}
function otherTheme() {
  const next = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
  stored("backbend.theme", next);
  theme(next);
}
theme();
dark.addEventListener("change", () => theme());
window.addEventListener("beforeprint", () => { document.documentElement.dataset.theme = "light"; });
window.addEventListener("afterprint", () => theme());

const noticeLine = el("p", { class: "notice", role: "alert", hidden: true });
function notice(text) {
  noticeLine.textContent = text;
  noticeLine.hidden = false;
}

const shortcuts = { on: stored("backbend.keys") !== "off" };
const keyList = [["/", "search the findings"], ["j  k", "next, previous finding"], ["Enter", "look at the marked finding"],
  ["1 … 5", "side by side, slider, blink, difference, heat"], ["+  −  0", "zoom in, out, whole picture (on pictures)"],
  ["← →", "move the scrubber, or go through findings when one is open"], ["t", "dark or light"], ["Esc", "close"], ["?", "these keys"]];
const help = el("dialog", { id: "help", "aria-labelledby": "help-title" },
  el("h2", { id: "help-title" }, "Keys"),
  el("dl", { class: "keys" }, keyList.map(([key, what]) => el("div", {}, el("dt", {}, el("kbd", {}, key)), el("dd", {}, what)))),
  el("p", {}, "Search also takes numbers: ", code("excess>2"), ", ", code("control<=60"), ", ", code("pixels>100"), ", or any number of a finding's geometry."),
  el("p", {}, el("label", {}, el("input", { type: "checkbox", checked: shortcuts.on, onchange: (e) => { shortcuts.on = e.target.checked; stored("backbend.keys", shortcuts.on ? "on" : "off"); } }), " single-key shortcuts")),
  el("button", { type: "button", onclick: () => help.close() }, "close"));

const solid = meshSection();
const sections = [headroomTiles(), worstSection(), compareSection(), pairsSection(), solid, sweepSection()];
const findingsNode = findingsSection();
sections.push(findingsNode, approvals, mapSection(), trendSection(), rigsSection(), searchedSection(), trustSection(), coverageSection(), mediaSection(), characterSection(), aboutSection());
const links = { headroom: "headroom", worst: "worst", compare: "compare", pairs: "side by side", solid: "3D", sweeps: "sweeps", findings: "findings", approve: "accept", map: "map", trend: "trend", rigs: "rigs", searched: "searched",
  trust: "trust", coverage: "coverage", media: "media", characters: "characters", about: "about" };
const present = sections.filter(Boolean);
const navigation = el("nav", { "aria-label": "sections" }, present.map((s) => el("a", { href: "#" + s.id }, links[s.id])));
for (const s of present) {
  if (!routes.has(s.id)) routes.set(s.id, () => { closeFinding(); s.scrollIntoView(); });
}

document.getElementById("page").replaceWith(
  el("a", { class: "skip", href: "#findings" }, "skip to the findings"),
  el("header", { class: "top" }, el("span", { class: "brand" }, "backbend"), navigation,
    el("span", { class: "tools" },
      el("button", { type: "button", class: "quiet", onclick: otherTheme, title: "dark or light (t)" }, "theme"),
      el("button", { type: "button", class: "quiet", onclick: () => help.showModal(), title: "keys (?)" }, "keys"))),
  el("main", {}, noticeLine, verdictBand(), present),
  dialog, help, live);
findingsNode.begin();
solid?.begin();

document.addEventListener("keydown", (event) => {
  if (!shortcuts.on || event.ctrlKey || event.metaKey || event.altKey || dialog.open || help.open) return;
  if (event.target.closest("input:not([type=range]):not([type=checkbox]):not([type=radio]), select, textarea")) return;
  if (event.key === "/") {
    findingsNode.scrollIntoView();
    findingsNode.search.focus();
  } else if (event.key === "j") findingsNode.move(1);
  else if (event.key === "k") findingsNode.move(-1);
  else if (event.key === "t") otherTheme();
  else if (event.key === "?") help.showModal();
  else return;
  event.preventDefault();
});

// The section in sight is marked in the header.
const watcher = new IntersectionObserver((entries) => {
  for (const entry of entries) entry.target.inSight = entry.isIntersecting;
  const first = present.find((s) => s.inSight);
  for (const link of navigation.children) {
    if (first && link.getAttribute("href") === "#" + first.id) link.setAttribute("aria-current", "true");
    else link.removeAttribute("aria-current");
  }
}, { rootMargin: "-80px 0px -50% 0px" });
present.forEach((s) => watcher.observe(s));

window.addEventListener("hashchange", follow);
if (location.hash) follow();
