"""Bad input of every kind: one clear line, the exit code of the specification, nothing written."""

import base64
import json
import os
import struct
import tempfile
import unittest

import glb
import hostile
from harness import BACKBEND, BAD_INPUT, CANNOT_WRITE, CommandTest, USAGE, contents

# Every command that reads a character, with what it needs besides.
READERS = {
    "inspect": (),
    "check": ("--quick",),
    "render": ("-o", "out"),
    "turntable": ("--views", "2", "-o", "out"),
    "bake": ("--rig", "curve", "-o", "out.glb"),
}


class Usage(CommandTest):
    def test_a_command_line_that_makes_no_sense_is_2(self):
        for arguments in ([], ["chekc"], ["--nonsense"], ["solve"], ["check"], ["solve", "a", "b", "c"],
                          ["list", "nonsense"], ["turntable", "x.glb", "--views", "many"],
                          ["render", "x.glb", "--res", "big"], ["render", "x.glb", "--spp", "0"],
                          ["render", "x.glb", "--mapping", "both"], ["--threads", "-1", "list", "rigs"]):
            with self.subTest(arguments):
                self.assert_refused(*arguments, code=USAGE)

    def test_an_unknown_command_is_named_with_the_nearest(self):
        self.assert_refused("chekc", "hero.glb", code=USAGE, names=["chekc", "check"])
        self.assert_refused("--threads", "2", "rendr", code=USAGE, names=["rendr", "render"])

    def test_an_error_about_a_value_names_its_option(self):
        self.write("hero.glb", glb.tube())
        for option, value, command in (
                ("--res", "big", ["render", "hero.glb"]), ("--pose", "extensoin=90", ["render", "hero.glb"]),
                ("--sweep", "extensio", ["bake", "hero.glb", "-o", "out.glb"]),
                ("--joint-map", "spine", ["check", "--baked", "clip.bvh"])):
            with self.subTest(option):
                self.assert_refused(*command, option, value, code=USAGE, names=[option, value.split("=")[0]])

    def test_a_code_that_does_not_exist_is_2(self):
        self.assert_refused("explain", "BB999", code=USAGE, names=["BB999"])

    def test_help_and_version_are_data(self):
        for arguments in (["--help"], ["solve", "--help"], ["check", "--help"], ["--version"]):
            result = self.assert_runs(*arguments)
            self.assertNotEqual(result.stdout, "")
            self.assertEqual(result.stderr, "")


class BrokenCharacterInASuite(CommandTest):
    def test_a_character_that_cannot_be_read_is_a_finding_of_its_own_and_the_others_are_measured(self):
        self.write("good.glb", glb.tube())
        self.write("broken.glb", b"not a character")
        self.write("night.toml", """[suite]
characters = ["broken.glb", "good.glb"]
corners = false
[[rig]]
solver = { system = "even" }
[[sweep]]
channel = "extension"
to = 10
step = 5
""")
        done = self.backbend("nightly", "night.toml", "--quick", "--json", "-o", "out")
        report = json.loads(done.stdout)
        self.assertEqual(done.returncode, 3, done.stderr)
        (finding,) = [each for each in report["findings"] if each["character"] == "broken"]
        self.assertEqual((finding["code"], finding["verdict"], finding["owner"]), ("BB051", "not_measured", "INPUT"))
        self.assertIn("broken.glb", finding["detail"])
        self.assertNotIn("BB050", [each["code"] for each in report["findings"]])
        self.assertIn("BB051", [each["code"] for each in report["checks"]])
        self.assertEqual([each["name"] for each in report["characters"]], ["good"])
        self.assertIn("unreadable character", (self.folder / "out/index.html").read_text(encoding="utf-8"))


