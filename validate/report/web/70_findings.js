// Every finding in one table. Only the rows in sight exist, so that ten thousand cost no more than
// fifty; searching goes through one prepared text per finding.
const rowHeight = 34;
const haystack = report.findings.map((f) => [f.code, checkName(f), f.character, f.rig, f.mapping, f.sweep, f.pose,
  placeText(f), placeNumbers(f), f.verdict, standing(f), f.owner, f.unit, f.detail].join("\n").toLowerCase());
const placeIn = new Map(report.findings.map((finding, i) => [finding, i]));

const columns = [
  { key: "standing", title: "verdict", cell: (f) => badge(standing(f)), sort: (f) => standing(f) },
  { key: "check", title: "check", cell: (f) => [code(f.code), " ", name(checkName(f))], sort: (f) => f.code },
  { key: "character", title: "character", cell: (f) => name(f.character), sort: (f) => f.character },
  { key: "rig", title: "rig", cell: (f) => rigLabel(f), sort: (f) => f.rig + "\n" + f.mapping },
  { key: "pose", title: "pose", cell: (f) => name(f.pose), sort: (f) => f.sweep, then: (f) => f.control_deg },
  { key: "place", title: "place", cell: (f) => name(placeText(f)), sort: (f) => placeText(f) },
  { key: "value", title: "value and limit", cell: (f) => el("span", { class: "num" }, limitText(f)), sort: (f) => f.value },
  { key: "excess", title: "× limit", cell: (f) => el("span", { class: "num" }, number(excess(f), 3)), sort: excess },
  { key: "owner", title: "owner", cell: (f) => f.owner === "none" ? "" : el("span", { class: "owner" }, f.owner), sort: (f) => f.owner },
  { key: "seen", title: "seen, px", sort: (f) => f.image.measured ? f.image.pixels : null,
    cell: (f) => el("span", { class: "num" }, !f.image.measured ? "–" : f.image.visible ? number(f.image.pixels) : "no") },
];
if (new Set(report.findings.map((f) => f.character)).size < 2) columns.splice(2, 1);

const facets = [["standing", "verdict", standing], ["owner", "owner", (f) => f.owner], ["code", "check", (f) => f.code],
  ["character", "character", (f) => f.character], ["rig", "rig", (f) => f.rig], ["mapping", "mapping", (f) => f.mapping],
  ["sweep", "sweep", (f) => f.sweep], ["role", "role", roleOf]];

const measures = { value: (f) => f.value, limit: (f) => f.limit, excess, control: (f) => f.control_deg,
  pixels: (f) => f.image.measured ? f.image.pixels : null, frame: (f) => f.frame };
const compares = { ">": (a, b) => a > b, "<": (a, b) => a < b, ">=": (a, b) => a >= b, "<=": (a, b) => a <= b, "=": (a, b) => a === b };

/** A word of the search: `max_over_mean>2` asks for a number, anything else for a text. */
function test(word) {
  const numeric = /^([a-z_]+)(>=|<=|>|<|=)(-?\d+(?:\.\d+)?)$/.exec(word);
  if (!numeric) return (f, i) => haystack[i].includes(word);
  const of = own(measures, numeric[1]) ?? ((f) => own(f.geometry, numeric[1]));
  const limit = Number(numeric[3]), holds = compares[numeric[2]];
  return (f) => {
    const value = of(f);
    return value != null && holds(value, limit);
  };
}

