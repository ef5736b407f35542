"""backbend check --baked: the motion of another program's rig, from any form of clip."""

import json
import math
import struct
import sys

from bvh import walker
from exr import Exr
from glb import HUMAN, tube
from harness import CommandTest, SOURCE, character, contents

sys.path.insert(0, str(SOURCE / "scenes/bridges"))
import backbend_clip  # noqa: E402  (the bridges' own writer)

SPACING = 1.6 / len(HUMAN)
SMALL_PICTURES = ("--res", "64x48", "--spp", "1")


def column_matrix(height, twist_deg, bend_deg=0.0):
    """A joint of the tube, turned about its length, then bent forward; column by column."""
    t, b = math.radians(twist_deg), math.radians(bend_deg)
    ct, st, cb, sb = math.cos(t), math.sin(t), math.cos(b), math.sin(b)
    return [ct, sb * st, -cb * st, 0, 0, cb, sb, 0, st, -sb * ct, cb * ct, 0, 0, height, 0, 1]


def twisting_clip(path, twist_at, frames=40, points=None, sweep="twist", control_at=None, controls=True):
    """Joint `spine` twists by twist_at(frame), everything above goes along; so does the control, unless it is told apart or there is none."""
    joints = [(name, k - 1, column_matrix(SPACING * k, 0)) for k, name in enumerate(HUMAN)]
    writer = backbend_clip.ClipWriter(joints, points=len(points(0)) // 3 if points else 0, program="test",
                                      spine=HUMAN[:4])
    for frame in range(frames):
        matrices = [column_matrix(SPACING * k, twist_at(frame) if k >= 1 else 0) for k in range(len(HUMAN))]
        writer.add(matrices, points(frame) if points else None, sweep=sweep(frame) if callable(sweep) else sweep,
                   controls={"twist": (control_at or twist_at)(frame)} if controls else {})
    writer.save(str(path))
    return path


def steady(frame):
    return 2.0 * frame


def flipping(frame):
    """What a twist read back from a matrix does on its way through 180 degrees."""
    return 2.0 * frame + 140.0 if frame < 20 else 2.0 * frame + 140.0 - 180.0


def report_of(folder):
    return json.loads((folder / "report.json").read_text())


def codes(report):
    return [finding["code"] for finding in report["findings"] if finding["verdict"] == "fail"]


