// A sweep of all rigs at once: frames above, one scrubber, the metrics below.
const sweeps = new Map();  // character, mapping, sweep -> [{rig, series}]
const sweepKey = (character, mapping, sweep) => JSON.stringify([character, mapping, sweep]);
for (const rig of report.rigs) {
  if (rig.role === "canary") continue;
  for (const series of rig.sweeps) {
    if (series.control_deg.length === 0) continue;
    const key = sweepKey(rig.character, rig.mapping, series.sweep);
    if (!sweeps.has(key)) sweeps.set(key, []);
    sweeps.get(key).push({ rig, series });
  }
}
const seriesOf = (finding) => sweeps.get(sweepKey(finding.character, finding.mapping, finding.sweep));
const sweepAddress = (...parts) => "#sweep/" + parts.map((part) => encodeURIComponent(part ?? "")).join("/");

/** The range of control angles that the envelope asks for: both ways where the sweep goes both ways. */
function neededRange(members) {
  const channel = members[0]?.series.channel;
  const headroom = members.flatMap(({ rig }) => rig.headroom).find((h) => h.channel === channel);
  if (!headroom || headroom.needs_deg == null) return null;
  const bothWays = members.some(({ series }) => series.control_deg.some((a) => a < 0));
  return [bothWays ? -headroom.needs_deg : 0, headroom.needs_deg];
}

/** A plot per metric that any of the members measured. */
function plotsOfSweep(members, onscrub) {
  const metrics = new Map();
  for (const { rig, series } of members) {
    for (const [metric, values] of Object.entries(series.metric)) {
      if (!metrics.has(metric)) metrics.set(metric, { title: metric, unit: own(series.metric_unit, metric), limit: own(series.metric_limit, metric), series: [] });
      metrics.get(metric).series.push({ rig: rig.rig, x: series.control_deg, y: values });
    }
  }
  const needs = neededRange(members);
  // What the eye looks for first; the rest follows by name.
  const order = ["gain", "kink", "drift", "area"];
  const rank = (metric) => (order.findIndex((word) => metric.title.includes(word)) + order.length + 1) % (order.length + 1);
  const sorted = [...metrics.values()].sort((a, b) => rank(a) - rank(b));
  const values = (metric) => metric.series.flatMap((s) => s.y).filter((v) => v != null);
  const unmeasured = sorted.filter((metric) => values(metric).length === 0);
  const zero = sorted.filter((metric) => values(metric).length > 0 && values(metric).every((v) => Math.abs(v) <= 1e-6 * Math.abs(metric.limit ?? 0)));
  const line = (label, some) => some.length > 0 && { cursor() {}, node: el("p", { class: "flat soft" }, label,
    some.map((metric, i) => [i > 0 && ", ", name(words(metric.title))])) };
  return [...sorted.filter((metric) => !unmeasured.includes(metric) && !zero.includes(metric)).map((metric) => plot({ ...metric, needs, onscrub })),
    line("zero at every pose: ", zero), line("not measured: ", unmeasured)].filter(Boolean);
}