function findingsSection() {
  const state = { filters: new Map(), sort: null, down: true, rows: [], at: -1 };
  const search = el("input", { type: "search", placeholder: "search: kink spine04 excess>2", "aria-label": "search findings",
    autocomplete: "off", spellcheck: "false", oninput: () => update(true) });
  const shown = el("output", { class: "soft num" });
  const menus = new Map();
  for (const [key, label, of] of facets) {
    const tally = new Map();
    for (const f of report.findings) tally.set(of(f), (tally.get(of(f)) || 0) + 1);
    if (tally.size < 2) continue;
    menus.set(key, el("select", { "aria-label": label, onchange: () => update(true) }, el("option", { value: "" }, label + ": all"),
      [...tally].sort((a, b) => b[1] - a[1]).map(([value, n]) => {
        const option = el("option", {}, words(visible(value || "none")) + " (" + n + ")");
        option.value = "=" + value;
        return option;
      })));
  }
  const clear = el("button", { type: "button", class: "quiet", onclick: () => { reset(); update(true); } }, "clear");
  const heads = columns.map((column) => el("th", { scope: "col", "aria-sort": "none", class: "col-" + column.key },
    el("button", { type: "button", onclick: () => order(column.key) }, column.title, el("span", { class: "arrow", "aria-hidden": "true" }))));
  const above = el("tr", { class: "space", "aria-hidden": "true" }, el("td", { colspan: columns.length }));
  const below = above.cloneNode(true);
  const body = el("tbody", {}, above, below);
  const table = el("table", { class: "findings" }, el("thead", {}, el("tr", {}, heads)), body);
  const scroller = el("div", { class: "scroller", tabindex: 0, role: "region", "aria-label": "table of findings", onscroll: () => paint(), onkeydown: keys }, table);
  const empty = el("p", { class: "empty", hidden: true }, "No finding matches.");

  function reset() {
    search.value = "";
    for (const menu of menus.values()) menu.value = "";
  }
  function order(key) {
    if (state.sort === key && state.down) state.down = false;
    else if (state.sort === key) state.sort = null;
    else Object.assign(state, { sort: key, down: true });
    update(true);
  }
  function update(remember) {
    const tests = search.value.toLowerCase().split(/\s+/).filter(Boolean).map(test);
    for (const [key, , of] of facets) {
      const wanted = menus.get(key)?.value;
      if (wanted) tests.push((f) => "=" + of(f) === wanted);
    }
    state.rows = report.findings.filter((f, i) => tests.every((holds) => holds(f, i)));
    const column = columns.find((c) => c.key === state.sort);
    if (column) sortBy(state.rows, column, state.down);
    columns.forEach((c, i) => {
      heads[i].setAttribute("aria-sort", c.key !== state.sort ? "none" : state.down ? "descending" : "ascending");
      heads[i].querySelector(".arrow").textContent = c.key !== state.sort ? "" : state.down ? " ▾" : " ▴";
    });
    shown.textContent = state.rows.length === report.findings.length ? plural(report.findings.length, "finding") : state.rows.length + " of " + plural(report.findings.length, "finding");
    table.setAttribute("aria-rowcount", state.rows.length + 1);
    empty.hidden = state.rows.length > 0;
    scroller.hidden = state.rows.length === 0;
    viewed.list = state.rows;
    state.at = -1;
    scroller.scrollTop = 0;
    state.painted = null;
    paint();
    if (remember) note(address());
  }
  function address() {
    const query = new URLSearchParams();
    if (search.value) query.set("q", search.value);
    for (const [key, menu] of menus) if (menu.value) query.set(key, menu.value.slice(1));
    if (state.sort) query.set("sort", (state.down ? "-" : "") + state.sort);
    return "#findings" + (query.size ? "?" + query : "");
  }
  function paint(all) {
    const total = state.rows.length;
    const from = all ? 0 : Math.max(0, Math.floor(scroller.scrollTop / rowHeight) - 10);
    const till = all ? Math.min(total, 400) : Math.min(total, from + Math.ceil(scroller.clientHeight / rowHeight) + 20);
    const painted = from + "-" + till + "-" + state.at;
    if (painted === state.painted) return;
    state.painted = painted;
    above.firstChild.style.height = from * rowHeight + "px";
    below.firstChild.style.height = (all ? 0 : (total - till) * rowHeight) + "px";
    above.hidden = from === 0;
    below.hidden = till === total || Boolean(all);
    const rows = state.rows.slice(from, till).map((f, i) => {
      const href = "#finding/" + addressOf.get(f);
      return el("tr", { "aria-rowindex": from + i + 2, class: from + i === state.at ? "at" : "", onclick: (event) => { if (!event.target.closest("a")) go(href); } },
        columns.map((c, k) => c.key === "check" ? el("th", { scope: "row" }, el("a", { href }, c.cell(f))) : el("td", { class: "col-" + c.key }, c.cell(f))));
    });
    body.replaceChildren(above, ...rows, below);
  }
  function move(by) {
    if (state.rows.length === 0) return;
    state.at = Math.min(state.rows.length - 1, Math.max(0, state.at + by));
    const top = state.at * rowHeight;
    if (top < scroller.scrollTop) scroller.scrollTop = top;
    const bottom = top + 2 * rowHeight - scroller.clientHeight;
    if (bottom > scroller.scrollTop) scroller.scrollTop = bottom;
    paint();
    const f = state.rows[state.at];
    announce(visible([f.code, checkName(f), f.rig, f.pose, words(standing(f))].join(", ")));
  }
  function keys(event) {
    const page = Math.max(1, Math.floor(scroller.clientHeight / rowHeight) - 2);
    const by = { ArrowDown: 1, ArrowUp: -1, PageDown: page, PageUp: -page, Home: -Infinity, End: Infinity }[event.key];
    if (by) move(by);
    else if (event.key === "Enter" && state.at >= 0 && event.target === scroller) go("#finding/" + addressOf.get(state.rows[state.at]));
    else return;
    event.preventDefault();
  }
  routes.set("findings", (parts, query) => {
    closeFinding();
    reset();
    search.value = query.get("q") ?? "";
    for (const [key, menu] of menus) {
      if (!query.has(key)) continue;
      menu.value = "=" + query.get(key);
      if (menu.selectedIndex < 0) menu.value = "";
    }
    const sort = query.get("sort") ?? "";
    state.down = sort.startsWith("-");
    state.sort = columns.some((c) => c.key === sort.replace("-", "")) ? sort.replace("-", "") : null;
    // A filter that this report has no values for filters everything out, honestly.
    const unknown = [...query.keys()].find((key) => facets.some(([k]) => k === key) && !menus.get(key)?.value);
    update(false);
    if (unknown) filterUnknown(unknown, query.get(unknown));
    node.scrollIntoView();
  });
  function filterUnknown(key, value) {
    const of = facets.find(([k]) => k === key)[2];
    state.rows = state.rows.filter((f) => of(f) === value);
    shown.textContent = state.rows.length + " of " + plural(report.findings.length, "finding") + ", " + key + " " + words(visible(value));
    empty.hidden = state.rows.length > 0;
    scroller.hidden = state.rows.length === 0;
    viewed.list = state.rows;
    paint();
  }
  window.addEventListener("beforeprint", () => paint(true));
  window.addEventListener("afterprint", () => paint());
  new ResizeObserver(() => paint()).observe(scroller);
  const node = report.findings.length === 0
    ? section("findings", "Findings", el("p", {}, "Nothing was found."))
    : section("findings", "Findings", el("div", { class: "filters", role: "search", "aria-label": "filter the findings" }, search, [...menus.values()], clear, shown), scroller, empty);
  node.begin = () => update(false);
  node.move = move;
  node.search = search;
  return node;
}

/** Sorts in place; what was not measured is last either way, equal rows keep the report's order. */
function sortBy(rows, column, down) {
  const sign = down ? -1 : 1;
  const compare = (a, b) => typeof a === "number" ? a - b : a < b ? -1 : a > b ? 1 : 0;
  const keyed = rows.map((f) => [column.sort(f), column.then?.(f) ?? 0, placeIn.get(f), f]);
  keyed.sort((a, b) => {
    if ((a[0] == null) !== (b[0] == null)) return a[0] == null ? 1 : -1;
    return (a[0] == null ? 0 : sign * compare(a[0], b[0])) || sign * compare(a[1], b[1]) || a[2] - b[2];
  });
  keyed.forEach((entry, i) => { rows[i] = entry[3]; });
}
