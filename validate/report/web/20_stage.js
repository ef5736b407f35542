// Two pictures of one thing: side by side, split by a slider, blinking, subtracted, or under a heat
// map. Every pane shares one zoom, so that the same place is seen in all of them.
const stageModes = [["side", "Side by side"], ["slider", "Slider"], ["blink", "Blink"],
  ["difference", "Difference"], ["heat", "Heat"]];

function pane(kind, label) {
  const picture = el("img", { alt: "", draggable: "false", decoding: "async" });
  const layer = el("div", { class: "layer " + kind }, picture);
  layer.picture = picture;
  layer.caption = label;
  return layer;
}

/** Zoom and pan of everything inside `node`, kept in percent of a pane so that all panes agree. */
function zoomable(node, { wheel }) {
  let scale = 1, x = 0, y = 0, drag = null;
  function apply() {
    const least = 100 - 100 * scale;
    x = Math.min(0, Math.max(least, x));
    y = Math.min(0, Math.max(least, y));
    node.style.setProperty("--scale", scale);
    node.style.setProperty("--x", x + "%");
    node.style.setProperty("--y", y + "%");
    node.classList.toggle("zoomed", scale > 1);
    node.classList.toggle("pixels", scale > 3);
  }
  function zoom(factor, px = 50, py = 50) {
    const next = Math.min(32, Math.max(1, scale * factor));
    x = px - (px - x) * next / scale;
    y = py - (py - y) * next / scale;
    scale = next;
    apply();
  }
  const spot = (event) => {
    const box = event.target.closest(".pane").getBoundingClientRect();
    return [(event.clientX - box.left) / box.width * 100, (event.clientY - box.top) / box.height * 100, box];
  };
  node.addEventListener("wheel", (event) => {
    if (!event.target.closest(".pane") || (!wheel && !event.ctrlKey)) return;
    event.preventDefault();
    const [px, py] = spot(event);
    zoom(Math.exp(-event.deltaY / 300), px, py);
  }, { passive: false });
  node.addEventListener("pointerdown", (event) => {
    if (scale === 1 || event.button !== 0 || event.defaultPrevented || !event.target.closest(".pane")) return;
    drag = [event.clientX, event.clientY, x, y, spot(event)[2]];
    node.setPointerCapture(event.pointerId);
  });
  node.addEventListener("pointermove", (event) => {
    if (!drag) return;
    x = drag[2] + (event.clientX - drag[0]) / drag[4].width * 100;
    y = drag[3] + (event.clientY - drag[1]) / drag[4].height * 100;
    apply();
  });
  const drop = () => { drag = null; };
  node.addEventListener("pointerup", drop);
  node.addEventListener("pointercancel", drop);
  node.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [8, 0], ArrowRight: [-8, 0], ArrowUp: [0, 8], ArrowDown: [0, -8] }[event.key];
    if (event.target.closest("input, select")) return;
    if (event.key === "+" || event.key === "=") zoom(1.5);
    else if (event.key === "-") zoom(1 / 1.5);
    else if (event.key === "0") zoom(0);
    else if (step && scale > 1) {
      x += step[0];
      y += step[1];
      apply();
    } else return;
    event.preventDefault();
    event.stopPropagation();
  });
  apply();
  return { zoom, at: (px, py) => [(px - x) / scale, (py - y) / scale], get scale() { return scale; } };
}

function zoomButtons(view) {
  const button = (label, text, factor) => el("button", { type: "button", class: "quiet",
    "aria-label": label, title: label, onclick: () => view.zoom(factor) }, text);
  return el("span", { class: "zoom", role: "group", "aria-label": "zoom" },
    button("zoom in", "+", 1.5), button("zoom out", "−", 1 / 1.5), button("fit: whole picture", "fit", 0));
}

/** The colour of one pixel, or null where the browser keeps a file's pixels from the page. */
function pixelOf(picture, x, y) {
  if (!picture.naturalWidth || pixelOf.refused) return null;
  const canvas = pixelOf.canvas ??= el("canvas", { width: 1, height: 1 });
  const context = canvas.getContext("2d", { willReadFrequently: true });
  context.clearRect(0, 0, 1, 1);
  context.drawImage(picture, -x, -y);
  try {
    return [...context.getImageData(0, 0, 1, 1).data.slice(0, 3)];
  } catch {
    pixelOf.refused = true;
    return null;
  }
}

