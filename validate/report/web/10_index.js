// What the report says elsewhere about a finding: its rig's role, its check's name, its address.
const rigKey = (x) => JSON.stringify([x.character, x.rig, x.mapping]);
const rigOf = new Map(report.rigs.map((rig) => [rigKey(rig), rig]));
const checkOf = new Map(report.checks.map((check) => [check.code, check]));

const roleOf = (finding) => rigOf.get(rigKey(finding))?.role ?? "proposed";
/** As finding_name in digest.h. */
const checkName = (finding) => finding.code === "BB030" && finding.pose.startsWith("twist ")
  ? "candy wrapper" : checkOf.get(finding.code)?.name ?? "";
const decides = (finding) => finding.verdict === "fail" && roleOf(finding) === "proposed";

/** The rigs in their first order give each name one colour and dash all over the page. */
const rigNames = [...new Set(report.rigs.filter((rig) => rig.role !== "canary").map((rig) => rig.rig))];
const rigInk = (rig) => (rigNames.indexOf(rig) + 6) % 6;

/** What decides the table's mark and order: the verdict, unless the rig does not decide. */
function standing(finding) {
  const role = roleOf(finding);
  if (finding.verdict === "fail" && role !== "proposed") return role;
  return finding.verdict;
}
const marks = { pass: "✓", fail: "✕", waived: "⚑", stress: "△", not_measured: "?",
  not_applicable: "–", reference: "○", canary: "◇" };
function badge(kind) {
  return el("span", { class: "badge " + kind },
    el("span", { "aria-hidden": "true" }, marks[kind] + " "), words(kind));
}

/** As place_text in digest.h. */
function placeText(finding) {
  const { joint, between, side, mesh_part: part } = finding.place;
  const parts = [];
  if (between) parts.push("between " + visible(between[0]) + " and " + visible(between[1]));
  else if (joint != null) parts.push(visible(joint));
  if (side) parts.push(side);
  if (part) parts.push("mesh “" + visible(part) + "”");
  return parts.join(", ") || placeNumbers(finding);
}
/** The slice or vertex by its number, for those who look it up in the mesh. */
function placeNumbers(finding) {
  const { slice, vertex } = finding.place;
  return slice != null ? "slice " + slice : vertex != null ? "vertex " + vertex : "";
}

/** How far past its limit, as a ratio: 2 is twice the limit, or half of a lower one. */
function excess(finding) {
  const { value, limit } = finding;
  if (value == null || limit == null || value === limit) return null;
  return value > limit ? value / Math.max(limit, 1e-9) : limit / Math.max(value, 1e-9);
}

// A finding's address holds what it is, not where it stands in the list, so that a link survives
// the next night. Equal ones are numbered.
const addressOf = new Map();
const findingAt = new Map();
for (const finding of report.findings) {
  const place = finding.place;
  const base = [finding.code, finding.character, finding.rig, finding.mapping, finding.sweep,
    finding.control_deg ?? "", place.joint ?? place.slice ?? place.vertex ?? ""]
    .map((part) => encodeURIComponent(part).replaceAll("~", "%7E"))
    .join("~");
  let address = base;
  for (let i = 2; findingAt.has(address); ++i) address = base + "~" + i;
  findingAt.set(address, finding);
  addressOf.set(finding, address);
}

/** Findings to show first: as Digest::worst in digest.h. */
function worst(count) {
  const silent = (f) => f.verdict === "pass" || f.verdict === "not_applicable" || roleOf(f) === "canary";
  const rank = (f) => roleOf(f) === "reference" ? 2 : f.verdict === "fail" ? 0 : 1;
  const over = (f) => excess(f) ?? (f.value == null || f.limit == null ? 0 : 1);
  const sorted = [...report.findings].sort((a, b) => over(b) - over(a));
  const shown = [];
  for (const repeat of [false, true]) {
    for (let wanted = 0; wanted < 3; ++wanted) {
      const seen = new Set();
      for (const finding of sorted) {
        if (shown.length === count) return shown;
        if (silent(finding) || rank(finding) !== wanted || shown.includes(finding)) continue;
        const key = JSON.stringify([finding.code, finding.rig]);
        if (!repeat && seen.has(key)) continue;
        seen.add(key);
        shown.push(finding);
      }
    }
  }
  return shown;
}

// Addresses: #finding/..., #sweep/character/mapping/sweep/degrees, #findings?filters, #section.
const routes = new Map();
function go(hash, replace) {
  if (location.hash === hash) return;
  if (replace) location.replace(hash);
  else location.hash = hash;
}
/** Writes the address of what is already shown, without going there. */
let noted = null, followed = location.hash;
function note(hash) {
  // Another address than the last one followed: a link was clicked, and its event is on the way.
  if (location.hash === hash || location.hash !== followed) return;
  noted = hash;
  location.replace(hash);
  followed = location.hash;
}
/** Does what the address says. An address of another report's finding is said, not ignored. */
function follow() {
  const mine = noted;
  noted = null;
  followed = location.hash;
  if (location.hash === mine) return;
  const hash = location.hash.slice(1);
  const [head, query = ""] = hash.split("?", 2);
  const parts = head.split("/");
  const route = routes.get(parts[0]);
  if (route) route(parts.slice(1), new URLSearchParams(query));
  else closeFinding();
}
function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}
