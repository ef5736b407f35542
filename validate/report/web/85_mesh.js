// Posed meshes in 3D, coloured by a metric: turned by dragging or by keys. WebGL only; where a
// browser has none, the page says so and everything else works.
const meshFiles = new Map(Object.entries(JSON.parse(document.getElementById("meshes").textContent)));
const meshViews = report.meshes.filter((m) => meshFiles.has(m.pose_path) && meshFiles.has(m.triangles_path));

const meshProgram = {
  vertex: `attribute vec3 position, normal, color; uniform mat4 clip_from_mesh; uniform mat3 eye_from_mesh;
    varying vec3 n, c;
    void main() { n = eye_from_mesh * normal; c = color; gl_Position = clip_from_mesh * vec4(position, 1.0); }`,
  fragment: `precision mediump float; varying vec3 n, c; uniform float heat;
    void main() {
      vec3 m = normalize(gl_FrontFacing ? n : -n);
      float lit = 0.30 + 0.55 * max(0.0, dot(m, normalize(vec3(-0.45, 0.6, 0.65)))) + 0.15 * max(0.0, m.z);
      vec3 clay = vec3(0.72, 0.70, 0.68);
      gl_FragColor = vec4(mix(clay, c, heat) * mix(lit, 0.35 + 0.65 * lit, heat), 1.0);
    }`,
};

const bytesOf = (path) => bytesFrom(meshFiles.get(path).split(",", 2)[1]);

/** The two files of one view (page_mesh.cpp), as arrays for the graphics card; null if damaged. */
function readMesh(view) {
  const pose = bytesOf(view.pose_path), faces = bytesOf(view.triangles_path);
  const magic = (bytes) => String.fromCharCode(...bytes.subarray(0, 4));
  if (magic(pose) !== "BBP1" || magic(faces) !== "BBT1") return null;
  const head = new DataView(pose.buffer), faceHead = new DataView(faces.buffer);
  const count = head.getUint32(4, true), triangles = faceHead.getUint32(8, true);
  if (count === 0 || count !== faceHead.getUint32(4, true)) return null;
  const low = [0, 1, 2].map((k) => head.getFloat32(8 + 4 * k, true));
  const size = [0, 1, 2].map((k) => head.getFloat32(20 + 4 * k, true));
  const palette = pose.subarray(32, 800);
  const heatAt = 800 + Math.ceil(count * 6 / 4) * 4;
  const wide = count > 65536;
  if (pose.length < heatAt + count || faces.length < 12 + triangles * 3 * (wide ? 4 : 2)) return null;
  const steps = new Uint16Array(pose.buffer, 800, count * 3);
  const index = wide ? new Uint32Array(faces.buffer, 12, triangles * 3) : new Uint16Array(faces.buffer, 12, triangles * 3);
  if (index.some((i) => i >= count)) return null;
  const position = new Float32Array(count * 3), color = new Uint8Array(count * 3);
  let measured = 0;
  for (let i = 0; i < count; ++i) {
    const heat = pose[heatAt + i];
    measured += heat > 0;
    for (let k = 0; k < 3; ++k) {
      position[3 * i + k] = low[k] + size[k] * steps[3 * i + k] / 65535;
      color[3 * i + k] = palette[3 * heat + k];
    }
  }
  return { position, index, color, palette, measured, normal: smoothNormals(position, index), ...sphereAround(position, index) };
}

/** Around what the triangles show: another figure's vertices may lie in the file without any. */
function sphereAround(position, index) {
  const low = [Infinity, Infinity, Infinity], high = [-Infinity, -Infinity, -Infinity];
  for (const i of index) {
    for (let k = 0; k < 3; ++k) {
      low[k] = Math.min(low[k], position[3 * i + k]);
      high[k] = Math.max(high[k], position[3 * i + k]);
    }
  }
  return { center: low.map((v, k) => (v + high[k]) / 2), radius: Math.hypot(...low.map((v, k) => high[k] - v)) / 2 || 1 };
}