function stage(options = {}) {
  let mode = "side", timer = 0, second = true, shown = {};
  const first = el("div", { class: "pane" }, pane("a"), pane("b"), pane("heat"),
    el("div", { class: "split", "aria-hidden": "true" }), el("span", { class: "tag left" }), el("span", { class: "tag right" }));
  const other = el("div", { class: "pane" }, pane("b"), el("span", { class: "tag left" }));
  const panes = el("div", { class: "panes", tabindex: 0, role: "group",
    "aria-label": "pictures: plus and minus zoom, arrows move, zero shows all" }, first, other);
  const layers = { a: [...first.querySelectorAll(".a")], b: [...panes.querySelectorAll(".b")],
    heat: [...first.querySelectorAll(".layer.heat")] };
  const view = zoomable(panes, { wheel: options.wheel });
  const probe = el("output", { class: "probe", "aria-label": "pixel under the pointer" });

  const cut = el("input", { type: "range", min: 0, max: 100, step: 0.5, value: 50,
    "aria-label": "split between the pictures", oninput: () => split(cut.value) });
  const rate = el("input", { type: "range", min: 0.5, max: 3, step: 0.5, value: 1.5,
    "aria-label": "blinks per second", oninput: blink });
  const pause = el("button", { type: "button", class: "quiet", onclick: () => swap(!timer) }, "pause");
  const gain = el("input", { type: "range", min: 1, max: 16, step: 1, value: 4,
    "aria-label": "difference times", oninput: () => panes.style.setProperty("--gain", gain.value) });
  const veil = el("input", { type: "range", min: 0, max: 100, value: 85,
    "aria-label": "heat map opacity", oninput: () => panes.style.setProperty("--veil", veil.value / 100) });
  const settings = { slider: [el("label", {}, "split ", cut)], difference: [el("label", {}, "times ", gain)],
    blink: [el("label", {}, "per second ", rate), pause], heat: [el("label", {}, "opacity ", veil)] };
  const setting = el("span", { class: "setting" });
  const modes = choice("how to compare", stageModes, mode, (key) => set(key));
  const node = el("div", { class: "stage" },
    el("div", { class: "stage-bar" }, modes, setting, zoomButtons(view), probe), panes);

  function split(percent) {
    cut.value = percent;
    panes.style.setProperty("--cut", percent + "%");
  }
  function label(left, right) {
    first.querySelector(".tag.left").textContent = left ?? "";
    first.querySelector(".tag.right").textContent = right ?? "";
    other.querySelector(".tag.left").textContent = visible(shown.b?.label ?? "");
  }
  function flash(showSecond) {
    second = showSecond;
    first.classList.toggle("second", second);
    label(visible((second ? shown.b : shown.a)?.label ?? ""), "");
  }
  function swap(run) {
    clearInterval(timer);
    timer = run ? setInterval(() => flash(!second), 1000 / rate.value) : 0;
    pause.textContent = run ? "pause" : "run";
  }
  // At most three changes a second: more can harm people who are sensitive to flashes.
  function blink() { swap(timer !== 0); }
  function set(key) {
    mode = key;
    modes.select(key);
    panes.dataset.mode = key;
    setting.replaceChildren(...(settings[key] || []));
    clearInterval(timer);
    timer = 0;
    first.classList.remove("second");
    const a = visible(shown.a?.label ?? ""), b = visible(shown.b?.label ?? "");
    if (key === "blink") {
      flash(false);
      swap(!reducedMotion.matches);
    } else if (key === "difference") label(a + " − " + b, "");
    else if (key === "heat") label(visible(shown.heat?.label ?? "no heat map"), "");
    else label(a, key === "slider" ? b : "");
    if (options.onmode) options.onmode(key);
  }
  function picture(kind, one) {
    for (const layer of layers[kind]) {
      const path = source(one?.path);
      layer.picture.hidden = !path;
      layer.picture.alt = one && path ? visible(one.alt || one.label) : "";
      if (path) layer.picture.setAttribute("src", path);
      else layer.picture.removeAttribute("src");
    }
  }
  /** `pictures`: {a, b, heat}, each {path, label, alt} or nothing. */
  function show(pictures) {
    shown = pictures;
    for (const kind of ["a", "b", "heat"]) picture(kind, pictures[kind]);
    const missing = { slider: !pictures.b?.path, blink: !pictures.b?.path,
      difference: !pictures.b?.path, heat: !pictures.heat?.path };
    for (const input of modes.querySelectorAll("input")) input.disabled = Boolean(missing[input.value]);
    node.classList.toggle("single", !pictures.b?.path);
    set(missing[mode] ? "side" : mode);
  }
  first.querySelector("img").addEventListener("load", (event) => {
    const { naturalWidth: w, naturalHeight: h } = event.target;
    if (w && h) panes.style.setProperty("--shape", w + " / " + h);
  });
  first.addEventListener("pointerdown", (event) => {
    const box = first.getBoundingClientRect();
    if (mode !== "slider" || Math.abs(event.clientX - box.left - box.width * cut.value / 100) > 14) return;
    event.preventDefault();
    const move = (e) => split(Math.min(100, Math.max(0, (e.clientX - box.left) / box.width * 100)));
    first.setPointerCapture(event.pointerId);
    first.addEventListener("pointermove", move);
    first.addEventListener("pointerup", () => first.removeEventListener("pointermove", move), { once: true });
  });
  panes.addEventListener("pointermove", (event) => {
    const box = event.target.closest(".pane")?.getBoundingClientRect();
    const a = layers.a[0].picture, b = layers.b[0].picture;
    if (!box || !a.naturalWidth) return;
    const [px, py] = view.at((event.clientX - box.left) / box.width * 100, (event.clientY - box.top) / box.height * 100);
    const x = Math.floor(px / 100 * a.naturalWidth), y = Math.floor(py / 100 * a.naturalHeight);
    const colors = [a, b].map((one) => one.hidden ? null : pixelOf(one, x, y)).filter(Boolean);
    probe.textContent = "x " + x + "  y " + y + colors.map((c) => "  rgb " + c.join(" ")).join(" | ");
  });
  panes.addEventListener("pointerleave", () => { probe.textContent = ""; });
  split(50);
  set("side");
  return { node, show, set, stop: () => swap(false), view };
}
