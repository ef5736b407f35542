"""backbend bake --usd: UsdSkel that readers of others pose and skin as we do (three's USDLoader, tinyusdz; npm), and
whose arrays, by the meaning that UsdSkel's documentation gives them, make the same points."""

import json
import math
import shutil
import struct
import subprocess

from glb import HUMAN, encode, tube
from harness import CHARACTERS, SOURCE, CommandTest, human

NODE = shutil.which("node")
WEB = SOURCE / "tests/web"
CLOSE = 1e-5  # of the body's height
SKELETON, MOTION = "/Root/Character/Skeleton", "/Root/Character/Skeleton/Motion"


def flat(value):
    """The numbers of a nested list, in order."""
    return [number for each in value for number in flat(each)] if isinstance(value, list) else [value]


def product(a, b):
    """Of matrices as rows."""
    return [[sum(a[i][k] * b[k][j] for k in range(4)) for j in range(4)] for i in range(4)]


def inverse(m):
    """By elimination with the largest pivot."""
    rows = [list(map(float, row)) + [float(i == j) for j in range(4)] for i, row in enumerate(m)]
    for column in range(4):
        pivot = max(range(column, 4), key=lambda r: abs(rows[r][column]))
        rows[column], rows[pivot] = rows[pivot], rows[column]
        rows[column] = [v / rows[column][column] for v in rows[column]]
        for r in range(4):
            if r != column:
                rows[r] = [v - rows[r][column] * p for v, p in zip(rows[r], rows[column])]
    return [row[4:] for row in rows]


def local_matrix(translation, rotation, scale):
    """Scale, then rotation, then translation, for row vectors. `rotation` is x, y, z, w."""
    x, y, z, w = rotation
    turn = [[1 - 2 * (y * y + z * z), 2 * (x * y + z * w), 2 * (x * z - y * w)],
            [2 * (x * y - z * w), 1 - 2 * (x * x + z * z), 2 * (y * z + x * w)],
            [2 * (x * z + y * w), 2 * (y * z - x * w), 1 - 2 * (x * x + y * y)]]
    return [[s * v for v in row] + [0.0] for s, row in zip(scale, turn)] + [[*translation, 1.0]]


