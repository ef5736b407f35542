// The data, and how it becomes elements. Text enters the page only as text nodes and attributes set
// one by one: nothing here or below parses HTML.
function bytesFrom(base64) {
  const text = atob(base64), bytes = new Uint8Array(text.length);
  for (let i = 0; i < text.length; ++i) bytes[i] = text.charCodeAt(i);
  return bytes;
}
async function readReport() {
  const node = document.getElementById("report");
  if (!node.dataset.packed) return JSON.parse(node.textContent);
  const bytes = bytesFrom(node.textContent);
  return new Response(new Blob([bytes]).stream()
    .pipeThrough(new DecompressionStream(node.dataset.packed))).json();
}
const report = await readReport().catch((error) => {
  document.getElementById("page").textContent = "DecompressionStream" in window ?
    "This page is damaged: its data cannot be read." :
    "This browser is too old for a report of this size: Chromium from 80, Firefox from 113 and " +
    "Safari from 16.4 on show it. report.md in this folder holds the findings.";
  throw error;
});
const insidePictures = new Map(
  Object.entries(JSON.parse(document.getElementById("pictures").textContent)));

/** A value by a name from outside, which may be `constructor`. */
const own = (object, key) => Object.hasOwn(object, key) ? object[key] : null;

const svgName = "http://www.w3.org/2000/svg";

function fill(node, attributes, children) {
  for (const [key, value] of Object.entries(attributes || {})) {
    if (key.startsWith("on")) node.addEventListener(key.slice(2), value);
    else if (key.startsWith("--")) node.style.setProperty(key, value);
    else if (value === true) node.setAttribute(key, "");
    else if (value !== false && value != null) node.setAttribute(key, value);
  }
  for (const child of children.flat(4)) {
    if (child != null && child !== false) node.append(child);
  }
  return node;
}
const el = (name, attributes, ...children) =>
  fill(document.createElement(name), attributes, children);
const svg = (name, attributes, ...children) =>
  fill(document.createElementNS(svgName, name), attributes, children);

// Controls, direction marks and other characters that act or hide are spelled out, as in the other
// forms of the report (escape.h).
const acting = new RegExp("[\\u0000-\\u001f\\u007f-\\u009f\\u00ad\\u034f\\u061c\\u115f\\u1160" +
  "\\u17b4\\u17b5\\u180b-\\u180f\\u200b-\\u200f\\u2028-\\u202e\\u2060-\\u206f\\u3164" +
  "\\ue000-\\uf8ff\\ufdd0-\\ufdef\\ufe00-\\ufe0f\\ufeff\\uffa0\\ufff0-\\ufffb\\ufffe\\uffff" +
  "\\u{1bca0}-\\u{1bca3}\\u{1d173}-\\u{1d17a}\\u{e0000}-\\u{10ffff}]", "gu");
const spelled = { "\n": "\\n", "\t": "\\t", "\r": "\\r" };
function visible(text) {
  return String(text).replace(acting, (c) => {
    if (Object.hasOwn(spelled, c)) return spelled[c];
    const code = c.codePointAt(0).toString(16);
    if (code.length <= 2 && c < "\x80") return "\\x" + code.padStart(2, "0");
    return code.length <= 4 ? "\\u" + code.padStart(4, "0") : "\\U" + code.padStart(8, "0");
  });
}

/** A name from outside, in an element that keeps its direction to itself. */
const name = (text, className) => el("bdi", { class: className }, visible(text));
const code = (text) => el("code", {}, visible(text));

/** Where a picture is: inside the page, or a path that stays in the page's folder; else "". */
function source(path) {
  if (!path) return "";
  if (insidePictures.has(path)) return insidePictures.get(path);
  const parts = path.split(/[\\/]/);
  if (/[\u0000-\u001f\u007f]/.test(path)) return "";
  if (parts.some((part) => part === "" || part === "." || part === "..")) return "";
  return "./" + parts.map((part) => encodeURIComponent(part)).join("/");
}

/** A picture that says so where its file is missing. */
function image(path, alt, attributes) {
  const from = source(path);
  const missing = () => el("span", { class: "none" }, "picture not in this folder");
  if (!from) return missing();
  const picture = el("img", { src: from, alt: visible(alt), decoding: "async", ...attributes,
    onerror: () => picture.replaceWith(missing()) });
  return picture;
}

const words = (text) => text.replaceAll("_", " ");
const plural = (n, one, many) => n + " " + (n === 1 ? one : many || one + "s");

/** Four significant digits, no trailing zeros; a dash for what was not measured. */
function number(value, digits = 4) {
  if (value == null || !Number.isFinite(value)) return "–";
  // What rounding leaves of nothing is nothing.
  const text = Math.abs(value) < 1e-9 ? "0" : String(Number(value.toPrecision(digits)));
  return text.replace("-", "−");
}
const signed = (value) => (value > 0 ? "+" : "") + number(value);
/** `9.1°`, `0.71 of rest area`. */
function quantity(value, unit) {
  if (value == null) return "not measured";
  if (!unit) return number(value);
  return number(value) + (unit === "deg" ? "°" : " " + visible(unit));
}

const reducedMotion = window.matchMedia("(prefers-reduced-motion: reduce)");

/** A button that copies `text`; says so for a moment. */
function copyButton(text, label) {
  const button = el("button", { type: "button", class: "quiet", onclick: copy }, label);
  async function copy() {
    try {
      await navigator.clipboard.writeText(text);
    } catch {
      // Older browsers give pages from file:// no clipboard; a selected field can still be copied.
      const field = el("textarea", { "aria-label": "text to copy" });
      field.value = text;
      button.after(field);
      field.select();
      document.execCommand("copy");
      field.remove();
      button.focus();
    }
    button.textContent = "copied";
    announce("copied");
    setTimeout(() => { button.textContent = label; }, 1500);
  }
  return button;
}

const live = el("div", { class: "unseen", role: "status", "aria-live": "polite" });
function announce(text) { live.textContent = text; }

/** One choice of several, shown as a row of buttons. `options`: [value, label]. */
function choice(label, options, value, onchange) {
  const group = "choice-" + (choice.count = (choice.count || 0) + 1);
  const inputs = options.map(([key]) => el("input", {
    type: "radio", name: group, id: group + "-" + key, value: key, checked: key === value,
    onchange: () => onchange(key) }));
  const node = el("fieldset", { class: "choice" }, el("legend", { class: "unseen" }, label),
    options.map(([key, text], i) => [inputs[i], el("label", { for: group + "-" + key }, text)]));
  node.select = (key) => {
    const input = inputs.find((one) => one.value === String(key));
    if (input) input.checked = true;
  };
  return node;
}

function section(id, title, ...content) {
  return el("section", { id, "aria-labelledby": id + "-title", tabindex: -1 },
    el("h2", { id: id + "-title" }, title), content);
}