/** Normals of the vertices, each triangle counting by its area. */
function smoothNormals(position, index) {
  const normal = new Float32Array(position.length);
  for (let t = 0; t < index.length; t += 3) {
    const [a, b, c] = [index[t] * 3, index[t + 1] * 3, index[t + 2] * 3];
    const u = [0, 1, 2].map((k) => position[b + k] - position[a + k]);
    const v = [0, 1, 2].map((k) => position[c + k] - position[a + k]);
    const n = [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]];
    for (const corner of [a, b, c]) for (let k = 0; k < 3; ++k) normal[corner + k] += n[k];
  }
  return normal;
}

/** Column-major matrices of a camera that looks at `mesh` from an azimuth and elevation. */
function meshCamera(mesh, { azimuth, elevation, zoom, panX, panY }, aspect) {
  const [ca, sa, ce, se] = [Math.cos(azimuth), Math.sin(azimuth), Math.cos(elevation), Math.sin(elevation)];
  // Rows of eye_from_mesh: right, up, back. Azimuth 0 sees the front (+Z), 90 degrees the left (+X).
  const right = [ca, 0, -sa], back = [sa * ce, se, ca * ce], up = [-sa * se, ce, -ca * se];
  const half = Math.tan(15 * Math.PI / 180), distance = mesh.radius / Math.sin(15 * Math.PI / 180) / Math.min(1, aspect) / zoom;
  const dot = (row) => row[0] * mesh.center[0] + row[1] * mesh.center[1] + row[2] * mesh.center[2];
  const near = Math.max(distance - 2 * mesh.radius, distance * 0.01), far = distance + 2 * mesh.radius;
  const fx = 1 / (half * aspect), fy = 1 / half, fz = (far + near) / (near - far), fw = 2 * far * near / (near - far);
  const shift = [-dot(right) + panX * mesh.radius, -dot(up) + panY * mesh.radius, -dot(back) - distance];
  const column = (k) => [fx * right[k], fy * up[k], fz * back[k], -back[k]];
  return { clip: [...column(0), ...column(1), ...column(2), fx * shift[0], fy * shift[1], fz * shift[2] + fw, -shift[2]],
    eye: [0, 1, 2].flatMap((k) => [right[k], up[k], back[k]]) };
}

/** What draws meshes into `canvas`, or null without WebGL. */
function meshPainter(canvas) {
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl || !gl.getExtension("OES_element_index_uint")) return null;
  const compile = (type, text) => {
    const shader = gl.createShader(type);
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    return shader;
  };
  const program = gl.createProgram();
  gl.attachShader(program, compile(gl.VERTEX_SHADER, meshProgram.vertex));
  gl.attachShader(program, compile(gl.FRAGMENT_SHADER, meshProgram.fragment));
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS)) return null;
  gl.useProgram(program);
  gl.enable(gl.DEPTH_TEST);
  const uniform = (key) => gl.getUniformLocation(program, key);
  const buffers = { position: gl.createBuffer(), normal: gl.createBuffer(), color: gl.createBuffer(), index: gl.createBuffer() };
  let mesh = null;
  function load(next) {
    mesh = next;
    for (const key of ["position", "normal", "color"]) {
      const at = gl.getAttribLocation(program, key);
      gl.bindBuffer(gl.ARRAY_BUFFER, buffers[key]);
      gl.bufferData(gl.ARRAY_BUFFER, mesh[key], gl.STATIC_DRAW);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 3, key === "color" ? gl.UNSIGNED_BYTE : gl.FLOAT, key === "color", 0, 0);
    }
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, buffers.index);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, mesh.index, gl.STATIC_DRAW);
  }
  function draw(camera, heat) {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    const width = Math.round(canvas.clientWidth * ratio), height = Math.round(canvas.clientHeight * ratio);
    if (width === 0 || height === 0 || !mesh) return;
    if (canvas.width !== width || canvas.height !== height) Object.assign(canvas, { width, height });
    const { clip, eye } = meshCamera(mesh, camera, width / height);
    gl.viewport(0, 0, width, height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(uniform("clip_from_mesh"), false, clip);
    gl.uniformMatrix3fv(uniform("eye_from_mesh"), false, eye);
    gl.uniform1f(uniform("heat"), heat ? 1 : 0);
    gl.drawElements(gl.TRIANGLES, mesh.index.length, mesh.index instanceof Uint32Array ? gl.UNSIGNED_INT : gl.UNSIGNED_SHORT, 0);
  }
  return { load, draw };
}