def in_rows(numbers):
    numbers = flat(numbers)
    return [[numbers[16 * m + 4 * r:16 * m + 4 * r + 4] for r in range(4)] for m in range(len(numbers) // 16)]


class Skeleton:
    """What UsdSkel's documentation says that a skeleton, its animation and a binding mean."""

    def __init__(self, values):
        self.values = values
        self.joints = values[SKELETON + ".joints"]
        self.bind = [inverse(m) for m in in_rows(values[SKELETON + ".bindTransforms"])]
        self.rest = in_rows(values[SKELETON + ".restTransforms"])
        parents = {path: i for i, path in enumerate(self.joints)}
        self.parent = [parents[path.rsplit("/", 1)[0]] if "/" in path else -1 for path in self.joints]

    def sample(self, name, time):
        key = f"{MOTION}.{name}"
        return flat(self.values[key + "@samples"][str(time)] if key + "@samples" in self.values else self.values[key])

    def joints_at(self, time):
        """skeleton_from_joint of each joint; those that the animation leaves out are at rest."""
        animated = self.values[MOTION + ".joints"]
        t, r, s = (self.sample(name, time) for name in ("translations", "rotations", "scales"))
        local = {path: local_matrix(t[3 * i:3 * i + 3], r[4 * i:4 * i + 4], s[3 * i:3 * i + 3])
                 for i, path in enumerate(animated)}
        world = []
        for i, path in enumerate(self.joints):
            own = local.get(path, self.rest[i])
            world.append(own if self.parent[i] < 0 else product(own, world[self.parent[i]]))
        return world

    def points_at(self, mesh, time):
        prefix = f"/Root/Character/{mesh}."
        points = flat(self.values[prefix + "points"])
        (bound,) = in_rows(self.values[prefix + "primvars:skel:geomBindTransform"])
        skin = [product(product(bound, bind), world) for bind, world in zip(self.bind, self.joints_at(time))]
        indices = self.values[prefix + "primvars:skel:jointIndices"]
        weights = self.values[prefix + "primvars:skel:jointWeights"]
        most = len(indices) // (len(points) // 3)
        moved = []
        for v in range(len(points) // 3):
            x, y, z = points[3 * v:3 * v + 3]
            place = [0.0] * 3
            for k in range(most * v, most * v + most):
                if weights[k]:
                    m = skin[indices[k]]
                    for c in range(3):
                        place[c] += weights[k] * (x * m[0][c] + y * m[1][c] + z * m[2][c] + m[3][c])
            moved.append(place)
        return moved


class ReadingWithOthers(CommandTest):
    """Readers from npm (npm ci --prefix tests/web)."""

    def setUp(self):
        super().setUp()
        if not NODE or not (WEB / "node_modules/tinyusdz").is_dir() or not (WEB / "node_modules/three").is_dir():
            self.skipTest("Node, three or tinyusdz (npm ci --prefix tests/web) is not installed")

    def read(self, usd, times):
        told = subprocess.run([NODE, WEB / "usd_read.mjs", usd, ",".join(map(str, times))], capture_output=True,
                              text=True, timeout=600)
        self.assertEqual(told.returncode, 0, told.stdout[-2000:] + told.stderr[-2000:])
        return json.loads(told.stdout)

    def ours(self, body, rig, degrees):
        """Points of the pose as render exports them."""
        obj = self.folder / "pose.obj"
        self.assert_runs("render", body, "--rig", rig, "--pose", f"extension={degrees}", "--res", "16x16", "--spp", "1",
                         "-o", "pictures", "--export-obj", obj)
        return [[float(v) for v in row.split()[1:4]] for row in obj.read_text().splitlines() if row.startswith("v ")]

    def assert_close(self, ours, theirs, what):
        height = max(p[1] for p in ours) - min(p[1] for p in ours)
        self.assertEqual(len(ours), len(theirs), what)
        self.assertLess(max(math.dist(a, b) for a, b in zip(ours, theirs)), CLOSE * height, what)

    def check_body(self, body, rig, most=4, frames=(0, 17, 60)):
        usd = self.folder / "out.usda"
        self.assert_runs("bake", body, "--rig", rig, "--sweep", "extension", "--usd", usd)
        times = [1001 + frame for frame in frames]
        read = self.read(usd, times)
        values = read["values"]
        skeleton = Skeleton(values)
        meshes = [path.split("/")[3].split(".")[0] for path in values if path.endswith(".faceVertexIndices")]
        self.assertEqual(sorted(read["meshes"]), sorted(meshes))
        moved = []
        for frame, time in zip(frames, times):
            ours = self.ours(body, rig, 2 * frame)
            moved.append(ours)
            evaluated = [p for mesh in meshes for p in skeleton.points_at(mesh, time)]
            self.assert_close(ours, evaluated, f"UsdSkel's meaning, frame {frame}")
            if most <= 4:  # three skins by four joints, and has each corner of a face for itself
                shown = read["posed"][str(time)]["meshes"]
                first = 0
                for mesh in meshes:
                    corners = values[f"/Root/Character/{mesh}.faceVertexIndices"]
                    self.assert_close([ours[first + v] for v in corners], shown[mesh], f"three, frame {frame}, {mesh}")
                    first += len(flat(values[f"/Root/Character/{mesh}.points"])) // 3
            joints = read["posed"][str(time)]["joints"]
            for path, world in zip(skeleton.joints, skeleton.joints_at(time)):
                self.assertLess(math.dist(joints[path.split("/")[-1]][12:15], world[3][:3]), 1e-5, path)
        self.assertGreater(max(math.dist(a, b) for a, b in zip(moved[0], moved[-1])), 0.3)  # it plays
        for mesh, typed in read["meshes"].items():
            for key in ("points", "faceVertexIndices", "faceVertexCounts"):
                plain = flat(values[f"/Root/Character/{mesh}.{key}"])
                self.assertEqual(len(plain), len(typed[key]), key)
                self.assertLessEqual(max(abs(a - b) for a, b in zip(plain, typed[key])), 1e-6, key)
        indices = values[f"/Root/Character/{meshes[0]}.primvars:skel:jointIndices"]
        self.assertEqual(len(indices) * 3, most * len(flat(values[f"/Root/Character/{meshes[0]}.points"])))
        return read

    def test_a_tube_is_posed_and_skinned_as_ours(self):
        self.check_body(self.write("tube.glb", tube()), "curve", most=2)

    def test_the_bundled_human_is_posed_and_skinned_as_ours(self):
        self.check_body(human(1500), "even", frames=(0, 60))

    def test_real_characters_are_posed_and_skinned_as_ours(self):
        """Skips with a count where they are absent."""
        names = ["cesium_man.glb", "mh_female_cmu_13k.glb", "quaternius_female_24k.glb"]
        there = [CHARACTERS / name for name in names if (CHARACTERS / name).is_file()]
        if not there:
            self.skipTest(f"{len(names)} characters are not on this machine")
        for path in there:
            with self.subTest(path.name):
                usd = self.folder / "out.usda"
                self.assert_runs("bake", path, "--rig", "curve", "--usd", usd)
                values = self.read(usd, [1001])["values"]
                skeleton = Skeleton(values)
                meshes = [p.split("/")[3].split(".")[0] for p in values if p.endswith(".faceVertexIndices")]
                for frame in (0, 45):
                    self.assert_close(self.ours(path, "curve", 2 * frame),
                                      [p for mesh in meshes for p in skeleton.points_at(mesh, 1001 + frame)], path.name)

    def test_eight_influences_are_all_there(self):
        def more(document):
            # The same four joints and weights once more, each halved: eight influences of four joints would be merged,
            # so the second set names the others.
            primitive = document["meshes"][0]["primitives"][0]["attributes"]
            primitive["JOINTS_1"], primitive["WEIGHTS_1"] = len(document["accessors"]), len(document["accessors"]) + 1
            for key, component in ((joints, 5121), (weights, 5126)):
                document["bufferViews"].append({"buffer": 0, "byteOffset": document["buffers"][0]["byteLength"] +
                                                (0 if key is joints else len(joints)), "byteLength": len(key)})
                document["accessors"].append({"bufferView": len(document["bufferViews"]) - 1, "componentType": component,
                                              "type": "VEC4", "count": count})
            document["buffers"][0]["byteLength"] += len(joints) + len(weights)

        count = 72
        joints = bytes([2, 3, 4, 0] * count)
        weights = struct.pack("<4f", 0.1, 0.1, 0.1, 0.0) * count

        def lower(i, position, own, shares):
            return position, [0, 1, 0, 0], [0.4, 0.3, 0.0, 0.0]
        plain = tube(HUMAN, vertex=lower)
        length = struct.unpack("<I", plain[12:16])[0]
        document = json.loads(plain[20:20 + length])
        binary = plain[28 + length:]
        more(document)
        body = self.write("eight.glb", encode(document, binary + joints + weights))
        self.check_body(body, "curve", most=5)

    def test_odd_and_doubled_names_and_many_parts_are_taken(self):
        def rename(document):
            for node, name in zip(document["nodes"], ["hips", "spine:01", "9 bad \"name\" \\", "spine_01", "spine:01"]):
                node["name"] = name
            primitive = document["meshes"][0]["primitives"][0]
            document["meshes"][0]["primitives"] = [primitive, dict(primitive)]
            document["meshes"][0]["name"] = "Skeleton"
        body = self.write("odd.glb", tube(change=rename))
        usd = self.folder / "out.usda"
        self.assert_runs("bake", body, "--hip", "hips", "--chest", "spine_01", "--rig", "curve", "--usd", usd)
        read = self.read(usd, [1001])
        joints = read["values"][SKELETON + ".joints"]
        words = [word for path in joints for word in path.split("/")[-1:]]
        self.assertEqual(len(set(words)), len(words))
        for word in words:
            self.assertTrue(word.isidentifier() and word.isascii(), word)
        self.assertEqual(len(read["meshes"]), 2)
        self.assertIn("9 bad", read["values"][SKELETON + ".jointNames"][2])


class TheFile(CommandTest):
    def test_it_says_units_axis_rate_and_range_and_is_the_same_for_any_number_of_threads(self):
        body = self.write("tube.glb", tube())
        self.assert_runs("bake", body, "--rig", "curve", "--fps", "30", "--usd", "a.usda", "-o", "a.glb")
        self.assert_runs("bake", body, "--rig", "curve", "--fps", "30", "--usd", "b.usda", "--threads", "1")
        text = (self.folder / "a.usda").read_text()
        self.assertEqual(text, (self.folder / "b.usda").read_text())
        self.assertTrue((self.folder / "a.glb").is_file())
        for line in ('defaultPrim = "Root"', "metersPerUnit = 1", 'upAxis = "Y"', "timeCodesPerSecond = 30",
                     "startTimeCode = 1001", "endTimeCode = 1061", 'def Camera "profile"', "float focalLength = 50",
                     'uniform token primvars:skel:skinningMethod = "classicLinear"'):
            self.assertIn("    " + line + "\n", text)

    def test_findings_of_a_run_go_along_with_the_time_of_their_pose(self):
        body = self.write("tube.glb", tube())
        self.backbend("check", body, "--rig", "isner", "--quick", "-o", "run")
        findings = [f for f in json.loads((self.folder / "run/report.json").read_text())["findings"] if f["rig"] == "isner"]
        self.assertTrue(findings)
        self.assert_runs("bake", body, "--rig", "isner", "--usd", "out.usda", "--findings", "run")
        text = (self.folder / "out.usda").read_text()
        scope = text[text.index('def Scope "Findings"'):]
        self.assertEqual(scope.count("string code = "), len(findings))
        on_sweep = [f for f in findings if f["sweep"] == "extension"]
        self.assertEqual(scope.count("double time_code = "), len(on_sweep))
        for finding in on_sweep:
            self.assertIn(f"double time_code = {1001 + math.floor(finding['control_deg'] / 2 + 0.5)}\n", scope)

    def test_what_it_cannot_do_is_refused_in_one_line(self):
        body = self.write("tube.glb", tube())
        self.assert_refused("bake", body, code=2, names=["--usd"])
        self.assert_refused("bake", body, "--usd", "out.usdc", code=2, names=[".usda"])
        self.assert_refused("bake", body, "-o", "out.glb", "--findings", "run", code=2, names=["--usd"])
        self.assert_refused("bake", body, "--usd", "out.usda", "--findings", "none", names=["none"])
        self.backbend("check", body, "--quick", "-o", "run")
        self.assert_refused("bake", body, "--rig", "isner", "--usd", "out.usda", "--findings", "run",
                            names=["isner", "even on tube"])