class JudgingAClip(CommandTest):
    def body(self):
        return self.write("tube.glb", tube())

    def test_steady_motion_has_no_finding_of_a_flip(self):
        clip = twisting_clip(self.folder / "steady.clip", steady)
        result = self.backbend("check", self.body(), "--baked", clip, *SMALL_PICTURES, "-o", "out")
        report = report_of(self.folder / "out")
        self.assertEqual(result.returncode, report["exit_code"], result.stderr)
        self.assertNotIn("BB001", codes(report))
        self.assertIn("Judging YOUR RIG", result.stdout.splitlines()[0])

    def test_a_jump_in_a_sweep_whose_name_came_before_is_found_in_its_own_sweep(self):
        # Two short sweeps, then one that is called as the first and jumps behind the first's end.
        clip = twisting_clip(self.folder / "again.clip", lambda f: f if f < 20 else flipping(f - 20), frames=60,
                             sweep=lambda f: "rest" if 10 <= f < 20 else "twist")
        self.assert_runs("check", self.body(), "--baked", clip, *SMALL_PICTURES, "-o", "out", code=1)
        found = [f for f in report_of(self.folder / "out")["findings"] if f["code"] == "BB001"]
        self.assertEqual([(f["sweep"], f["pose_index"], f["frame"]) for f in found], [("twist", 20, 40)])

    def test_a_jump_is_found_at_its_frame_joint_and_control_value(self):
        clip = twisting_clip(self.folder / "flip.clip", flipping)
        self.assert_runs("check", self.body(), "--baked", clip, *SMALL_PICTURES, "-o", "out", code=1)
        found = [f for f in report_of(self.folder / "out")["findings"] if f["code"] == "BB001"]
        self.assertEqual(len(found), 1, found)
        self.assertEqual(found[0]["place"], {"joint": "spine"})
        self.assertEqual((found[0]["frame"], found[0]["time"]), (20, 20 / 24))
        self.assertEqual(found[0]["owner"], "RIG")  # the clip says what its controls did
        self.assertAlmostEqual(found[0]["control_deg"], 0.0)
        # 178 degrees back where the motion around says 2 on.
        self.assertAlmostEqual(found[0]["value"], 180.0, delta=0.01)
        self.assertIn("--baked", found[0]["reproduce"])

    def test_a_joint_that_twists_the_skin_to_a_string_fails_though_nothing_jumps(self):
        for most, fails in ((70.0, False), (170.0, True)):
            clip = twisting_clip(self.folder / f"{most}.clip", lambda f: most * f / 99, frames=100, controls=False)
            self.backbend("check", self.body(), "--baked", clip, "-o", "out", "--quick")
            report = report_of(self.folder / "out")
            self.assertEqual(codes(report), ["BB030"] if fails else [], most)
        owners = [f["owner"] for f in report["findings"] if f["code"] == "BB030"]
        self.assertEqual(owners, ["MOTION"])

    def test_a_skeleton_alone_is_judged_by_its_chain(self):
        clip = twisting_clip(self.folder / "flip.clip", flipping)
        result = self.assert_runs("check", "--baked", clip, "-o", "out", code=1)
        self.assertIn("chain only", result.stdout)
        self.assertIn("BB001", codes(report_of(self.folder / "out")))

    def test_the_sums_of_every_check_match_and_the_canary_sings(self):
        clip = twisting_clip(self.folder / "steady.clip", steady)
        self.backbend("check", self.body(), "--baked", clip, *SMALL_PICTURES, "-o", "out")
        report = report_of(self.folder / "out")
        for row in report["rigs"][0]["coverage"]:
            self.assertEqual(row["planned"], row["measured"] + row["not_measured"] + row["not_applicable"], row)
        self.assertTrue(report["canaries"][0]["ok"], report["canaries"])
        self.assertIn("jumps from", report["detectors"][0])

    def test_joints_of_another_name_are_mapped_by_the_user(self):
        clip = twisting_clip(self.folder / "flip.clip", flipping)
        names = ["pelvis", "abdomen", "thorax", "cervical", "skull"]
        body = self.write("other.glb", tube(names))
        pairs = ",".join(f"{ours}={theirs}" for ours, theirs in zip(names, HUMAN))
        self.assert_runs("check", body, "--baked", clip, "--spine", ",".join(names), "--joint-map", pairs,
                         *SMALL_PICTURES, "-o", "out", code=1)
        self.assertIn("BB001", codes(report_of(self.folder / "out")))

    def test_a_character_in_another_unit_has_the_same_findings(self):
        clip = self.folder / "pop.clip"
        joints = [(name, k - 1, column_matrix(SPACING * k, 0)) for k, name in enumerate(HUMAN)]
        writer = backbend_clip.ClipWriter(joints, program="test", spine=HUMAN[:4])
        for frame in range(40):  # the spine stretches: turns alone would not show it
            stretch = 1.0 + 0.01 * frame
            writer.add([column_matrix(SPACING * k * stretch, steady(frame) if k else 0) for k in range(len(HUMAN))],
                       None, sweep="twist", controls={"twist": steady(frame)})
        writer.save(str(clip))
        found = {}
        for name, unit in (("metres", 1.0), ("centimetres", 100.0)):
            self.write(name + ".glb", tube(unit=unit))
            result = self.backbend("check", name + ".glb", "--baked", clip, *SMALL_PICTURES, "-o", name)
            self.assertEqual("another unit" in result.stdout, unit != 1.0, result.stdout + result.stderr)
            found[name] = [(f["code"], f["frame"], f["verdict"], f["place"]) for f in report_of(self.folder / name)["findings"]]
        self.assertEqual(found["metres"], found["centimetres"])
        self.assertIn("BB047", [code for code, *_ in found["metres"]])  # length change

    def test_the_smallest_jump_is_said_of_each_sweep_of_controls(self):
        clip = twisting_clip(self.folder / "small.clip", lambda f: 2.0 * f + (6.0 if f >= 20 else 0.0), control_at=steady)
        self.assert_runs("check", self.body(), "--baked", clip, "--quick", "-o", "out", code=1)
        report = report_of(self.folder / "out")
        (found,) = [f for f in report["findings"] if f["code"] == "BB001"]
        self.assertAlmostEqual(found["value"], 6.0, delta=0.01)  # 7 are asked for where only time is known
        self.assertTrue([line for line in report["detectors"] if line.startswith("flips by sweep:") and "twist 5" in line],
                        report["detectors"])

    def test_a_control_that_whips_a_joint_has_too_much_gain(self):
        clip = twisting_clip(self.folder / "fast.clip", lambda f: 20.0 * f, frames=12, control_at=steady)
        self.backbend("check", self.body(), "--baked", clip, "--quick", "-o", "out")
        (found,) = [f for f in report_of(self.folder / "out")["findings"] if f["code"] == "BB002"]
        self.assertAlmostEqual(found["value"], 10.0, delta=0.01)

    def test_gain_is_found_beside_a_jump_elsewhere_and_the_jump_is_not_counted_as_gain(self):
        def fast_then_flipped(f):
            return 20.0 * min(f, 12) + 2.0 * max(f - 12, 0) + (60.0 if f >= 32 else 0.0)
        for name, angle, codes in (("both", fast_then_flipped, ["BB001", "BB002"]),
                                   ("jump", lambda f: 2.0 * f + (60.0 if f >= 32 else 0.0), ["BB001"])):
            clip = twisting_clip(self.folder / f"{name}.clip", angle, frames=44, control_at=steady)
            self.backbend("check", self.body(), "--baked", clip, "--quick", "-o", name)
            found = [f for f in report_of(self.folder / name)["findings"] if f["code"] in ("BB001", "BB002")]
            self.assertEqual(sorted(f["code"] for f in found), codes, found)
            for finding in found:
                self.assertAlmostEqual(finding["value"], 60.0 if finding["code"] == "BB001" else 10.0, delta=0.1)

    def test_pictures_say_whether_a_jump_is_seen(self):
        clip = twisting_clip(self.folder / "flip.clip", flipping)
        self.assert_runs("check", self.body(), "--baked", clip, "--res", "160x120", "--spp", "4", "-o", "out", code=1)
        (found,) = [f for f in report_of(self.folder / "out")["findings"] if f["code"] == "BB001"]
        self.assertTrue(found["image"]["measured"], found["image"])
        self.assertEqual(found["image"]["metric"], "pop_score")

    def test_fewer_frames_than_tell_a_jump_are_not_called_clean(self):
        clip = twisting_clip(self.folder / "short.clip", steady, frames=4)
        self.assert_runs("check", self.body(), "--baked", clip, *SMALL_PICTURES, "-o", "out", code=5)

    def test_bad_clips_are_refused_in_one_line_and_nothing_is_written(self):
        body = self.body()
        clip = twisting_clip(self.folder / "a.clip", steady)
        cut = self.write("cut.clip", clip.read_bytes()[:-1])
        self.assert_refused("check", body, "--baked", cut, names=["cut.clip", "bytes of numbers"])
        self.assert_refused("check", body, "--baked", body, names=["tube.glb", "/animations"])
        self.assert_refused("check", body, "--baked", self.folder / "none.clip", names=["none.clip"])
        self.assert_refused("check", body, "--baked", clip, "--clip", "walk", names=["no sweep 'walk'", "'twist'"])
        self.assert_refused("check", body, "--baked", clip, "--joint-map", "hips=nobody",
                            names=["no joint 'nobody'"])
        self.assert_refused("check", body, "--baked", clip, "--joint-map", "hips", code=2, names=["'hips'"])
        self.assert_refused("check", code=2, names=["--baked"])


