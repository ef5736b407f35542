#!/usr/bin/env python3
"""Blender's own weight smoothing on the characters that `repair_battery` spoiled, beside `backbend repair`.

    build/release/tests/repair_battery --seed 15 --rounds 2 --lines cases.jsonl --keep DIR
    tests/battery/blender_smoothing.py DIR cases.jsonl

Blender reads each faulted file, smooths all vertex groups (factor 0.5, ten times), limits them to as many groups a
vertex as the file has, normalises them and writes a .glb. `backbend check --quick` judges the sound, the faulted and
the smoothed file: failures of the weights that the sound one does not have, by check and sweep. Prints a row for each
body: findings of the fault, those that smoothing leaves and adds, those that repair leaves. Needs Blender; BACKBEND
names the program.
"""

import argparse
import collections
import json
import os
import pathlib
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/cli"))
import harness  # noqa: E402

BACKBEND = os.environ.get("BACKBEND", SOURCE / "build/release/cli/backbend")

SMOOTH = """
import bpy, numpy, sys
numpy.bool = bool  # Debian 12's importer calls it so, its NumPy no longer
source, target = sys.argv[-2:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.import_scene.gltf(filepath=source)
for each in list(bpy.data.objects):
    if each.type != 'MESH' or not each.vertex_groups:
        continue
    most = max((len(v.groups) for v in each.data.vertices), default=4)
    bpy.context.view_layer.objects.active = each
    for other in bpy.data.objects:
        other.select_set(other is each)
    bpy.ops.object.mode_set(mode='WEIGHT_PAINT')
    bpy.ops.object.vertex_group_smooth(group_select_mode='ALL', factor=0.5, repeat=10)
    bpy.ops.object.vertex_group_limit_total(group_select_mode='ALL', limit=max(most, 4))
    bpy.ops.object.vertex_group_normalize_all(group_select_mode='ALL', lock_active=False)
    bpy.ops.object.mode_set(mode='OBJECT')
bpy.ops.export_scene.gltf(filepath=target, export_format='GLB')
"""


def failures(file, folder):
    """Failures of the weights and of the file, as (check, sweep)."""
    run = subprocess.run([BACKBEND, "check", file, "--quick", "-o", folder], capture_output=True, text=True)
    if run.returncode not in (0, 1):
        raise RuntimeError(f"{file}: {run.stderr.strip()}")
    findings = json.loads((folder / "report.json").read_text())["findings"]
    return {(each["code"], each["sweep"]) for each in findings
            if each["verdict"] == "fail" and each["owner"] in ("WEIGHTS", "INPUT")}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path, help="what repair_battery kept")
    parser.add_argument("lines", type=pathlib.Path, help="its lines of JSON")
    options = parser.parse_args()
    rows = collections.defaultdict(collections.Counter)
    with tempfile.TemporaryDirectory() as scratch:
        scratch = pathlib.Path(scratch)
        script = scratch / "smooth.py"
        script.write_text(SMOOTH)
        for line in options.lines.read_text().splitlines():
            case = json.loads(line)
            if not case["planted"]:
                continue
            files = options.folder / str(case["n"])
            smoothed = scratch / "smoothed.glb"
            smoothed.unlink(missing_ok=True)
            subprocess.run(["blender", "-b", "--factory-startup", "--python-exit-code", "9", "-P", script, "--",
                            files / "faulted.glb", smoothed],
                           env=harness.blender_environment(scratch), capture_output=True, check=True)
            sound, faulted, after = (failures(file, scratch / f"{case['n']}{name}") for name, file in
                                     (("s", files / "healthy.glb"), ("f", files / "faulted.glb"), ("b", smoothed)))
            planted = faulted - sound
            row = rows[case["character"]]
            row.update(cases=1, findings=len(planted), left=len(planted & after),
                       added=len(after - sound - planted), by_repair=case["left"])
            print(f"{case['character']} {case['kind']} {case['size']}: {len(planted)} findings, Blender leaves "
                  f"{len(planted & after)} and adds {len(after - sound - planted)}, repair leaves {case['left']}",
                  file=sys.stderr, flush=True)
    print("| body | cases | findings | left by Blender's smoothing | added by it | left by `repair` |")
    print("|---|---|---|---|---|---|")
    total = sum(rows.values(), collections.Counter())
    for name, row in [*sorted(rows.items()), ("all", total)]:
        print(f"| {name} | {row['cases']} | {row['findings']} | {row['left']} | {row['added']} | {row['by_repair']} |")


if __name__ == "__main__":
    main()
