"""backbend render and turntable: the files they leave, and that other programs read them."""

import json
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import glb
from exr import Exr
from harness import CommandTest, SOURCE, contents, human, run_backbend

HUMAN = human()
SMALL = ("--rig", "curve", "--res", "96x72", "--spp", "1")
BEND = ("--pose", "extension=90")


# Takes one pass of a frame through Blender's compositor and writes it again.
BLENDER_COPY = """
import bpy, sys
frame, socket, target = sys.argv[-3:]
scene = bpy.context.scene
scene.use_nodes = True
scene.node_tree.nodes.clear()
source = scene.node_tree.nodes.new("CompositorNodeImage")
source.image = bpy.data.images.load(frame)
scene.node_tree.links.new(source.outputs[socket], scene.node_tree.nodes.new("CompositorNodeComposite").inputs["Image"])
scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = 96, 72, 100
scene.render.image_settings.file_format = "OPEN_EXR"
scene.render.image_settings.color_depth = "32"
scene.render.filepath = target
bpy.ops.render.render(write_still=True)
"""


def told_by(*command):
    return subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=300,
                          check=True).stdout


class Turntables(unittest.TestCase):
    """One small turntable of three views, looked at from all sides."""

    @classmethod
    def setUpClass(cls):
        holder = tempfile.TemporaryDirectory(prefix="backbend turntable ")
        cls.addClassCleanup(holder.cleanup)
        cls.folder = pathlib.Path(holder.name)
        cls.result = run_backbend(["turntable", HUMAN, *SMALL, *BEND, "--views", "3", "-o", "out"], cls.folder)

    def test_frames_sheet_and_film_are_written_and_named_on_stdout(self):
        self.assertEqual(self.result.returncode, 0, self.result.stderr)
        names = [f"out/human_curve.{frame}.exr" for frame in (1001, 1002, 1003)]
        names += ["out/human_curve_sheet.png", "out/human_curve.mp4"]
        self.assertEqual(self.result.stdout.splitlines(), names)
        self.assertEqual(sorted(contents(self.folder)), sorted(["out", *names]))

    def test_oiiotool_reads_every_channel_of_the_specification(self):
        told = told_by("oiiotool", "--info", "-v", "--stats", self.folder / "out/human_curve.1001.exr")
        self.assertIn("96 x   72", told)
        (channels,) = [line.split(":", 1)[1] for line in told.splitlines() if "channel list:" in line]
        present = {word.split()[0] for word in channels.split(",")}
        self.assertLessEqual({"R", "G", "B", "A", "Z", "N.X", "N.Y", "N.Z", "P.X", "P.Y", "P.Z",
                              "albedo.R", "albedo.G", "albedo.B"}, present)
        mattes = {name[:-4] for name in present if name.startswith("Crypto")}
        self.assertGreaterEqual(len(mattes), 2)  # by object, and by region of the body
        for name in mattes:  # six ranks are three layers, channels in lower case
            self.assertLessEqual({f"{name}{rank:02}.{c}" for rank in range(3) for c in "rgba"}, present)
        for attribute in ("worldToCamera", "worldToNDC", "framesPerSecond", "chromaticities", "backbend/rig"):
            self.assertIn(attribute + ":", told)
        # Something is to be seen, and nothing is infinite.
        self.assertRegex(told, r"Stats NanCount:( 0)+\s")
        self.assertRegex(told, r"Stats InfCount:( 0)+\s")
        self.assertNotRegex(told, r"Stats Max: 0\.0+ ")

    def test_no_clock_host_or_path_is_in_a_frame(self):
        told = told_by("oiiotool", "--info", "-v", self.folder / "out/human_curve.1001.exr")
        for word in ("capDate", "DateTime", "HostComputer", "hostname", str(SOURCE), str(self.folder.name)):
            for line in told.splitlines()[2:]:  # those above name the file that was asked for
                self.assertNotIn(word, line)

    def test_the_film_shows_every_view_once(self):
        probe = json.loads(told_by("ffprobe", "-v", "error", "-count_frames", "-show_streams", "-of", "json",
                                   self.folder / "out/human_curve.mp4"))["streams"]
        self.assertEqual(len(probe), 1)
        self.assertEqual(int(probe[0]["nb_read_frames"]), 3)
        self.assertEqual(probe[0]["color_space"], "bt709")

    @unittest.skipUnless(shutil.which("blender"), "blender is not on this machine")
    def test_blender_reads_the_same_numbers(self):
        frame, copy = self.folder / "out/human_curve.1001.exr", self.folder / "copy.exr"
        for socket, channels in (("Combined", "R,G,B"), ("albedo", "albedo.R,albedo.G,albedo.B")):
            told_by("blender", "--background", "--factory-startup", "--python-exit-code", "3", "--python-expr",
                    BLENDER_COPY, "--", frame, socket, copy)
            told_by("oiiotool", frame, "--ch", channels, copy, "--ch", "R,G,B", "--fail", "1e-6", "--diff")
            copy.unlink()


