"""backbend serve --stdio: agents use the commands by the Model Context Protocol, and cannot leave their folder."""

import base64
import json
import os
import shutil
import signal
import struct
import subprocess
import threading

from glb import tube
from harness import BACKBEND, PATIENCE_S, SOURCE, CommandTest, bare_environment, contents, human

NODE = shutil.which("node")
WEB = SOURCE / "tests/web"
VERSION = "2025-11-25"


class Client:
    """One server, and the lines to and from it."""

    def __init__(self, folder, *options, home=None):
        self.process = subprocess.Popen([str(BACKBEND), "serve", "--stdio", *map(str, options)], cwd=folder,
                                        env=bare_environment(home or folder), stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        self.guard = threading.Timer(PATIENCE_S, self.process.kill)
        self.guard.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.kill()
        self.process.communicate()
        self.guard.cancel()

    def send(self, message):
        line = message if isinstance(message, bytes) else json.dumps(message).encode()
        self.process.stdin.write(line + b"\n")
        self.process.stdin.flush()

    def read(self):
        line = self.process.stdout.readline()
        if not line:
            raise AssertionError("the server ended: " + self.process.stderr.read().decode())
        return json.loads(line)

    def ask(self, method, params=None, number=1):
        self.send({"jsonrpc": "2.0", "id": number, "method": method, **({} if params is None else {"params": params})})
        return self.read()

    def begin(self, version=VERSION):
        answer = self.ask("initialize", {"protocolVersion": version, "capabilities": {},
                                         "clientInfo": {"name": "test", "version": "1"}})
        self.send({"jsonrpc": "2.0", "method": "notifications/initialized"})
        return answer["result"]

    def call(self, tool, arguments, number=2):
        return self.ask("tools/call", {"name": tool, "arguments": arguments}, number)["result"]

    def end(self):
        """Closes the client's side; what the server still says, its complaints and its exit code."""
        rest, complaints = self.process.communicate(timeout=PATIENCE_S)
        return rest, complaints, self.process.returncode


class Beginning(CommandTest):
    def test_a_version_that_both_speak_is_taken_and_another_one_is_answered_with_ours(self):
        for asked, taken in ((VERSION, VERSION), ("2025-06-18", "2025-06-18"), ("2024-11-05", "2024-11-05"),
                             ("2099-01-01", VERSION), ("2025-03-26", VERSION)):
            with self.subTest(asked), Client(self.folder) as client:
                begun = client.begin(asked)
                self.assertEqual(begun["protocolVersion"], taken)
                self.assertEqual(begun["capabilities"], {"tools": {}})
                self.assertEqual(begun["serverInfo"]["name"], "backbend")

    def test_nothing_but_a_ping_is_answered_before_the_session_begins(self):
        with Client(self.folder) as client:
            self.assertEqual(client.ask("ping")["result"], {})
            self.assertEqual(client.ask("tools/list")["error"]["code"], -32600)
            client.begin()
            self.assertEqual(len(client.ask("tools/list")["result"]["tools"]), 7)
            self.assertEqual(client.ask("initialize", {"protocolVersion": VERSION})["error"]["code"], -32600)

    def test_it_ends_with_its_input_after_all_that_was_asked_is_answered(self):
        with Client(self.folder) as client:
            client.begin()
            client.send({"jsonrpc": "2.0", "id": "last", "method": "tools/call",
                         "params": {"name": "list", "arguments": {"what": "rigs"}}})
            rest, complaints, code = client.end()
            self.assertEqual(json.loads(rest)["id"], "last")
            self.assertEqual((complaints, code), (b"", 0))

    def test_a_signal_ends_it(self):
        for number, expected in ((signal.SIGTERM, 143), (signal.SIGINT, 130)):
            with Client(self.folder) as client:
                client.begin()
                client.process.send_signal(number)
                self.assertEqual(client.process.wait(PATIENCE_S), expected)

    def test_without_stdio_and_with_a_root_that_is_no_folder_it_is_refused(self):
        self.assert_refused("serve", code=2, names=["--stdio"])
        self.assert_refused("serve", "--stdio", "--root", "nowhere", code=2, names=["nowhere"])


class Tools(CommandTest):
    def setUp(self):
        super().setUp()
        self.write("hero.glb", tube())

    def test_a_check_says_what_the_command_says_and_writes_nothing(self):
        before = contents(self.folder)
        with Client(self.folder) as client:
            client.begin()
            told = client.call("check", {"character": "hero.glb"})["structuredContent"]
        report = json.loads(self.backbend("check", "hero.glb", "--json", "-o", "-").stdout)
        self.assertEqual(told["verdict"], report["verdict"])
        self.assertEqual(told["exit_code"], report["exit_code"])
        self.assertEqual(told["findings_in_all"], len(report["findings"]))
        self.assertEqual([f["code"] for f in told["findings"]], [f["code"] for f in report["findings"]][:50])
        self.assertEqual(told["rigs"][0]["headroom"], report["rigs"][0]["headroom"])
        self.assertNotIn("sweeps", told["rigs"][0])
        self.assertEqual(contents(self.folder), before)

    def test_a_picture_is_that_of_render(self):
        with Client(self.folder) as client:
            client.begin()
            content = client.call("picture", {"character": "hero.glb", "pose": "extension=60", "width": 64,
                                              "height": 64, "samples": 1})["content"]
        self.assertEqual([(c["type"], c["mimeType"]) for c in content], [("image", "image/png")])
        png = base64.b64decode(content[0]["data"], validate=True)
        self.assertEqual(struct.unpack(">II", png[16:24]), (64, 64))
        self.assert_runs("render", "hero.glb", "--pose", "extension=60", "--res", "64x64", "--spp", "1", "-o", "out")
        self.assertEqual(png, (self.folder / "out/hero_even.png").read_bytes())

    def test_repair_is_a_dry_run_until_an_output_is_named(self):
        before = contents(self.folder)
        with Client(self.folder) as client:
            client.begin()
            told = client.call("repair", {"character": "hero.glb"})["structuredContent"]
        self.assertEqual(told["schema"], "backbend.repair/1")
        self.assertEqual(contents(self.folder), before)

    def test_explain_list_inspect_and_compare_answer_as_their_commands(self):
        with Client(self.folder) as client:
            client.begin()
            self.assertEqual(client.call("explain", {"code": "BB011"})["structuredContent"]["code"], "BB011")
            # The name of a command is a word like any other.
            self.assertTrue(client.call("explain", {"code": "check"})["isError"])
            rigs = client.call("list", {"what": "rigs"})["structuredContent"]["list"]
            self.assertIn("even", [row["name"] for row in rigs])
            self.assertIn("hips", json.dumps(client.call("inspect", {"character": "hero.glb"})))
            compared = client.call("compare", {"a": "curve", "b": "three_bone", "character": "hero.glb",
                                               "sweeps": "standard"})["structuredContent"]
            self.assertEqual(compared["comparisons"][0]["a"], "curve")

    def test_what_a_command_refuses_is_an_answer_with_the_command_lines_words(self):
        with Client(self.folder) as client:
            client.begin()
            self.write("broken.glb", b"glTF")
            for tool, arguments, words in (
                    ("check", {"character": "broken.glb"}, "broken.glb"),
                    ("check", {}, "character"),
                    ("check", {"charcter": "hero.glb"}, "did you mean 'character'"),
                    ("check", {"character": "hero.glb", "rig": "evn"}, "even"),
                    ("check", {"character": 5}, "string"),
                    ("explain", {}, "code"),
                    ("picture", {"character": "hero.glb", "width": 1e9}, "whole number"),
                    ("picture", {"character": "hero.glb", "width": 10 ** 18}, "64 to 1920"),
                    ("picture", {"character": "hero.glb", "pose": "extension=zero"}, "extension")):
                with self.subTest(arguments):
                    result = client.call(tool, arguments)
                    self.assertTrue(result["isError"], result)
                    self.assertIn(words, result["content"][0]["text"])
                    self.assertTrue(result["content"][0]["text"].isprintable())


class ReadingOnly(CommandTest):
    """What a client may name ends at the server's folders, and it starts no program."""

    def setUp(self):
        super().setUp()
        self.root = self.folder / "root"
        self.write("root/hero.glb", tube())
        self.write("outside.glb", tube())
        (self.root / "link.glb").symlink_to(self.folder / "outside.glb")
        (self.root / "way").symlink_to(self.folder)

    def refused(self, client, tool, arguments):
        result = client.call(tool, arguments)
        self.assertTrue(result["isError"], (arguments, result))
        return result["content"][0]["text"]

    def test_files_outside_are_refused_however_they_are_named(self):
        before = contents(self.folder)
        with Client(self.root, home=self.folder) as client:
            client.begin()
            for name in ("../outside.glb", str(self.folder / "outside.glb"), "/etc/passwd", "link.glb", "way/outside.glb",
                         "x/../../outside.glb", "/proc/self/environ"):
                self.assertIn("outside the folders", self.refused(client, "check", {"character": name}), name)
                self.assertIn("outside the folders", self.refused(client, "compare", {"a": "hero.glb", "b": name}), name)
            self.assertIn("NUL", self.refused(client, "inspect", {"character": "hero.glb\0"}))
            self.assertIn("'-'", self.refused(client, "check", {"character": "--help"}))
        self.assertEqual(contents(self.folder), before)

    def test_rigs_that_start_a_program_are_refused(self):
        self.write("root/live.toml", '[rig]\nsystem = "external"\nprogram = "command"\ncommand = "touch made"\n')
        with Client(self.root, home=self.folder) as client:
            client.begin()
            for rig in ("command:touch made", "blender:hero.blend", "live.toml", 'external:program="command",command="touch made"'):
                self.refused(client, "check", {"character": "hero.glb", "rig": rig})
                self.refused(client, "picture", {"character": "hero.glb", "rig": rig})
                self.refused(client, "compare", {"a": rig, "b": "even", "character": "hero.glb"})
        self.assertEqual(list(self.folder.rglob("made")), [])

    def test_outputs_are_refused_unless_writing_was_allowed_and_then_replace_nothing(self):
        with Client(self.root, home=self.folder) as client:
            client.begin()
            for tool, output in (("repair", "fixed.glb"), ("check", "run"), ("compare", "run")):
                arguments = {"character": "hero.glb", "output": output}
                self.assertIn("--allow-write", self.refused(client, tool, {**arguments, "a": "even", "b": "even"}
                                                            if tool == "compare" else arguments))
        before = contents(self.folder)
        with Client(self.root, "--allow-write", home=self.folder) as client:
            client.begin()
            for output in ("hero.glb", "../new.glb", "link.glb", "way/new.glb"):
                self.refused(client, "repair", {"character": "hero.glb", "output": output})
            self.assertEqual(contents(self.folder), before)
            ran = client.call("check", {"character": "hero.glb", "output": "run"})
            self.assertFalse(ran["isError"], ran)
            self.assertTrue((self.root / "run/report.json").is_file())

    def test_a_folder_beside_the_root_whose_name_begins_alike_is_outside(self):
        self.write("root2/hero.glb", tube())
        with Client(self.root, home=self.folder) as client:
            client.begin()
            self.refused(client, "inspect", {"character": "../root2/hero.glb"})
        with Client(self.root, "--root", self.root, "--root", self.folder / "root2", home=self.folder) as client:
            client.begin()
            self.assertFalse(client.call("inspect", {"character": "../root2/hero.glb"})["isError"])


class HostileLines(CommandTest):
    def test_every_line_that_is_no_message_gets_one_error_and_the_session_goes_on(self):
        deep = b"[" * 100000
        with Client(self.folder) as client:
            client.begin()
            for line, code in ((b"{", -32700), (b"\xff\xfe", -32700), (deep, -32600), (b"[]", -32600), (b"5", -32600),
                               (b'{"jsonrpc": "1.0", "id": 1, "method": "ping"}', -32600),
                               (b'{"jsonrpc": "2.0", "id": {}, "method": "ping"}', -32600),
                               (b'{"jsonrpc": "2.0", "id": 1.5, "method": "ping"}', -32600),
                               (b'{"jsonrpc": "2.0", "id": 1}', -32600),
                               (b'{"jsonrpc": "2.0", "id": 1, "method": 5}', -32600),
                               (b'{"jsonrpc": "2.0", "id": 1, "method": "ping", "params": []}', -32600),
                               (b'{"jsonrpc": "2.0", "id": 1, "method": "no/such"}', -32601),
                               (b'{"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {}}', -32602),
                               (b'{"jsonrpc": "2.0", "id": 1, "method": "tools/call", "params": {"name": "rm"}}', -32602),
                               (b'"' + b"x" * 3000000 + b'"', -32600)):
                with self.subTest(line[:80]):
                    client.send(line)
                    self.assertEqual(client.read()["error"]["code"], code)
                    self.assertEqual(client.ask("ping", number="still here"), {"jsonrpc": "2.0", "id": "still here", "result": {}})

    def test_responses_and_unknown_notifications_are_passed_over(self):
        with Client(self.folder) as client:
            client.begin()
            client.send({"jsonrpc": "2.0", "id": 9, "result": {}})
            client.send({"jsonrpc": "2.0", "method": "notifications/what"})
            client.send({"jsonrpc": "2.0", "method": "notifications/cancelled", "params": {"requestId": 77}})
            client.send(b"   ")
            self.assertEqual(client.ask("ping", number=3)["id"], 3)


class LongCalls(CommandTest):
    def setUp(self):
        super().setUp()
        shutil.copy(human(), self.folder / "hero.glb")

    def start(self, client, number, token=None):
        meta = {} if token is None else {"_meta": {"progressToken": token}}
        client.send({"jsonrpc": "2.0", "id": number, "method": "tools/call",
                     "params": {"name": "compare", "arguments": {"a": "curve", "b": "isner", "character": "hero.glb"},
                                **meta}})

    def test_progress_rises_pings_are_answered_and_a_call_given_up_has_no_answer(self):
        with Client(self.folder) as client:
            client.begin()
            self.start(client, 7, token="t")
            heard = []
            while len(heard) < 3:
                told = client.read()
                self.assertEqual(told["method"], "notifications/progress")
                self.assertEqual(told["params"]["progressToken"], "t")
                heard.append(told["params"]["progress"])
            self.assertEqual(heard, sorted(set(heard)))
            client.send({"jsonrpc": "2.0", "method": "notifications/cancelled", "params": {"requestId": 7}})
            client.send({"jsonrpc": "2.0", "id": "p", "method": "ping"})
            client.send({"jsonrpc": "2.0", "id": 8, "method": "tools/call",
                         "params": {"name": "list", "arguments": {"what": "views"}}})
            answers = []
            while not answers or answers[-1] != 8:
                told = client.read()
                if "id" in told:
                    answers.append(told["id"])
            self.assertEqual(answers, ["p", 8])

    def test_the_queue_is_bounded_and_ids_in_use_are_refused(self):
        with Client(self.folder) as client:
            client.begin()
            for number in range(18):
                self.start(client, number)
            self.start(client, 3)
            refused = [client.read() for _ in range(3)]
            self.assertEqual([r["id"] for r in refused], [16, 17, 3])
            self.assertEqual([r["error"]["code"] for r in refused], [-32000, -32000, -32600])

    def test_a_signal_in_the_middle_of_work_ends_it(self):
        with Client(self.folder) as client:
            client.begin()
            self.start(client, 1, token=1)
            client.read()
            client.process.send_signal(signal.SIGTERM)
            self.assertEqual(client.process.wait(PATIENCE_S), 143)


class ServingAnOutsideClient(CommandTest):
    """The client of the protocol's own SDK, from npm (npm ci --prefix tests/web)."""

    def test_it_finds_nothing_to_complain_of(self):
        if not NODE or not (WEB / "node_modules/@modelcontextprotocol/sdk").is_dir():
            self.skipTest("Node or @modelcontextprotocol/sdk (npm ci --prefix tests/web) is not installed")
        told = subprocess.run([NODE, WEB / "mcp_test.mjs", BACKBEND, self.write("tube.glb", tube())], capture_output=True, text=True,
                              timeout=4 * PATIENCE_S, env={**os.environ, "TMPDIR": str(self.folder)})
        self.assertEqual(told.returncode, 0, told.stdout + told.stderr)
