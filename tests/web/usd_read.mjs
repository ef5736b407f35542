// What readers of others make of a USD file: three's USDLoader, which poses and skins it by itself, its parser's
// plain values, and tinyusdz, a C++ reader with USD's types.
//
// node usd_read.mjs FILE.usda TIMES: time codes separated by commas. Prints one JSON object:
//   posed: for each time, joints {name: 16 numbers, column by column} and meshes {name: points}, world space
//   values: {"/prim.attribute": value}, {"/prim.attribute@samples": {time: value}}; elementSize as `:elementSize`
//   meshes: {name: {points, faceVertexIndices, faceVertexCounts}}
import { readFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { AnimationMixer, LoopOnce, Vector3 } from "three";
import { USDLoader } from "three/examples/jsm/loaders/USDLoader.js";
import { USDAParser } from "three/examples/jsm/loaders/usd/USDAParser.js";

const [file, times] = process.argv.slice(2);
const bytes = readFileSync(file);
const text = bytes.toString("utf8");
const parsed = new USDAParser().parseData(text).specsByPath;

function posed(time) {
  const group = new USDLoader().parse(text);
  const rate = parsed["/"].fields.timeCodesPerSecond;
  if (group.animations.length > 0) {
    const mixer = new AnimationMixer(group);
    const action = mixer.clipAction(group.animations[0]);
    action.setLoop(LoopOnce);
    action.clampWhenFinished = true;
    action.play();
    mixer.setTime(Math.fround(time / rate));  // keys are kept in single precision
  }
  group.updateMatrixWorld(true);
  const joints = {}, meshes = {};
  group.traverse((thing) => {
    if (!thing.isSkinnedMesh) return;
    thing.skeleton.update();
    for (const bone of thing.skeleton.bones) joints[bone.name] = bone.matrixWorld.toArray();
    const place = new Vector3();
    const points = [];
    for (let v = 0; v < thing.geometry.attributes.position.count; ++v) {
      thing.getVertexPosition(v, place).applyMatrix4(thing.matrixWorld);
      points.push(place.toArray());
    }
    meshes[thing.name] = points;
  });
  return { joints, meshes };
}

const values = {};
for (const [path, spec] of Object.entries(parsed)) {
  if (!path.includes(".")) continue;
  if (spec.fields.default !== undefined) values[path] = spec.fields.default;
  if (spec.fields.elementSize !== undefined) values[path + ":elementSize"] = spec.fields.elementSize;
  if (spec.fields.timeSamples !== undefined)
    values[path + "@samples"] = Object.fromEntries(
      spec.fields.timeSamples.times.map((time, i) => [time, spec.fields.timeSamples.values[i]]));
}

async function typedMeshes() {
  // The package is built for browsers; the reader itself needs nothing of one.
  globalThis.window = globalThis;
  Object.defineProperty(process, "type", { value: "renderer" });
  const { default: start } = await import("tinyusdz/tinyusdz.js");
  const folder = join(dirname(fileURLToPath(import.meta.url)), "node_modules/tinyusdz");
  const module = await start({ wasmBinary: readFileSync(join(folder, "tinyusdz.wasm")) });
  const reader = new module.TinyUSDZLoaderNative();
  if (!reader.loadFromBinary(bytes, "file.usda")) throw new Error("tinyusdz: the file cannot be read");
  const meshes = {};
  for (let i = 0; i < reader.numMeshes(); ++i) {
    const mesh = reader.getMesh(i);
    meshes[mesh.primName] = Object.fromEntries(
      ["points", "faceVertexIndices", "faceVertexCounts"].map((key) => [key, [...mesh[key]]]));
  }
  return meshes;
}

const result = { posed: Object.fromEntries(times.split(",").map((time) => [time, posed(Number(time))])), values,
  meshes: await typedMeshes() };
process.stdout.write(JSON.stringify(result));