class PicturesOfAClip(CommandTest):
    SMALL = ("--res", "96x72", "--spp", "1")

    def setUp(self):
        super().setUp()
        self.body = self.write("tube.glb", tube())
        self.clip = twisting_clip(self.folder / "twist.clip", steady)

    def test_frames_have_the_files_own_numbers(self):
        told = self.assert_runs("render", self.body, "--baked", self.clip, "--frames", "10-12,30", *self.SMALL, "-o", "out")
        names = [f"out/tube_twist.{frame:04d}.exr" for frame in (10, 11, 12, 30)]
        self.assertEqual(told.stdout.splitlines(), names)
        frame = Exr(self.folder / names[0])
        self.assertEqual(frame.attributes["backbend/poseParameter"].decode(), "twist 20, frame 10 (0.417 s)")
        self.assertEqual(frame.attributes["backbend/clip"].decode(), "twist.clip")

    def test_a_body_and_a_clip_of_one_name_are_named_once(self):
        clip = twisting_clip(self.folder / "tube.clip", steady, frames=6)
        told = self.assert_runs("render", self.body, "--baked", clip, "--frames", "3", *self.SMALL, "-o", "out")
        self.assertEqual(told.stdout.splitlines(), ["out/tube.0003.exr"])

    def test_all_frames_make_a_sheet_and_a_film_and_are_kept_by_resume(self):
        clip = twisting_clip(self.folder / "short.clip", steady, frames=6)
        words = ("render", self.body, "--baked", clip, *self.SMALL, "-o", "out")
        self.assert_runs(*words, "--frames", "0-3")
        kept = contents(self.folder / "out")
        told = self.assert_runs(*words, "--resume")
        self.assertEqual(told.stdout.splitlines()[-2:], ["out/tube_short_sheet.png", "out/tube_short.mp4"])
        now = contents(self.folder / "out")
        self.assertEqual({name: now[name] for name in kept}, kept)
        self.assertEqual(len(now), 8)

    def test_a_still_is_the_frame_and_the_clips_points_are_shown(self):
        wide = twisting_clip(self.folder / "wide.clip", steady, points=lambda f: blended(steady(f), 1.5))
        pixels = {}
        for clip in (self.clip, wide):
            self.assert_runs("render", self.body, "--baked", clip, "--frame", "20", *self.SMALL, "--name", clip.stem,
                             "--export-obj", self.folder / f"{clip.stem}.obj", "-o", "out")
            self.assertTrue((self.folder / f"out/{clip.stem}.exr").is_file())
            rows = [line.split() for line in (self.folder / f"{clip.stem}.obj").read_text().splitlines() if line.startswith("v ")]
            pixels[clip.stem] = max(abs(float(row[1])) for row in rows)
        self.assertAlmostEqual(pixels["wide"], 1.5 * pixels["twist"], delta=0.02 * pixels["twist"])

    def test_a_turntable_goes_around_the_frame(self):
        told = self.assert_runs("turntable", self.body, "--baked", self.clip, "--frame", "20", "--views", "3", *self.SMALL,
                                "-o", "out")
        self.assertEqual(len(told.stdout.splitlines()), 5)
        frame = Exr(self.folder / "out/tube_twist.1001.exr")
        self.assertIn("frame 20", frame.attributes["backbend/poseParameter"].decode())

    def test_what_cannot_be_shown_is_refused(self):
        clip = ("--baked", self.clip, *self.SMALL, "-o", "out")
        for words, names in ((("--frame", "40"), ["40", "0 to 39"]), (("--frames", "38-44"), ["38-44", "0 to 39"]),
                             (("--pose", "twist=3"), ["--pose"]), (("--frame", "3", "--frames", "3"), ["--frame"])):
            with self.subTest(words):
                self.assert_refused("render", self.body, *clip, *words, code=2, names=names)
        self.assert_refused("render", *clip, names=["no body"])
        self.assert_refused("render", "-o", "out", code=2, names=["--baked"])