class Rendering(CommandTest):
    def render(self, out, *more, **options):
        return self.assert_runs("render", HUMAN, *SMALL, "-o", out, *more, **options)

    def test_one_pose_is_one_frame_and_its_preview(self):
        result = self.render("out", *BEND)
        self.assertEqual(sorted(path.suffix for path in (self.folder / "out").iterdir()), [".exr", ".png"])
        for line in result.stdout.splitlines():
            self.assertTrue((self.folder / line).is_file(), line)

    def test_the_same_bytes_for_any_thread_count_and_locale(self):
        self.render("a", *BEND)
        self.render("b", *BEND, "--threads", "1")
        self.render("c", *BEND, environment={"LC_ALL": "de_DE.UTF-8", "TZ": "Asia/Kolkata", "OMP_NUM_THREADS": "7"})
        self.assertEqual(contents(self.folder / "a"), contents(self.folder / "b"))
        self.assertEqual(contents(self.folder / "a"), contents(self.folder / "c"))

    def test_resume_keeps_what_is_whole_and_makes_the_rest_again(self):
        self.render("out", *BEND)
        whole = contents(self.folder / "out")
        (frame,) = (self.folder / "out").glob("*.exr")
        frame.write_bytes(frame.read_bytes()[:-100])
        self.render("out", *BEND, "--resume")
        self.assertEqual(contents(self.folder / "out"), whole)
        kept = frame.stat().st_mtime_ns
        self.render("out", *BEND, "--resume")
        self.assertEqual(frame.stat().st_mtime_ns, kept)

    def test_another_pose_is_not_taken_for_the_one_that_is_there(self):
        self.render("out", *BEND, "--name", "x")
        before = contents(self.folder / "out")
        self.render("out", "--name", "x", "--resume", "--pose", "extension=30")
        after = contents(self.folder / "out")
        self.assertEqual(before.keys(), after.keys())
        for name in before:
            self.assertNotEqual(before[name], after[name], name)