// As the pictures are taken (finding_view.h), and from above. Those of two words have no button: a
// finding opens with them.
const meshAngles = { profile: [90, 0], "right profile": [-90, 0], front: [0, 0], back: [180, 0],
  "three-quarter": [145, 12], "front three-quarter": [-35, 12], above: [90, 60] };

function meshSection() {
  if (meshViews.length === 0) return null;
  const several = new Set(report.rigs.map((rig) => rig.character)).size > 1;
  const titleOf = (view) => (several && report.findings[view.finding] ? report.findings[view.finding].character + ": " : "") + view.title;
  const canvas = el("canvas", { "aria-hidden": "true" });
  const ring = el("span", { class: "ring", hidden: true, title: "the finding's place" });
  const holder = el("div", { class: "mesh", tabindex: 0, role: "group", "aria-roledescription": "3D view" }, canvas, ring);
  const legend = el("canvas", { width: 255, height: 1, "aria-hidden": "true" });
  const scale = el("div", { class: "scale" });
  const menu = el("select", { "aria-label": "mesh", onchange: () => { go("#mesh/" + menu.value); } },
    meshViews.map((m, i) => el("option", { value: i }, visible(titleOf(m)))));
  const heat = el("input", { type: "checkbox", checked: true, onchange: () => paint() });
  const camera = { azimuth: Math.PI / 2, elevation: 0, zoom: 1, panX: 0, panY: 0 };
  const facts = el("p", { class: "soft" });
  const found = el("p", {});
  let painter = null, shownMesh = null, mark = null, start = "profile";

  const aim = (key) => {
    const [azimuth, elevation] = meshAngles[key].map((d) => d * Math.PI / 180);
    Object.assign(camera, { azimuth, elevation, zoom: 1, panX: 0, panY: 0 });
  };
  const turn = (key) => {
    aim(key);
    paint();
  };
  const angles = el("span", { class: "zoom", role: "group", "aria-label": "look from" },
    Object.keys(meshAngles).filter((key) => !key.includes(" ")).map((key) => el("button", { type: "button", class: "quiet", onclick: () => turn(key) }, key)));
  function paint() {
    if (!painter) return;
    painter.draw(camera, heat.checked && !heat.disabled);
    ring.hidden = !mark || !shownMesh || canvas.clientHeight === 0;
    if (ring.hidden) return;
    const m = meshCamera(shownMesh, camera, canvas.clientWidth / canvas.clientHeight).clip;
    const [x, y, , w] = [0, 1, 2, 3].map((k) => m[k] * mark[0] + m[4 + k] * mark[1] + m[8 + k] * mark[2] + m[12 + k]);
    ring.hidden = !(w > 0);
    ring.style.left = (x / w + 1) * 50 + "%";
    ring.style.top = (1 - y / w) * 50 + "%";
  }
  function open(i) {
    const view = meshViews[i];
    menu.value = i;
    painter ??= meshPainter(canvas);
    const mesh = shownMesh = painter && readMesh(view);
    mark = view.mark && view.mark.every(Number.isFinite) ? view.mark : null;
    start = Object.hasOwn(meshAngles, view.view ?? "") ? view.view : "profile";
    if (view.view) aim(start);
    holder.setAttribute("aria-label", visible(titleOf(view)) + ": arrows turn, plus and minus zoom, zero starts again");
    const finding = report.findings[view.finding];
    found.replaceChildren(...(finding ? [el("a", { href: "#finding/" + addressOf.get(finding) }, findingTitle(finding))] : []));
    if (!mesh) {
      facts.textContent = painter ? "This mesh is damaged." : "This browser has no WebGL: no 3D view.";
      return;
    }
    heat.disabled = mesh.measured === 0;
    facts.textContent = plural(mesh.position.length / 3, "vertex", "vertices") + ", " + plural(mesh.index.length / 3, "triangle") +
      (mesh.measured === 0 ? ", no heat measured" : mesh.measured < mesh.position.length / 3 ? ", heat measured at " + mesh.measured : "");
    const pen = legend.getContext("2d"), row = pen.createImageData(255, 1);
    for (let k = 0; k < 255; ++k) row.data.set([...mesh.palette.subarray(3 * k + 3, 3 * k + 6), 255], 4 * k);
    pen.putImageData(row, 0, 0);
    scale.replaceChildren(el("span", {}, name(words(view.heat))), el("span", { class: "num" }, number(view.heat_low)), legend,
      el("span", { class: "num" }, quantity(view.heat_high, view.unit)));
    scale.hidden = mesh.measured === 0;
    painter.load(mesh);
    paint();
  }
  let drag = null;
  holder.addEventListener("pointerdown", (event) => {
    drag = [event.clientX, event.clientY, { ...camera }, event.button === 2 || event.shiftKey];
    holder.setPointerCapture(event.pointerId);
  });
  holder.addEventListener("pointermove", (event) => {
    if (!drag) return;
    const [dx, dy] = [(event.clientX - drag[0]) / holder.clientHeight, (event.clientY - drag[1]) / holder.clientHeight];
    if (drag[3]) Object.assign(camera, { panX: drag[2].panX + 2 * dx / camera.zoom, panY: drag[2].panY - 2 * dy / camera.zoom });
    else turnTo(drag[2].azimuth - 4 * dx, drag[2].elevation + 4 * dy);
    paint();
  });
  for (const end of ["pointerup", "pointercancel"]) holder.addEventListener(end, () => { drag = null; });
  holder.addEventListener("contextmenu", (event) => event.preventDefault());
  holder.addEventListener("wheel", (event) => {
    if (!event.ctrlKey && document.activeElement !== holder) return;
    event.preventDefault();
    zoom(Math.exp(-event.deltaY / 400));
  }, { passive: false });
  function turnTo(azimuth, elevation) {
    Object.assign(camera, { azimuth, elevation: Math.min(1.55, Math.max(-1.55, elevation)) });
  }
  function zoom(factor) {
    camera.zoom = Math.min(20, Math.max(0.5, camera.zoom * factor));
    paint();
  }
  holder.addEventListener("keydown", (event) => {
    const step = { ArrowLeft: [0.15, 0], ArrowRight: [-0.15, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1] }[event.key];
    if (step) turnTo(camera.azimuth + step[0], camera.elevation + step[1]);
    else if (event.key === "+" || event.key === "=") zoom(1.25);
    else if (event.key === "-") zoom(0.8);
    else if (event.key === "0") turn(start);
    else return;
    event.preventDefault();
    paint();
  });
  canvas.addEventListener("webglcontextlost", (event) => { event.preventDefault(); painter = null; });
  canvas.addEventListener("webglcontextrestored", () => open(Number(menu.value)));
  new ResizeObserver(paint).observe(canvas);
  routes.set("mesh", ([i]) => {
    closeFinding();
    if (!meshViews[Number(i)]) return notice("This report has no such mesh.");
    open(Number(i));
    node.scrollIntoView();
  });
  const outside = report.meshes.length - meshViews.length;
  const node = section("solid", "In 3D", el("div", { class: "sweep-bar" }, menu, el("label", {}, heat, " heat"), angles, scale), holder,
    el("div", { class: "mesh-facts" }, found, facts),
    outside > 0 && el("p", { class: "soft" }, plural(outside, "more mesh", "more meshes") + " in the folders of their findings: ", code("pose.glb")));
  node.begin = () => open(0);
  return node;
}