def tube_positions():
    """The tube's vertices as it is at rest, and the joints and weights of each."""
    rows = []
    tube(vertex=lambda i, position, joints, weights: rows.append((position, joints, weights)))
    return rows


def blended(twist_deg, widen=1.0):
    """Linear blending of the tube under a twist of all joints but the hips."""
    t = math.radians(twist_deg)
    out = []
    for (x, y, z), joints, weights in tube_positions():
        turned = sum(w for j, w in zip(joints, weights) if j >= 1)
        px = (1 - turned) * x + turned * (math.cos(t) * x + math.sin(t) * z)
        pz = (1 - turned) * z + turned * (-math.sin(t) * x + math.cos(t) * z)
        out += [widen * px, y, widen * pz]
    return out


class JudgingPoints(CommandTest):
    """Caches of points: bodies as a rig's own deformers make them."""

    def body(self):
        return self.write("tube.glb", tube())

    def caches(self, twist_at, frames=40):
        count = len(tube_positions())
        data = [blended(twist_at(f)) for f in range(frames)]
        mdd = struct.pack(">ii", frames, count) + struct.pack(f">{frames}f", *(f / 24 for f in range(frames)))
        mdd += b"".join(struct.pack(f">{3 * count}f", *row) for row in data)
        pc2 = struct.pack("<12siiffi", b"POINTCACHE2\0", 1, count, 0.0, 1.0, frames)
        pc2 += b"".join(struct.pack(f"<{3 * count}f", *row) for row in data)
        return [self.write("cache.mdd", mdd), self.write("cache.pc2", pc2)]

    def test_a_flip_is_seen_in_the_points_alone(self):
        for cache in self.caches(flipping):
            with self.subTest(cache.name):
                self.assert_runs("check", self.body(), "--baked", cache, *SMALL_PICTURES, "-o", cache.name + ".out", code=1)
                found = [f for f in report_of(self.folder / (cache.name + ".out"))["findings"] if f["code"] == "BB001"]
                self.assertEqual([f["frame"] for f in found], [20])

    def test_steady_points_hold_no_flip(self):
        for cache in self.caches(steady):
            with self.subTest(cache.name):
                self.backbend("check", self.body(), "--baked", cache, *SMALL_PICTURES, "-o", cache.name + ".out")
                self.assertNotIn("BB001", codes(report_of(self.folder / (cache.name + ".out"))))

    def test_points_without_a_body_are_refused(self):
        self.assert_refused("check", "--baked", self.caches(steady)[0], names=["need the mesh"])

    def test_points_of_another_mesh_are_refused(self):
        body = self.write("finer.glb", tube(rings=12))
        self.assert_refused("check", body, "--baked", self.caches(steady)[0], names=["are not the 96 vertices"])

    def test_blending_is_trusted_where_it_gives_the_points(self):
        body = self.body()
        for widen, word in ((1.0, "trusted"), (1.2, "not about your rig")):
            with self.subTest(word):
                clip = twisting_clip(self.folder / "both.clip", steady,
                                     points=lambda f, widen=widen: blended(steady(f), widen))
                result = self.backbend("check", body, "--baked", clip, *SMALL_PICTURES, "-o", f"out{widen}")
                line = [line for line in result.stdout.splitlines() if "LBS against your deformers" in line]
                self.assertEqual(len(line), 1, result.stdout + result.stderr)
                self.assertIn(word, line[0])