function sweepSection() {
  if (sweeps.size === 0) return null;
  const keys = [...sweeps.keys()].map((key) => JSON.parse(key));
  const of = (i) => [...new Set(keys.map((key) => key[i]))];
  const state = { key: keys[0], at: 0, hidden: new Set(), plots: [], angles: [], timer: 0 };
  const frames = el("div", { class: "frames-row panes", tabindex: 0, role: "group",
    "aria-label": "frames of every rig: plus and minus zoom, arrows move, zero shows all" });
  const view = zoomable(frames, { wheel: false });
  const zoomers = zoomButtons(view);
  const plots = el("div", { class: "plots" });
  const events = el("div", { class: "events" });
  const scrubber = el("input", { type: "range", min: 0, step: 1, class: "scrubber", "aria-label": "pose",
    oninput: () => { play(false); seek(state.angles[scrubber.value]); } });
  const angle = el("output", { class: "angle num" });
  const button = el("button", { type: "button", class: "quiet play", onclick: () => play(!state.timer) }, "play");
  const stepper = (by, text, label) => el("button", { type: "button", class: "quiet", "aria-label": label, title: label,
    onclick: () => { play(false); seek(state.angles[Math.min(state.angles.length - 1, Math.max(0, nearest(state.angles, state.at) + by))]); } }, text);

  const select = (label, i) => of(i).length < 2 ? null : el("label", {}, label + " ", el("select", { "aria-label": label, "data-part": i,
    onchange: (e) => change(i, e.target.value) }, of(i).map((v) => el("option", { value: v }, visible(v)))));
  const rigs = el("span", { class: "rigs", role: "group", "aria-label": "rigs shown" });
  const pickers = [select("character", 0), select("mapping", 1), select("sweep", 2)].filter(Boolean);

  function change(i, value) {
    const wanted = [...state.key];
    wanted[i] = value;
    // Not every character has every mapping and sweep: keep as much of the choice as exists.
    const found = keys.find((key) => key.every((part, k) => part === wanted[k])) ??
      keys.find((key) => key[i] === value && key[2] === wanted[2]) ?? keys.find((key) => key[i] === value);
    open(found, state.at);
    remember();
  }
  function members() {
    return sweeps.get(sweepKey(...state.key)).filter(({ rig }) => !state.hidden.has(rig.rig));
  }
  function open(key, at) {
    play(false);
    state.key = key;
    for (const picker of pickers) {
      const menu = picker.querySelector("select");
      menu.value = key[menu.dataset.part];
    }
    const all = sweeps.get(sweepKey(...key));
    rigs.replaceChildren(...all.map(({ rig }) => el("label", { class: "rig ink" + rigInk(rig.rig) },
      el("input", { type: "checkbox", checked: !state.hidden.has(rig.rig), onchange: (e) => toggle(rig.rig, e.target.checked) }),
      el("i", { class: "swatch", "aria-hidden": "true" }), name(rig.rig), rig.role !== "proposed" && el("span", { class: "soft" }, " " + rig.role))));
    state.angles = [...new Set(all.flatMap(({ series }) => series.control_deg).filter((a) => a != null))].sort((a, b) => a - b);
    scrubber.max = state.angles.length - 1;
    state.framed = all.length > 0 && all.every(({ series }) => series.channel === "frame");
    draw();
    seek(Math.min(state.angles.at(-1), Math.max(state.angles[0], at)));
  }
  function toggle(rig, shown) {
    if (shown) state.hidden.delete(rig);
    else state.hidden.add(rig);
    draw();
    seek(state.at);
  }
  function draw() {
    const shown = members();
    const framed = shown.filter(({ series }) => series.frame.some(Boolean));
    frames.hidden = zoomers.hidden = framed.length === 0;
    frames.replaceChildren(...framed.map(({ rig, series }) => {
      const picture = el("img", { alt: "", draggable: "false" });
      picture.addEventListener("load", () => frames.style.setProperty("--shape", picture.naturalWidth + " / " + picture.naturalHeight), { once: true });
      const figure = el("figure", { class: "pane ink" + rigInk(rig.rig) }, el("div", { class: "layer" }, picture), el("figcaption", { class: "tag left" }, rigLabel(rig)));
      figure.place = (at) => {
        const pose = nearest(series.control_deg, at), path = source(series.frame[pose]);
        picture.hidden = !path;
        picture.alt = path ? visible(rig.rig) + " at " + number(series.control_deg[pose]) + " degrees" : "";
        if (path) picture.setAttribute("src", path);
        else picture.removeAttribute("src");
      };
      return figure;
    }));
    state.plots = plotsOfSweep(shown, (x) => { play(false); seek(state.angles[nearest(state.angles, x)]); });
    plots.replaceChildren(...state.plots.map((one) => one.node));
    drawEvents();
  }
  /** Findings of this sweep as marks along the scrubber. */
  function drawEvents() {
    const low = state.angles[0], span = state.angles.at(-1) - low || 1;
    const here = report.findings.filter((f) => f.character === state.key[0] && f.mapping === state.key[1] && f.sweep === state.key[2] &&
      f.verdict !== "pass" && f.control_deg != null && !state.hidden.has(f.rig) && roleOf(f) !== "canary").slice(0, 200);
    // Marks at one angle stand beside each other, towards the middle of the sweep.
    const seen = new Map();
    const nudge = (f) => {
      const before = seen.get(f.control_deg) || 0;
      seen.set(f.control_deg, before + 1);
      return (f.control_deg - low > span / 2 ? -11 : 11) * before + "px";
    };
    events.replaceChildren(...here.map((f) => el("a", { class: "event ink" + rigInk(f.rig), href: "#finding/" + addressOf.get(f),
      "--at": (f.control_deg - low) / span, "--nudge": nudge(f), title: visible(f.code + " " + f.rig + ", " + f.pose),
      "aria-label": visible(f.code + " " + f.rig + ", " + f.pose) }, el("span", { "aria-hidden": "true" }, marks[standing(f)]))));
  }
  function seek(at) {
    if (at == null) return;
    state.at = at;
    const index = nearest(state.angles, at);
    scrubber.value = index;
    // A clip that names no control counts its frames.
    const text = visible(state.key[2]) + (state.framed ? ", frame " + (1001 + Math.round(at)) : " " + number(at) + "°");
    scrubber.setAttribute("aria-valuetext", text);
    angle.textContent = text;
    for (const figure of frames.children) figure.place(at);
    for (const one of state.plots) one.cursor(at);
    clearTimeout(state.late);
    if (state.open && !state.timer) state.late = setTimeout(remember, 250);
  }
  function remember() {
    if (state.open && !dialog.open) note(sweepAddress(...state.key, String(Number(state.at.toPrecision(7)))));
  }
  function play(run) {
    clearInterval(state.timer);
    state.timer = run ? setInterval(() => {
      const index = nearest(state.angles, state.at) + 1;
      if (index >= state.angles.length) play(false);
      else seek(state.angles[index]);
    }, 1000 / 12) : 0;
    if (run && nearest(state.angles, state.at) === state.angles.length - 1) seek(state.angles[0]);
    button.textContent = run ? "stop" : "play";
  }
  routes.set("sweep", (parts) => {
    closeFinding();
    const wanted = parts.slice(0, 3).map(decoded);
    const key = keys.find((one) => one.every((part, i) => part === wanted[i]));
    if (!key) return notice("This report has no such sweep.");
    state.open = true;
    const at = Number(decoded(parts[3] ?? ""));
    const same = key.every((part, i) => part === state.key[i]);
    if (!same) open(key, at);
    else if (Math.abs(state.at - at) > 1e-6 && Number.isFinite(at)) seek(state.angles[nearest(state.angles, at)]);
    node.scrollIntoView();
  });
  const node = section("sweeps", "Sweeps",
    el("div", { class: "sweep-bar" }, pickers, rigs, zoomers),
    frames,
    el("div", { class: "scrub" }, button, stepper(-1, "‹", "one pose back"), stepper(1, "›", "one pose on"), angle,
      el("div", { class: "track" }, scrubber, events)),
    plots);
  node.addEventListener("pointerdown", () => { state.open = true; });
  node.addEventListener("keydown", () => { state.open = true; });
  // Start where something happened, so that the first look already shows it.
  const first = worst(1)[0];
  const start = first && seriesOf(first) ? [first.character, first.mapping, first.sweep] : keys[0];
  open(keys.find((key) => key.every((part, i) => part === start[i])), first?.control_deg ?? 0);
  return node;
}