class Characters(CommandTest):
    def refuse(self, content, *names, file="hero.glb"):
        self.write(file, content)
        for command, more in READERS.items():
            with self.subTest(command=command):
                self.assert_refused(command, file, *more, names=(file, *names))

    def test_a_file_that_is_not_there(self):
        for command, more in READERS.items():
            with self.subTest(command):
                self.assert_refused(command, "missing.glb", *more, names=["missing.glb"])
                self.assert_refused(command, ".", *more)

    def test_a_file_of_another_format(self):
        self.refuse("solid cube\n", file="hero.stl")
        self.refuse("these are not the bytes of a model\n")
        self.refuse(b"")
        self.refuse(b"\x89PNG\r\n\x1a\n", file="hero.gltf")

    def test_a_file_that_was_cut_off(self):
        whole = glb.tube()
        for length in (3, 12, 19, 40, len(whole) // 2, len(whole) - 5):
            self.refuse(whole[:length])

    def test_a_model_without_a_skin(self):
        def without_skin(document):
            del document["skins"], document["nodes"][-1]["skin"]

        self.refuse(glb.tube(change=without_skin), "skin")

    def test_a_position_that_is_not_a_number(self):
        nan = lambda i, p, j, w: ([p[0], float("nan"), p[2]], j, w) if i == 20 else None
        self.refuse(glb.tube(vertex=nan), "20")

    def test_a_weight_that_is_not_a_number(self):
        nan = lambda i, p, j, w: (p, j, [float("nan"), 0, 0, 0]) if i == 20 else None
        self.refuse(glb.tube(vertex=nan), "20")

    def test_a_joint_past_the_skin(self):
        self.refuse(glb.tube(vertex=lambda i, p, j, w: (p, [99, 0, 0, 0], w) if i == 20 else None), "99")

    def test_an_accessor_past_its_buffer(self):
        def longer(document):
            document["accessors"][0]["count"] = 1 << 30

        self.refuse(glb.tube(change=longer))

    def test_nodes_that_are_their_own_ancestors(self):
        def loop(document):
            document["nodes"][4]["children"] = [0]

        self.refuse(glb.tube(change=loop))

    def test_a_buffer_outside_the_files_folder(self):
        def outside(document):
            document["buffers"][0]["uri"] = "../../../../../../etc/passwd"

        self.refuse(glb.tube(change=outside))

    def test_a_hostile_name_comes_out_escaped_on_one_line(self):
        def hostile(document):
            document["nodes"][0]["name"] = "hips\n\x1b[31mred\x07"
            del document["skins"][0]["joints"][1:]

        self.write("hero.glb", glb.tube(change=hostile))
        result = self.backbend("check", "hero.glb", "--quick")
        self.assertNotIn("\x1b[31m", result.stdout + result.stderr)
        self.assertNotIn("\x07", result.stdout + result.stderr)


class Hostile(CommandTest):
    """Files that nobody means well with, each in a process of its own whose memory is looked at."""

    MOST_BYTES = 512 << 20

    def run_on(self, file, content):
        """The outcome of reading a file; memory is judged where no sanitizer takes its share."""
        path = hostile.write(self.folder, file, content)
        words = ["body", path, "-o", str(self.folder / "out.glb")] if file.endswith(".bvh") else ["inspect", path]
        environment = {"PATH": os.environ["PATH"], "HOME": str(self.folder)}
        environment.update((k, v) for k, v in os.environ.items() if k.endswith("SAN_OPTIONS"))
        with tempfile.TemporaryDirectory() as logs:
            code, out, err, memory, _ = hostile.measured([str(BACKBEND), *words], environment, logs)
        left = list(contents(self.folder))
        os.unlink(path)
        self.assertEqual(left, [file])
        if not self.sanitized:
            self.assertLess(memory, self.MOST_BYTES, f"{memory >> 20} MB")
        return code, out, err

    @classmethod
    def setUpClass(cls):
        program = BACKBEND.read_bytes()
        cls.sanitized = b"__asan_" in program or b"__tsan_" in program

    def test_each_is_refused_in_one_line_that_names_it(self):
        for name, (file, content) in hostile.REFUSED.items():
            with self.subTest(name):
                code, out, err = self.run_on(file, content)
                self.assertEqual(code, BAD_INPUT, err)
                self.assertEqual(out, "")
                self.assertIn(file, err)
                self.assertEqual(err.count("\n"), 1, err)
                self.assertTrue(err[:-1].isprintable(), ascii(err))
                self.assertLess(len(err), 1000)

    def test_what_is_odd_and_legal_is_read_and_said(self):
        for name, (content, warning) in hostile.ACCEPTED.items():
            with self.subTest(name):
                code, out, err = self.run_on("hero.glb", content)
                self.assertEqual(code, 0, err)
                self.assertEqual(err, "")
                told = [line for line in out.splitlines() if line.startswith("  warning") or "weights" in line]
                self.assertIn(warning, "\n".join(told))
                self.assertTrue(out.replace("\n", "").isprintable())

    @unittest.skipUnless(hasattr(os, "mkfifo"), "this system has no FIFOs")
    def test_a_pipe_is_refused_and_not_waited_for(self):
        os.mkfifo(self.folder / "hero.glb")
        self.assert_refused("inspect", "hero.glb", names=["hero.glb"], timeout_s=60)


class Spines(CommandTest):
    def test_a_skeleton_without_a_spine_is_refused_by_what_must_bend_it(self):
        self.write("post.glb", glb.tube(names=["post"]))
        for command in ("check", "render", "turntable", "bake"):
            with self.subTest(command):
                self.assert_refused(command, "post.glb", *READERS[command], names=["post.glb", "spine"])

    def test_joints_that_do_not_exist_are_named(self):
        self.write("hero.glb", glb.tube())
        result = self.backbend("inspect", "hero.glb", "--hip", "nonesuch")
        self.assertIn(result.returncode, (USAGE, BAD_INPUT), result.stderr)
        self.assert_refused("inspect", "hero.glb", "--hip", "nonesuch", code=result.returncode,
                            names=["nonesuch"])

    def test_an_unknown_rig_is_named_with_the_nearest(self):
        self.write("hero.glb", glb.tube())
        for command in ("check", "render", "turntable", "bake"):
            with self.subTest(command):
                more = [word for word in READERS[command] if word not in ("--rig", "curve")]
                self.assert_refused(command, "hero.glb", *more, "--rig", "curv", names=["curv", "curve"])

    def test_a_pose_of_unknown_channels_or_numbers(self):
        self.write("hero.glb", glb.tube())
        for pose in ("extensoin=90", "extension", "extension=ninety", "extension=nan", "extension=1e999"):
            with self.subTest(pose):
                result = self.backbend("render", "hero.glb", "--pose", pose, "-o", "out")
                self.assertIn(result.returncode, (USAGE, BAD_INPUT), result.stderr)
                self.assert_refused("render", "hero.glb", "--pose", pose, "-o", "out", code=result.returncode)


class Suites(CommandTest):
    GOOD = '[suite]\nname = "mine"\ncharacters = ["hero.glb"]\n\n[[rig]]\nname = "a"\nrole = "proposed"\nsolver = { system = "curve" }\n'

    def refuse(self, text, *names):
        self.write("hero.glb", glb.tube())
        self.write("mine.toml", text)
        self.assert_refused("nightly", "mine.toml", names=("mine.toml", *names))

    def test_a_suite_that_is_not_there(self):
        self.assert_refused("nightly", "missing.toml", names=["missing.toml"])

    def test_what_is_no_suite(self):
        self.refuse("")
        self.refuse("[suite\n", ":1")

    def test_unknown_keys_rigs_and_roles(self):
        self.refuse(self.GOOD.replace("characters", "charakters"), ":3", "charakters", "characters")
        self.refuse(self.GOOD.replace("role", "rôle"))
        self.refuse(self.GOOD.replace('"proposed"', '"propsed"'), "propsed")
        self.refuse(self.GOOD.replace('"curve"', '"curv"'), "curv")
        self.refuse(self.GOOD.replace("[[rig]]", "[[rgi]]"), "rgi")
        self.refuse(self.GOOD.replace('{ system = "curve" }', '{ system = "curve", bones = nan }'))


class Pictures(CommandTest):
    """What cannot be shown: said in one line, and no picture is begun."""

    def refuse(self, content, *names, more=(), size="32x32"):
        self.write("hero.glb", content)
        self.assert_refused("render", "hero.glb", "--rig", "three_bone", "--res", size, "--spp", "1", *more,
                            "-o", ".", names=names)

    @staticmethod
    def textured(uri):
        def change(document):
            document["images"] = [{"uri": uri}]
            document["textures"] = [{"source": 0}]
            document["materials"] = [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}]
            document["meshes"][0]["primitives"][0]["material"] = 0
        return glb.tube(change=change)

    def test_a_texture_that_is_missing_is_named_where_it_would_be_seen(self):
        missing = self.textured("nowhere.png")
        self.refuse(missing, "hero.glb", "/images/0", "nowhere.png", more=("--mode", "beauty"))
        self.assert_runs("render", "hero.glb", "--rig", "three_bone", "--res", "32x32", "--spp", "1", "-o", "clay")

    def test_a_texture_that_is_no_picture_is_named(self):
        self.write("words.png", "no picture")
        self.refuse(self.textured("words.png"), "hero.glb", "image 0", more=("--mode", "beauty"))

    def test_a_mesh_without_triangles_or_extent(self):
        def none(document):
            document["accessors"][3]["count"] = 0

        self.refuse(glb.tube(change=none), "hero.glb")
        self.refuse(glb.tube(vertex=lambda i, p, j, w: ([0, 0, 0], j, w)), "hero.glb", "extent")

    def test_normals_that_are_not_numbers(self):
        def nan_normals(document):
            normals = struct.pack("<216f", *[float("nan")] * 216)
            uri = "data:application/octet-stream;base64," + base64.b64encode(normals).decode()
            document["buffers"].append({"uri": uri, "byteLength": len(normals)})
            document["bufferViews"].append({"buffer": 1, "byteLength": len(normals)})
            document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": 5126,
                                          "type": "VEC3", "count": 72})
            document["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = len(document["accessors"]) - 1

        self.refuse(glb.tube(change=nan_normals), "hero.glb", "not a number")

    def test_triangles_without_area_are_no_trouble(self):
        self.write("hero.glb", glb.tube(vertex=lambda i, p, j, w: ([0, p[1], 0], j, w)))
        self.assert_runs("render", "hero.glb", "--rig", "three_bone", "--res", "32x32", "--spp", "2", "-o", "out")

    def test_a_size_that_is_absurd(self):
        self.write("hero.glb", glb.tube())
        for size in ("0x10", "100000x100000", "-5x5", "16x", "1e3x16"):
            with self.subTest(size):
                self.assert_refused("render", "hero.glb", "--res", size, "-o", "out", code=USAGE, names=["size"])
        pages = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGESIZE")
        if pages > 100 << 30:
            self.skipTest("this machine has memory for the largest picture")
        self.refuse(glb.tube(), "16384x16384", "GB", more=("--aovs", "all"), size="16384x16384")


class Writing(CommandTest):
    def test_a_folder_that_cannot_be_made_is_73(self):
        hero = self.write("hero.glb", glb.tube())
        self.write("taken", "a file where a folder would be")
        for command in ("render", "turntable"):
            with self.subTest(command):
                more = ("--views", "2") if command == "turntable" else ()
                self.assert_refused(command, hero, "--rig", "curve", *more, "-o", "taken/out",
                                    code=CANNOT_WRITE, names=["taken"])