class JudgingASkeletonsMotion(CommandTest):
    """BVH holds no body: it moves the character beside it, or is judged by its chain."""

    def swaying(self):
        """The walker's spine leans to and fro; at frame 12 its chest jumps by half a turn."""
        rows = [{7: round(10 * math.sin(f / 6), 4), 11: 180 if f >= 12 else 0} for f in range(24)]
        return self.write("walk.bvh", walker(rows))

    def assert_the_jump_was_found(self):
        found = [f for f in report_of(self.folder / "out")["findings"] if f["code"] == "BB001"]
        self.assertEqual([(f["frame"], f["place"]) for f in found], [(12, {"joint": "chest"})])
        self.assertAlmostEqual(found[0]["time"], 12 * 0.04, places=5)
        self.assertEqual(found[0]["owner"], "MOTION")

    def test_its_chain_is_judged_without_a_body(self):
        result = self.assert_runs("check", "--baked", self.swaying(), "-o", "out", code=1)
        self.assertIn("chain only", result.stdout)
        self.assert_the_jump_was_found()

    def test_it_is_judged_on_the_character_beside_it(self):
        clip = self.swaying()
        self.assert_runs("body", "walk.bvh", "-o", "walker.glb", "--vertices", "3000")
        self.assert_runs("check", "walker.glb", "--baked", clip, *SMALL_PICTURES, "-o", "out", code=1)
        self.assert_the_jump_was_found()
        self.assertIn("slice_area", report_of(self.folder / "out")["rigs"][0]["summary"])