class Sequences(CommandTest):
    """A sweep as a sequence: every pose once, seen alike, with what moved in it."""

    SWEEP = ("--sweep", "extension", "--res", "32x24", "--spp", "1", "--name", "x")

    def setUp(self):
        super().setUp()
        self.write("hero.glb", glb.tube())

    def test_a_sweep_is_a_frame_for_every_pose_and_is_resumed_to_the_same_bytes(self):
        told = self.assert_runs("render", "hero.glb", *self.SWEEP, "--aovs", "all", "-o", "out").stdout.splitlines()
        frames = [line for line in told if line.endswith(".exr")]
        self.assertEqual(frames[0], "out/x.1001.exr")
        self.assertEqual(told[len(frames):], ["out/x_sheet.png", "out/x.mp4"])
        probe = told_by("ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames", "-of",
                        "csv=p=0", self.folder / "out/x.mp4")
        self.assertEqual(int(probe), len(frames))
        first, middle = Exr(self.folder / frames[0]), Exr(self.folder / frames[30])
        self.assertEqual(first.text("backbend/poseParameter"), "rest")
        self.assertNotIn("motion.X", first.channels)
        self.assertGreater(max(middle.channels["motion.X"]), 0.0)
        whole = contents(self.folder / "out")
        (self.folder / frames[1]).unlink()
        (self.folder / frames[30]).write_bytes(b"cut off")
        self.assert_runs("render", "hero.glb", *self.SWEEP, "--aovs", "all", "-o", "out", "--resume", "--threads", "1")
        self.assertEqual(contents(self.folder / "out"), whole)

    def test_frames_made_apart_in_any_order_are_those_of_one_run(self):
        self.assert_runs("render", "hero.glb", *self.SWEEP, "--aovs", "all", "-o", "whole")
        whole = contents(self.folder / "whole")
        count = sum(name.endswith(".exr") for name in whole)
        # Backwards, with single frames, in steps, and shares of what is left: each frame comes once.
        told = [self.assert_runs("render", "hero.glb", *self.SWEEP, "--aovs", "all", "-o", "parts", *words).stdout
                for words in (("--frames", f"1011-{1000 + count}", "--shard", "2/2"), ("--frames", "1003-1010"),
                              ("--frames", f"1011-{1000 + count}", "--shard", "1/2", "--threads", "1"),
                              ("--frames", "1002,1001"))]
        made = [line for part in told for line in part.splitlines()]
        self.assertEqual(sorted(made), sorted(f"parts/{name}" for name in whole if name.endswith(".exr")))
        self.assertEqual(sorted(contents(self.folder / "parts")), sorted(name for name in whole if ".exr" in name))
        # Put together: nothing is made again, contact sheet and video come.
        times = {path.name: path.stat().st_mtime_ns for path in (self.folder / "parts").iterdir()}
        self.assert_runs("render", "hero.glb", *self.SWEEP, "--aovs", "all", "-o", "parts", "--resume")
        self.assertEqual(contents(self.folder / "parts"), whole)
        for name, time in times.items():
            self.assertEqual((self.folder / "parts" / name).stat().st_mtime_ns, time, name)

    def test_shares_of_a_turntable_are_the_whole(self):
        turn = ("turntable", "hero.glb", "--views", "5", "--res", "32x24", "--spp", "1", "--name", "x")
        self.assert_runs(*turn, "-o", "whole")
        for share in (3, 1, 2):
            self.assert_runs(*turn, "-o", "parts", "--shard", f"{share}/3")
        self.assert_runs(*turn, "-o", "parts", "--resume")
        self.assertEqual(contents(self.folder / "parts"), contents(self.folder / "whole"))

    def test_frames_that_there_are_not_are_refused(self):
        for words, name in ((("--frames", "1001-9999"), "1001"), (("--frames", "1000"), "1000"),
                            (("--frames", "1005-1002"), "1005-1002"), (("--frames", "1001-1004x0"), "1001-1004x0"),
                            (("--frames", "1001,"), "''"), (("--frames", "99999999999"), "99999999999"),
                            (("--shard", "3/2"), "3/2")):
            self.assert_refused("render", "hero.glb", *self.SWEEP, "-o", "out", *words, code=2, names=[name])
        self.assert_refused("render", "hero.glb", "--frames", "1001", "-o", "out", code=2, names=["--sweep"])
        self.assertFalse((self.folder / "out").exists())

    def test_a_sweep_that_does_not_exist_is_named_with_the_nearest(self):
        self.assert_refused("render", "hero.glb", "--sweep", "extensoin", "-o", "out", code=2, names=["extension"])
        self.assert_refused("render", "hero.glb", "--sweep", "extension", "--extreme", "-o", "out", code=2)

    def test_heat_has_a_layer_and_a_legend_and_a_transparent_frame_has_no_backdrop(self):
        self.assert_runs("render", HUMAN, "--mode", "heat", *BEND, "--res", "160x120", "--spp", "1", "--name", "heat",
                         "-o", "out")
        heat = Exr(self.folder / "out/heat.exr")
        self.assertGreater(max(value for value in heat.channels["heat"] if value == value), 1.0)
        self.assert_runs("render", HUMAN, "--transparent", *SMALL, "--name", "clear", "-o", "out")
        clear = Exr(self.folder / "out/clear.exr")
        self.assertEqual(min(clear.channels["A"]), 0.0)
        self.assertEqual(max(clear.channels["A"]), 1.0)


class Extremes(CommandTest):
    """The worst pose of each sweep, and both sides of each flip, with a sheet of them all."""

    EXTREME = ("--rig", "isner", "--extreme", "--res", "48x36", "--spp", "1", "--name", "x")

    def test_each_flip_is_shown_on_both_sides_and_each_sweep_at_its_worst(self):
        self.write("hero.glb", glb.tube())
        told = self.assert_runs("render", "hero.glb", *self.EXTREME, "-o", "out").stdout.splitlines()
        frames = [pathlib.Path(line).name for line in told if line.endswith(".exr")]
        self.assertEqual(told[-1], "out/x_extremes.png")
        self.assertEqual(len(set(frames)), len(frames))
        flips = {"x_extension_114.3_BB001_before.exr", "x_extension_114.3_BB001_after.exr"}
        self.assertLessEqual(flips, set(frames), frames)
        sweeps = {name.split("_")[1] for name in frames}
        self.assertLessEqual({"extension", "flexion", "side", "twist"}, sweeps, frames)
        # A flip's two sides are two pictures; a frame says which pose it shows.
        before, after = (self.folder / "out" / name for name in sorted(flips, reverse=True))
        self.assertNotEqual(Exr(before).channels["N.X"], Exr(after).channels["N.X"])
        self.assertRegex(Exr(before).text("backbend/poseParameter"), r"^extension 114\.2")

        whole = contents(self.folder / "out")
        before.unlink()
        self.assert_runs("render", "hero.glb", *self.EXTREME, "-o", "out", "--resume", "--threads", "1")
        self.assertEqual(contents(self.folder / "out"), whole)


