"""The battery of `export even` (docs/batteries.md): the graph, the nodes for Maya in an evaluator, and the rig that
Blender builds, each against the solver over many random poses to +-180 degrees of all nine channels.

    /usr/bin/python3 tests/battery/export_battery.py --poses 10000 CHARACTER.glb ...
"""

import argparse
import pathlib
import subprocess
import sys
import tempfile

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "cli"))
import json  # noqa: E402

import export_test  # noqa: E402
from blender_rig import BlenderRig  # noqa: E402
from even_native import Distance, graph_pose, largest_gain, random_poses, solver_poses  # noqa: E402
from harness import run_backbend  # noqa: E402
from maya_rig import MayaRig  # noqa: E402

ALL = ("json", "maya", "blender")


def exported(program, glb, folder):
    file = folder / f"even_{program}.{'json' if program == 'json' else 'py'}"
    told = run_backbend(["export", "even", "--to", program, "--for", glb, "-o", file], folder)
    if told.returncode != 0:
        raise SystemExit(told.stderr)
    return file


def build_in_blender(glb, graph, folder):
    blend, built = folder / "hero.blend", folder / "built.blend"
    script = folder / "import.py"
    script.write_text(export_test.IMPORT)
    for words in (["--factory-startup", "--python", script, "--", glb, blend],
                  [blend, "--factory-startup", "--disable-autoexec", "--python", exported("blender", glb, folder),
                   "--", "-o", built]):
        first = words[:1] if words[0] == blend else []
        subprocess.run([export_test.BLENDER, *first, "--background", *words[len(first):]], check=True,
                       capture_output=True)
    return BlenderRig(export_test.BLENDER, built, [joint["name"] for joint in graph["joints"]], folder / "map.json")


def measure(glb, poses, programs, folder):
    graph = json.loads(exported("json", glb, folder).read_text())
    rigs = {}
    if "json" in programs:
        rigs["json"] = lambda some: [graph_pose(graph, pose) for pose in some]
    if "maya" in programs:
        maya = MayaRig(graph, rotate_order=4, rotate_axis=(20.0, -30.0, 50.0))
        maya.run(exported("maya", glb, folder))
        rigs["maya"] = maya.poses
    if "blender" in programs and export_test.BLENDER:
        blender = build_in_blender(glb, graph, folder)
        rigs["blender"] = blender.poses
    distance = {program: Distance(graph["length"]) for program in rigs}
    for first in range(0, len(poses), 500):
        some = poses[first:first + 500]
        exact = solver_poses(graph, some, folder)
        for program, rig in rigs.items():
            for spine, solved in zip(rig(some), exact):
                distance[program].add(spine, solved)
    for program, rig in rigs.items():
        gain = largest_gain(rig, poses[:max(len(poses) // 10, 9)])
        far = distance[program]
        good = (far.turn_deg <= export_test.MOST_TURN_DEG and far.place_percent <= export_test.MOST_PLACE_PERCENT
                and gain <= export_test.MOST_GAIN)
        print(f"{glb.name:30} {program:8} {len(poses)} poses, {len(graph['samples'])} steps: turn {far.turn_deg:.2g} deg, "
              f"place {far.place_percent:.3g} %, gain {gain:.6f}: {'good' if good else 'NOT WITHIN'}", flush=True)
        yield good
    if "blender" in rigs:
        blender.close()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("characters", nargs="+", type=pathlib.Path)
    parser.add_argument("--poses", type=int, default=10000)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--to", nargs="+", choices=ALL, default=ALL)
    options = parser.parse_args()
    good = []
    for glb in options.characters:
        with tempfile.TemporaryDirectory(prefix="backbend export ") as folder:
            good += measure(glb.resolve(), random_poses(options.poses, options.seed), options.to, pathlib.Path(folder))
    return 0 if good and all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