# Name, parent, place: a spine of four bones that is somebody.
FIGURE = ([("hips", -1, (0, 1.0, 0))] + [(f"spine_0{k}", k - 1, (0, 1.0 + 0.12 * k, 0)) for k in range(1, 5)] +
          [("neck", 4, (0, 1.6, 0)), ("head", 5, (0, 1.7, 0.01))])
for _side, _x in (("Left", 1), ("Right", -1)):
    for _names, _root, _places in (
            (("Shoulder", "Arm", "ForeArm", "Hand"), 4, ((0.04, 1.56), (0.18, 1.56), (0.45, 1.56), (0.7, 1.56))),
            (("UpLeg", "Leg", "Foot"), 0, ((0.1, 0.95), (0.1, 0.5), (0.1, 0.05)))):
        for _k, (_name, (_across, _up)) in enumerate(zip(_names, _places)):
            FIGURE.append((_side + _name, _root if _k == 0 else len(FIGURE) - 1,
                           (_x * _across, _up, 0.05 if _name == "Foot" else 0)))


def leaning_clip(path, clavicle_deg=0.0, arm_control=False, timed=True):
    """The spine bends back to 60 degrees by one control; the clavicles turn against it, to `clavicle_deg`."""
    place = {name: at for name, _, at in FIGURE}
    joints = [(name, parent, [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, *at, 1]) for name, parent, at in FIGURE]
    writer = backbend_clip.ClipWriter(joints, program="test")
    for frame in range(31):
        turned, at, matrices = {}, {}, []
        for name, parent, rest in FIGURE:
            above = FIGURE[parent][0] if parent >= 0 else None
            own = -2.0 * frame / 4 if name.startswith("spine") else 0.0
            own += clavicle_deg * frame / 30 if name.endswith("Shoulder") else 0.0
            turned[name] = own + (turned[above] if above else 0.0)
            if above:
                a = math.radians(turned[above])
                dx, dy, dz = (r - b for r, b in zip(rest, place[above]))
                at[name] = [p + d for p, d in zip(at[above], (dx, math.cos(a) * dy - math.sin(a) * dz,
                                                             math.sin(a) * dy + math.cos(a) * dz))]
            else:
                at[name] = list(rest)
            a = math.radians(turned[name])
            matrices.append([1, 0, 0, 0, 0, math.cos(a), math.sin(a), 0, 0, -math.sin(a), math.cos(a), 0,
                             *at[name], 1])
        controls = {"chest.rx": -2.0 * frame}
        if arm_control:
            controls["clavicles.rx"] = clavicle_deg * frame / 30
        writer.add(matrices, None, sweep="extension", controls=controls)
        if not timed:
            del writer.header["poses"][-1]["time"]
    writer.save(str(path))
    return path


