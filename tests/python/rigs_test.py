"""Rigs and characters as arrays: the numbers of the command line, views that live as long as they are needed."""

import json
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))

from module import SOURCE, ModuleTest, run_backbend  # noqa: E402

CASES = SOURCE / "tests/accept/solver_cases.json"


class SolvingLikeTheCommand(ModuleTest):
    def test_every_accepted_case_gives_the_numbers_of_the_command(self):
        (self.folder / "mSaurus_neck.json").write_bytes((SOURCE / "tests/accept/mSaurus_neck.json").read_bytes())
        cases = [case["toml"] for case in json.loads(CASES.read_text())["cases"]]
        told = []
        for number, toml in enumerate(cases):
            (self.folder / f"{number}.toml").write_text(toml)
            result = run_backbend(["solve", f"{number}.toml", "--json"], self.folder)
            self.assertEqual(result.returncode, 0, result.stderr)
            told.append(json.loads(result.stdout))
        (self.folder / "told.json").write_text(json.dumps(told))
        systems = self.run_script("""
import json
systems = set()
for number, told in enumerate(json.load(open("told.json"))):
    rig, controls = backbend.Rig.from_file(f"{number}.toml")
    poses = rig.solve(np.tile(controls, (3, 1)), measures=True)
    positions = np.array([joint["position"] for joint in told["joints"]])
    turns = np.array([joint["turn"] for joint in told["joints"]])
    for pose in range(3):
        assert np.abs(poses.positions[pose] - positions).max() < 1e-12, number
        same = np.minimum(np.abs(poses.turns[pose] - turns).max(1), np.abs(poses.turns[pose] + turns).max(1))
        assert same.max() < 1e-12, number
    for name, value in told["measures"].items():
        if value is not None and name in poses.measures:
            assert abs(poses.measures[name][1] - value) <= 1e-9 * max(1.0, abs(value)), (number, name)
    assert rig.joints == [joint["name"] for joint in told["joints"]]
    systems.add(rig.system)
print(*sorted(systems))
""").split()
        self.assertLessEqual({"curve", "isner", "stretchy", "neck", "snake", "three_bone"}, set(systems))

    def test_every_system_stands_on_a_character_and_poses_it(self):
        listed = [row["name"] for row in json.loads(run_backbend(["list", "rigs", "--json"], self.folder).stdout)]
        self.run_script("""
body = backbend.load(HUMAN)
for name in sys.argv[1:]:
    rig = backbend.Rig(name, body)
    poses = body.pose(rig, np.tile(rig.rest_controls, (2, 1)))
    assert poses.positions.shape == (2, len(body.positions), 3) and poses.positions.dtype == np.float32
    # Controls at rest leave the character as it stood.
    assert np.abs(poses.positions - body.positions).max() < 1e-5, name
    assert np.abs(poses.matrices - body.rest_matrices).max() < 1e-9, name
""", *listed)

    def test_a_pose_of_the_body_bends_it_where_its_channels_say(self):
        self.run_script("""
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
head = body.joints.index(body.anatomy.spine_to_head[-1])
forward, left = np.array(body.anatomy.forward), np.array(body.anatomy.left)
def moved(**pose):
    at = body.pose(rig, rig.controls(**pose)).matrices[0, head, :3, 3]
    return at - body.rest_matrices[head, :3, 3]
assert moved(extension=60) @ forward < -0.1 and moved(flexion=60) @ forward > 0.1
assert moved(side=40) @ left > 0.1 and moved(side=-40) @ left < -0.1
""")

    def test_skinning_by_matrices_is_what_posing_gives(self):
        self.run_script("""
body = backbend.load(HUMAN)
rig = backbend.Rig("isner", body)
controls = np.stack([rig.controls(extension=angle) for angle in (0, 30, 90)])
posed = body.pose(rig, controls)
skinned = body.skin(posed.matrices)
assert (skinned.positions == posed.positions).all() and (skinned.normals == posed.normals).all()
out = (np.empty_like(posed.positions), np.empty_like(posed.normals))
again = body.pose(rig, controls, out=out)
assert again.positions is out[0] and (out[0] == posed.positions).all()
one = body.skin(posed.matrices[1])
assert (one.positions[0] == posed.positions[1]).all()
# Memory is used again only where nothing shows it any more.
kept = [body.skin(matrices).positions[0, ::3] for matrices in posed.matrices]
assert all((each == positions[::3]).all() for each, positions in zip(kept, posed.positions))
del kept[1]
again = body.skin(posed.matrices[2])
assert (kept[0] == posed.positions[0, ::3]).all() and (again.positions[0] == posed.positions[2]).all()
# By the formula: the weights' mean of the joints' matrices.
at_rest = np.concatenate([body.positions, np.ones((len(body.positions), 1))], 1)
moves = posed.matrices[2] @ np.linalg.inv(body.rest_matrices)
blended = np.einsum("vk,vkij->vij", body.weights, moves[body.weight_joints])
by_hand = np.einsum("vij,vj->vi", blended, at_rest)[:, :3]
assert np.abs(by_hand - posed.positions[2]).max() < 1e-5
""")

    def test_many_poses_are_the_same_as_each_alone(self):
        self.run_script("""
rig = backbend.Rig("even", np.array([[0, y, 0.02 * y * y] for y in range(6)], float), bones=7)
assert rig.options["bones"] == 7 and len(rig.joints) == 8
controls = np.random.default_rng(1).uniform(-90, 90, (9000, len(rig.channels)))
all_of_them = rig.solve(controls)
for pose in (0, 4095, 4096, 8999):
    alone = rig.solve(controls[pose])
    assert (alone.positions[0] == all_of_them.positions[pose]).all()
    assert (alone.turns[0] == all_of_them.turns[pose]).all()
""")


