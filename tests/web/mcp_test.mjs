// A client of the Model Context Protocol that others wrote (@modelcontextprotocol/sdk) uses `backbend serve`.
//
// node mcp_test.mjs BACKBEND CHARACTER: the program, and a character file with a mesh. tests/cli/serve_test.py runs it.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { copyFileSync, mkdtempSync, readdirSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { Client } from "@modelcontextprotocol/sdk/client/index.js";
import { StdioClientTransport } from "@modelcontextprotocol/sdk/client/stdio.js";

const [backbend, character] = process.argv.slice(2);
if (!character) {
  console.error("usage: node mcp_test.mjs BACKBEND CHARACTER");
  process.exit(2);
}
const folder = mkdtempSync(join(tmpdir(), "backbend-mcp-"));
copyFileSync(character, join(folder, "hero.glb"));
const kPatience_ms = 600000;

async function session(options, use) {
  const transport = new StdioClientTransport({
    command: backbend, args: ["serve", "--stdio", "--root", folder, ...options],
    env: { PATH: process.env.PATH, HOME: folder }, stderr: "inherit" });
  const client = new Client({ name: "backbend-test", version: "1" });
  const troubles = [];
  client.onerror = (error) => troubles.push(error);
  await client.connect(transport);
  await use(client);
  await client.close();
  assert.deepEqual(troubles, [], "every line was one that the client understands");
}

const call = (client, name, args, more = {}) =>
  client.callTool({ name, arguments: args }, undefined, { timeout: kPatience_ms, ...more });

await session([], async (client) => {
  assert.equal(client.getServerVersion().name, "backbend");
  await client.ping();
  const { tools } = await client.listTools();
  assert.deepEqual(tools.map((tool) => tool.name), ["check", "explain", "compare", "repair", "picture", "inspect", "list"]);
  for (const tool of tools) {
    assert.equal(tool.annotations.readOnlyHint, true, tool.name);
    assert.ok(!("output" in tool.inputSchema.properties), tool.name);
  }

  const explained = await call(client, "explain", { code: "BB011" });
  assert.equal(explained.structuredContent.code, "BB011");

  const heard = [];
  const checked = await call(client, "check", { character: "hero.glb" }, { onprogress: (told) => heard.push(told) });
  assert.notEqual(checked.isError, true, JSON.stringify(checked.content));
  const said = JSON.parse(execFileSync("sh", ["-c", '"$0" check hero.glb --json -q -o - || test $? -eq 1 -o $? -eq 5', backbend],
    { cwd: folder, encoding: "utf8", maxBuffer: 1 << 28 }));
  assert.equal(checked.structuredContent.exit_code, said.exit_code);
  assert.equal(checked.structuredContent.findings_in_all, said.findings.length);
  assert.deepEqual(checked.structuredContent.rigs[0].headroom, said.rigs[0].headroom);
  assert.ok(heard.length > 0, "progress is told");
  heard.reduce((before, told) => (assert.ok(told.progress > before, "progress rises"), told.progress), -1);

  const picture = await call(client, "picture",
    { character: "hero.glb", pose: "extension=90", width: 160, height: 120, samples: 1 });
  const [image] = picture.content;
  assert.equal(image.mimeType, "image/png");
  const png = Buffer.from(image.data, "base64");
  assert.equal(png.subarray(1, 4).toString(), "PNG");
  assert.deepEqual([png.readUInt32BE(16), png.readUInt32BE(20)], [160, 120]);

  const repaired = await call(client, "repair", { character: "hero.glb" });
  assert.equal(repaired.structuredContent.schema, "backbend.repair/1");

  for (const [tool, args] of [
    ["check", { character: "../hero.glb" }], ["check", { character: "/etc/passwd" }],
    ["check", { character: "hero.glb", rig: "command:touch x" }], ["check", { character: "hero.glb", output: "run" }],
    ["inspect", { character: "absent.glb" }]]) {
    const refused = await call(client, tool, args);
    assert.equal(refused.isError, true, JSON.stringify(args));
  }

  const stop = new AbortController();
  const long = call(client, "compare", { a: "curve", b: "isner", character: "hero.glb" },
    { signal: stop.signal, onprogress: () => stop.abort("enough") });
  await assert.rejects(long, /enough/);
  await client.ping();
  assert.equal((await call(client, "list", { what: "rigs" })).isError, false, "the server works on");
});
assert.deepEqual(readdirSync(folder), ["hero.glb"], "a server that only reads leaves nothing");

await session(["--allow-write"], async (client) => {
  const { tools } = await client.listTools();
  assert.ok("output" in tools.find((tool) => tool.name === "check").inputSchema.properties);
  const run = await call(client, "check", { character: "hero.glb", output: "run" });
  assert.notEqual(run.isError, true, JSON.stringify(run.content));
  assert.ok(readdirSync(join(folder, "run")).includes("report.json"));
  const again = await call(client, "check", { character: "hero.glb", output: "run" });
  assert.equal(again.isError, true, "an output replaces nothing");
});
rmSync(folder, { recursive: true });