class ClaviclesOfALivingRig(CommandTest):
    def judged(self, code, **clip):
        self.assert_runs("check", "--baked", leaning_clip(self.folder / "lean.clip", **clip), "-o", "out", code=code)
        return report_of(self.folder / "out")

    def test_their_drift_is_found_by_its_size_while_only_the_chest_control_moves(self):
        for size in (1.8, 5, 30):
            with self.subTest(size):
                (found,) = [f for f in self.judged(1, clavicle_deg=size)["findings"] if f["verdict"] == "fail"]
                self.assertEqual((found["code"], found["owner"], found["frame"]), ("BB020", "RIG", 30))
                self.assertAlmostEqual(found["value"], size, delta=0.01 * size)
                self.assertIn("Shoulder", found["place"]["joint"])

    def test_what_a_control_of_the_arms_turned_is_no_drift(self):
        report = self.judged(0, clavicle_deg=30, arm_control=True)
        (row,) = [row for row in report["rigs"][0]["coverage"] if row["code"] == "BB020"]
        self.assertEqual(row["not_applicable"], row["planned"])
        self.assertTrue(any("clavicles.rx" in note for note in report["characters"][0]["notes"]), report["characters"])

    def test_a_clean_rig_passes_and_is_ahead_of_one_that_drifts(self):
        self.judged(0)
        good, bad = (leaning_clip(self.folder / name, size) for name, size in (("good.clip", 0), ("bad.clip", 5)))
        self.assert_runs("compare", bad, good, "--quiet", "-o", "mended")  # the later one is judged
        result = self.assert_runs("compare", good, bad, "--json", "-o", "broken", code=1)
        (one,) = json.loads(result.stdout)["comparisons"]
        self.assertEqual(one["ahead"], "b", one)
        self.assertEqual(one["worst_of_a"][0]["code"], "BB020")

    def test_poses_without_time_have_no_frame_and_no_second(self):
        (found,) = [f for f in self.judged(1, clavicle_deg=5, timed=False)["findings"] if f["verdict"] == "fail"]
        self.assertEqual((found["frame"], found["time"], found["pose_index"]), (None, None, 30))


class JudgingRealMotion(CommandTest):
    PICTURES = ("--res", "160x120", "--spp", "1")

    def test_captures_as_bvh_hold_no_flip_on_a_body_of_other_names_and_stance(self):
        body = character("mh_female_cmu_13k.glb")
        for name, frames, renamed in (("cmu_49_08_acrobatics.bvh", 576, False),
                                      ("cmu_131_01_mj_style.bvh", 994, True)):
            with self.subTest(name):
                clip = character("motion/" + name)
                result = self.backbend("check", body, "--baked", clip, *self.PICTURES, "-o", name)
                report = report_of(self.folder / name)
                self.assertEqual(result.returncode, 0, result.stdout + result.stderr)
                # What turns over where the legs join is there under an even bend too: not the spine's.
                self.assertEqual({f["verdict"] for f in report["findings"]} - {"stress"}, set())
                self.assertNotIn("SOLVER", [f["owner"] for f in report["findings"]])
                self.assertEqual(len(report["rigs"][0]["sweeps"][0]["control_deg"]), frames)
                self.assertEqual("matched by position" in " ".join(result.stdout.split()), renamed, result.stdout)

    def test_captured_acrobatics_hold_no_flip(self):
        clip = character("mh_female_cmu_49_08_baked.glb")
        result = self.backbend("check", "--baked", clip, *self.PICTURES, "-o", "out")
        report = report_of(self.folder / "out")
        self.assertEqual(result.returncode, report["exit_code"], result.stderr)
        self.assertEqual(result.returncode, 0, result.stdout)
        poses = sum(len(sweep["control_deg"]) for sweep in report["rigs"][0]["sweeps"])
        self.assertEqual(poses, 144)

    def test_the_same_bytes_for_any_thread_count(self):
        clip = character("mh_female_cmu_49_08_baked.glb")
        reports = []
        for threads in ("1", "3"):
            self.backbend("check", "--baked", clip, *self.PICTURES, "-o", threads, "--threads", threads)
            reports.append((self.folder / threads / "report.json").read_bytes())
        self.assertEqual(*reports)