class LivingArrays(ModuleTest):
    def test_views_keep_their_character_alive_and_are_read_only(self):
        self.run_script("""
import gc
body = backbend.load(HUMAN)
views = [body.positions, body.normals, body.triangles, body.weights, body.rest_matrices, body.chain, body.uv]
sums = [float(view.astype(float).sum()) for view in views]
posed = body.pose(backbend.Rig("even", body), [backbend.Rig("even", body).rest_controls])
rig = backbend.Rig("even", views[5])
joints = rig.rest_positions
del body, rig
gc.collect()
ballast = [np.full(1 << 18, np.nan) for _ in range(64)]
assert sums == [float(view.astype(float).sum()) for view in views]
assert np.isfinite(joints).all() and np.isfinite(posed.positions).all()
for view in views:
    try:
        view[0] = 0
        raise SystemExit("a view of a character was written")
    except ValueError:
        pass
assert not views[0].flags.owndata and posed.positions.flags.writeable
""")

    def test_a_rig_outlives_the_name_of_its_character(self):
        self.run_script("""
import gc
rig = backbend.Rig("curve", backbend.load(HUMAN))
gc.collect()
assert np.isfinite(rig.solve(rig.controls(extension=40)).positions).all()
""")


class RefusingArrays(ModuleTest):
    def test_what_cannot_be_used_is_an_exception_that_says_what_was_expected(self):
        self.run_script("""
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
channels, joints = len(rig.channels), len(body.joints)
good = np.zeros((4, channels))
def refused(kind, words, call):
    try:
        call()
    except kind as error:
        assert all(word in str(error) for word in words), error
        return
    raise SystemExit(f"taken: {words}")
wrong = good.copy(); wrong[2, 1] = np.nan
refused(ValueError, ["controls[2, 1]", "finite"], lambda: rig.solve(wrong))
wrong[2, 1] = -np.inf
refused(ValueError, ["controls[2, 1]"], lambda: body.pose(rig, wrong))
refused(ValueError, [f"N x {channels} channels", "3 x 4 x 5"], lambda: rig.solve(np.zeros((3, 4, 5))))
refused(ValueError, [f"N x {channels} channels"], lambda: rig.solve(np.zeros((4, channels + 1))))
refused(ValueError, ["a single number"], lambda: rig.solve(1.0))
refused(TypeError, ["complex128"], lambda: rig.solve(good.astype(complex)))
for nothing in ("text", None, object(), [["a"] * channels], [[1.0], [1.0, 2.0]], good.astype(object)):
    refused((TypeError, ValueError), ["controls"], lambda: rig.solve(nothing))
refused(ValueError, [f"N x {joints} x 4 x 4"], lambda: body.skin(np.zeros((joints, 3, 4))))
refused(ValueError, ["finite"], lambda: body.skin(np.full((joints, 4, 4), np.nan)))
refused(TypeError, ["float32"], lambda: body.pose(rig, good, out=(np.zeros((4, 5, 3)), None)))
vertices = len(body.positions)
frozen = np.zeros((4, vertices, 3), np.float32); frozen.flags.writeable = False
refused(ValueError, ["read-only"], lambda: body.pose(rig, good, out=(frozen, None)))
same = np.zeros((4, vertices, 3), np.float32)
refused(ValueError, ["share memory"], lambda: body.pose(rig, good, out=(same, same)))
both = np.zeros((5, vertices, 3), np.float32)
refused(ValueError, ["share memory"], lambda: body.pose(rig, good, out=(both[:4], both[1:])))
raw = np.zeros(same.nbytes + 1, np.uint8)
refused(ValueError, ["aligned"], lambda: body.pose(rig, good, out=(raw[1:].view(np.float32).reshape(same.shape), None)))
refused(TypeError, ["float32"], lambda: body.pose(rig, good, out=(same.astype(">f4"), None)))
refused(TypeError, ["positions, normals"], lambda: body.pose(rig, good, out=same))
refused(ValueError, ["expected 4 x"], lambda: body.pose(rig, good, out=(same[:2], None)))
refused(TypeError, ["C order"], lambda: body.pose(rig, good, out=(same[:, ::-1], None)))
refused(ValueError, ["heat"], lambda: body.render(rig, heat=[1.0, 2.0]))
refused(ValueError, ["width"], lambda: body.render(rig, width=3))
refused(ValueError, ["'clya'", "clay"], lambda: body.render(rig, mode="clya"))
refused(backbend.InputError, ["no channel 'extnsion'", "extension"], lambda: rig.controls(extnsion=3))
refused(backbend.InputError, ["finite"], lambda: rig.controls(extension=float("nan")))
refused(TypeError, ["extension"], lambda: rig.controls(extension="much"))
refused(ValueError, ["chest or spread"], lambda: rig.controls(mapping="both"))
refused(backbend.InputError, ["even"], lambda: backbend.Rig("evn", body))
refused(backbend.InputError, ["bones"], lambda: backbend.Rig("even", body, bonse=3))
refused(TypeError, ["option 'bones'"], lambda: backbend.Rig("even", body, bones=object()))
refused(ValueError, ["option 'bones'", "too large"], lambda: backbend.Rig("even", body, bones=10**400))
for number in (float("nan"), float("inf"), -3, 10**15):
    refused(backbend.InputError, ["bones"], lambda: backbend.Rig("even", body, bones=number))
half = chr(0xD800)
refused(ValueError, ["rig", "surrogate"], lambda: backbend.Rig(half, body))
refused(ValueError, ["channel", "surrogate"], lambda: rig.controls(**{half: 3}))
refused(ValueError, ["option", "surrogate"], lambda: backbend.Rig("even", body, **{half: 3}))
refused((ValueError, TypeError), [], lambda: backbend.load(half + ".glb"))
refused((ValueError, TypeError), [], lambda: backbend.load("a" + chr(0) + "b.glb"))
refused((ValueError, TypeError), [], lambda: backbend.judge(half + ".glb"))
refused((ValueError, TypeError), [], lambda: backbend.judge("a" + chr(0) + "b.glb"))
refused(ValueError, ["N x 3"], lambda: backbend.Rig("even", np.zeros((3, 2))))
refused(backbend.InputError, [], lambda: backbend.Rig("even", np.zeros((3, 3))))
refused(TypeError, ["rig"], lambda: backbend.Rig(7, body))
refused(backbend.InputError, ["nowhere.glb"], lambda: backbend.load("nowhere.glb"))
refused(ValueError, ["not built on this character"],
        lambda: body.pose(backbend.Rig("even", body.chain), good))
refused(backbend.InputError, ["no sweep 'extnsion'"], lambda: body.measure_sweep(rig, "extnsion"))
refused(ValueError, ["envelope"], lambda: backbend.judge(body, envelope="humn"))
refused(TypeError, ["two of one kind"], lambda: backbend.compare(body, "even"))
refused(TypeError, [], lambda: backbend.judge(7))
""")

    def test_order_strides_and_types_of_numbers_change_no_result(self):
        self.run_script("""
rig = backbend.Rig("isner", np.array([[0, 0, 0], [0, 1, 0], [0, 2, 0]], float))
plain = np.random.default_rng(1).integers(-60, 60, (50, len(rig.channels))).astype(float)
expected = rig.solve(plain).positions
raw = np.zeros(plain.nbytes + 3, np.uint8)
unaligned = raw[3:].view(np.float64).reshape(plain.shape); unaligned[:] = plain
record = np.zeros(50, [("a", "i1"), ("v", "f8", (len(rig.channels),))]); record["v"] = plain
for other in (np.asfortranarray(plain), plain[::-1][::-1], plain[:, ::-1][:, ::-1], plain.astype(np.float32),
              plain.astype(np.int16), plain.astype(">f8"), np.repeat(plain, 2, 0)[::2], unaligned, record["v"], plain.tolist()):
    assert (rig.solve(other).positions == expected).all()
reverse = rig.solve(plain[::-1])
assert (reverse.positions[::-1] == expected).all()
empty = rig.solve(np.zeros((0, len(rig.channels))))
assert empty.positions.shape == (0, len(rig.joints), 3)
""")

    def test_order_strides_and_types_of_matrices_change_no_body(self):
        self.run_script("""
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
view = body.pose(rig, [rig.controls(extension=e) for e in (10, 20, 30)]).matrices  # columns follow each other
expected = body.skin(view)
plain = np.ascontiguousarray(view)
raw = np.zeros(plain.nbytes + 3, np.uint8)
unaligned = raw[3:].view(np.float64).reshape(plain.shape); unaligned[:] = plain
for other in (plain, np.asfortranarray(plain), view[::-1][::-1], np.repeat(view, 2, 0)[::2], np.repeat(plain, 2, 1)[:, ::2],
              plain.astype(">f8"), plain.astype(np.longdouble), unaligned, plain.tolist()):
    assert (body.skin(other).positions == expected.positions).all()
    assert (body.skin(other).normals == expected.normals).all()
for pose in range(3):
    for one in (view[pose], plain[pose], view[pose:pose + 1]):
        assert (body.skin(one).positions[0] == expected.positions[pose]).all()
same = body.skin(np.broadcast_to(view[1], (4, *view.shape[1:])))
assert (same.positions == expected.positions[1]).all()
for wrong in (float("nan"), float("inf"), -float("inf")):
    for order in (plain, view):
        bad = order.copy(order="K"); bad[1, 2, 3, 0] = wrong
        try:
            raise SystemExit(f"taken: {body.skin(bad)}")
        except ValueError as error:
            assert str(error) == "matrices[1, 2, 3, 0] is not a finite number", error
""")

    def test_what_does_not_fit_into_memory_is_a_memory_error(self):
        if os.environ.get("BACKBEND_PRELOAD"):
            self.skipTest("an allocation that fails ends a program under a sanitizer")
        self.run_script("""
import resource
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
def too_large(call):
    try:
        call()
    except MemoryError:
        return
    raise SystemExit("taken")
# Rows that are one row in memory, many times.
too_large(lambda: rig.solve(np.broadcast_to(rig.rest_controls, (10**13, len(rig.channels)))))
too_large(lambda: body.skin(np.broadcast_to(body.rest_matrices, (10**13, *body.rest_matrices.shape))))
limit = resource.getpagesize() * int(open("/proc/self/statm").read().split()[0]) + (1 << 30)
resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
too_large(lambda: body.pose(rig, np.zeros((200_000, len(rig.channels)))))
too_large(lambda: rig.solve(np.zeros((3_000_000, len(rig.channels)))))
assert np.isfinite(rig.solve(rig.rest_controls).positions).all()
""")

    def test_numbers_of_numpy_are_options_as_those_of_python(self):
        self.run_script("""
joints = np.array([[0, y, 0] for y in range(4)], float)
for bones in (7, 7.0, np.int64(7), np.uint8(7), np.float32(7), np.array(7)):
    assert backbend.Rig("even", joints, bones=bones).options["bones"] == 7
""")

    def test_arrays_whose_owners_are_gone_keep_their_memory(self):
        self.run_script("""
import gc, mmap
body = backbend.load(HUMAN)
rig = backbend.Rig("even", body)
held = mmap.mmap(-1, 8 * len(rig.channels))
controls = np.frombuffer(held)
try:
    held.close()
    raise SystemExit("closed under an array")
except BufferError:
    pass
assert (rig.solve(controls).positions[0] == rig.solve(rig.rest_controls * 0).positions[0]).all()
def of_a_pose():
    posed = body.pose(backbend.Rig("even", body), [rig.rest_controls] * 3)
    return posed.positions[1, ::2], posed.matrices[2].T
places, matrices = of_a_pose()
frame = body.render(rig, width=16, height=16, samples=1).layers["RGBA"][::-1, :, 0]
measured = body.measure(rig).metric
gc.collect()
ballast = [np.full(1 << 16, np.nan) for _ in range(256)]
assert np.isfinite(places).all() and np.isfinite(matrices).all() and np.isfinite(frame).all()
assert any(np.isfinite(value[0]) for value in measured.values())
""")

    def test_an_error_has_the_words_and_the_exit_code_of_the_command(self):
        (self.folder / "broken.glb").write_bytes(b"glTF" + b"\0" * 30)
        told = run_backbend(["check", "broken.glb", "--quick"], self.folder)
        words = self.run_script("""
try:
    backbend.load("broken.glb")
except backbend.Error as error:
    print(error.exit_code, error)
""")
        self.assertEqual(f"{told.returncode} {told.stderr.removeprefix('backbend: ')}", words)