class Review(CommandTest):
    def test_the_light_turns_after_the_character_and_presets_give_way_to_options(self):
        self.assert_runs("turntable", HUMAN, "--preset", "quick", "--res", "64x48", "--spp", "2", "--views", "2",
                         "--light-views", "2", "--burn-in", "--name", "turn", "-o", "out")
        frames = [Exr(self.folder / f"out/turn.{number}.exr") for number in (1001, 1002, 1003, 1004)]
        self.assertFalse((self.folder / "out/turn.1005.exr").exists())
        self.assertEqual((frames[0].width, frames[0].height), (64, 48))
        self.assertEqual(frames[0].text("backbend/spp"), "2")
        self.assertIn("denoised.R", sorted(frames[0].channels))  # as the preset has it
        # From the front, first with the light where it always is, then from behind.
        self.assertTrue(frames[2].channels == frames[0].channels)
        self.assertTrue(frames[3].channels["Z"] == frames[0].channels["Z"])
        self.assertFalse(frames[3].channels["R"] == frames[0].channels["R"])
        self.assertEqual(told_by("ffprobe", "-v", "error", "-count_frames", "-show_entries", "stream=nb_read_frames",
                                 "-of", "csv=p=0", self.folder / "out/turn.mp4").strip(), "4")

    def test_burnt_in_words_stay_out_of_the_exr(self):
        for name, words in (("clean", ()), ("burnt", ("--burn-in",))):
            self.assert_runs("render", HUMAN, *SMALL, *BEND, *words, "--name", "x", "-o", name)
        clean, burnt = contents(self.folder / "clean"), contents(self.folder / "burnt")
        self.assertEqual(clean["x.exr"], burnt["x.exr"])
        self.assertNotEqual(clean["x.png"], burnt["x.png"])

    def test_an_environment_that_is_none_leaves_nothing_behind(self):
        self.assert_refused("render", HUMAN, *SMALL, "--environment", "absent.hdr", "-o", "out", names=["absent.hdr"])
        self.write("words.hdr", "no picture")
        self.assert_refused("turntable", HUMAN, *SMALL, "--environment", "words.hdr", "-o", "out", names=["words.hdr"])

    def test_many_parts_hold_what_one_does(self):
        for name, words in (("one", ()), ("many", ("--multipart",))):
            self.assert_runs("render", HUMAN, *SMALL, *words, "--name", name, "-o", ".")
        told = told_by("oiiotool", "--info", "-v", "-a", self.folder / "many.exr")
        for part in ("rgba", "Z", "N", "CryptoAsset", "CryptoObject"):
            self.assertIn(f'name: "{part}"', told)
        told_by("oiiotool", self.folder / "many.exr", "--subimage", "rgba", "--ch", "R,G,B,A", self.folder / "one.exr",
                "--ch", "R,G,B,A", "--fail", "0", "--diff")

    def test_the_bench_counts_the_rays_of_a_frame(self):
        told = json.loads(self.assert_runs("bench", "rays", HUMAN, "--res", "32x32", "--spp", "2", "--repeat", "1",
                                           "--json").stdout)
        # At most through every pixel twice, and once through the middle for its surface; in blocks of 4 x 2
        # pixels, and not where the character certainly is not.
        self.assertEqual(told["camera_rays"] % (8 * 3), 0)
        self.assertLess(told["camera_rays"], 32 * 32 * 3)
        self.assertGreater(told["camera_rays"], 32 * 32 * 3 / 20)
        self.assertGreater(told["shadow_rays"], 0)
        self.assertGreater(told["scattered_rays"], 0)
        self.assertAlmostEqual(told["ratio"], told["rays_s"] / told["frame_s"])
        # Each kind is asked in every way, in both trees; the fastest counts.
        for kind in ("camera", "scattered", "shadow"):
            ways = [rate for rate in told["rates"] if rate["kind"] == kind]
            self.assertEqual({way["tree"] for way in ways}, {"medium", "high"})
            self.assertLessEqual({"one by one", "eight wide"}, {way["way"] for way in ways})
            (best,) = [rate for rate in told["best"] if rate["kind"] == kind]
            self.assertEqual(best["rays_per_s"], max(way["rays_per_s"] for way in ways))
        self.assertLessEqual(told["rays_s"], told["rays_as_asked_s"])

    def test_the_bench_shows_the_rate_of_every_way(self):
        told = self.assert_runs("bench", "rays", HUMAN, "--res", "32x32", "--spp", "2", "--repeat", "1").stdout
        self.assertRegex(told, r"(?m)^incoherent high +one by one( +[0-9.]+\*?){3}")
        self.assertEqual(told.count("*"), 3 + 1, "a best way for each kind, and the line that explains the mark")
        self.assertRegex(told, r"(?m)^rays alone, the best ways .* ratio [01]\.[0-9]+$")
