#!/usr/bin/env python3
"""Steps planted in the drivers of a live Blender rig: which of them `backbend` finds, where, and of what size.

    tests/battery/blender_steps.py --seed 1 --steps 100 --pulses 40

A spine of five bones follows one control by drivers that call functions of the file. Into those go steps of 1 to 180
degrees at random angles of extension, flexion, side and twist, and pulses, which go and come back. Judged are: every
step found once, at its angle to 1e-4 of the sweep, with its size to 1 %; every pulse found that is at least as wide as
the report says it sees; nothing else. With --clip the same rig is exported every 2 degrees and that clip judged: every
step found, within 2 degrees, that is larger than those which the report says it hides.

Prints a table and exits with 1 where something is missing or too many. Needs Blender; BACKBEND names the program.
"""

import argparse
import json
import math
import os
import pathlib
import random
import re
import subprocess
import sys
import tempfile

SOURCE = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "tests/cli"))
import glb  # noqa: E402
import spine_rig  # noqa: E402
from spine_rig import BONES  # noqa: E402

ENDS = {"extension": 120, "flexion": 90, "side": 45, "twist": 90}  # degrees, where the sweeps end
AXES = {"extension": ("rx", -1), "flexion": ("rx", 1), "side": ("rz", -1), "twist": ("ry", 1)}
STEP = 2  # degrees from pose to pose
NEAREST = 0.05  # degrees between two events of one sweep

# Each bone above the hips takes a quarter of the control's turn about each axis, and what is planted in it.
PLANTED = """
text = bpy.data.texts.new("planted.py")
text.write("import bpy, math\\nEVENTS = " + open(sys.argv[-1]).read() + '''
def planted(bone, axis, value):
    degrees = math.degrees(value)
    extra = sum(size for sign, at, until, size in EVENTS.get(f"{bone}.{axis}", []) if at <= sign * degrees < until)
    return value / 4 + math.radians(extra)
bpy.app.driver_namespace["planted"] = planted
''')
text.use_module = True
exec(text.as_string())
"""


def plant(seed, steps, pulses):
    """[{channel, bone, at, size, width}], by channel and angle; the width of a step is None."""
    chance = random.Random(seed)
    events = []
    for k in range(steps + pulses):
        channel = list(ENDS)[k % len(ENDS)]
        while True:
            width = None if k < steps else math.exp(chance.uniform(math.log(0.05), math.log(1.5 * STEP)))
            at = chance.uniform(2, ENDS[channel] - 1 - (width or 0))
            apart = [(other["at"], other["at"] + (other["width"] or 0)) for other in events if other["channel"] == channel]
            if all(at - NEAREST > last or at + (width or 0) + NEAREST < first for first, last in apart):
                break
        size = math.exp(chance.uniform(math.log(1.05), math.log(180)))
        events.append({"channel": channel, "bone": chance.randrange(1, 5), "at": at, "size": size, "width": width})
    return sorted(events, key=lambda event: (event["channel"], event["at"]))


def table_of(events):
    """As the rig's own functions take them: by bone and axis, (sign of the control, from, until, size)."""
    table = {}
    for event in events:
        axis, sign = AXES[event["channel"]]
        until = event["at"] + event["width"] if event["width"] else 1e9
        table.setdefault(f"{event['bone']}.{'xyz'.index(axis[1])}", []).append([sign, event["at"], until, event["size"]])
    return table


def run(program, folder, words, allowed=(0, 1, 5)):
    told = subprocess.run([str(program), *map(str, words)], cwd=folder, capture_output=True, text=True,
                          env={"PATH": os.environ["PATH"], "HOME": str(folder)})
    if told.returncode not in allowed:
        raise SystemExit(f"backbend {' '.join(map(str, words))}: {told.returncode}\n{told.stdout}{told.stderr}")


def make(folder, events):
    """The character, the rig and the mapping in `folder`."""
    (folder / "tube.glb").write_bytes(glb.tube(BONES, unit=1.0 / 1.6))
    (folder / "events.json").write_text(json.dumps(table_of(events)))
    spine_rig.run_script(folder, spine_rig.driven('f"planted({k}, {axis}, var)"', before=PLANTED), folder / "hero.blend",
                         folder / "events.json")
    channels = {name: [{"control": "chest_ctl", "channel": axis, "per_degree": sign}] for name, (axis, sign) in AXES.items()}
    (folder / "map.json").write_text(json.dumps({"armature": "rig", "mesh": False, "spine": BONES, "channels": channels}))


def judge_live(program, folder, servers):
    """([(channel, angle, size)], {channel: the width that the report says it sees}, evaluations)"""
    (folder / "night.toml").write_text(f"""
[suite]
name = "planted"
title = "Planted"
characters = ["tube.glb"]
mappings = ["chest"]
envelope = "sweep"
corners = false
[[rig]]
name = "hero"
solver = {{ system = "external", program = "blender", file = "hero.blend", map = "map.json", servers = {servers} }}
""" + "".join(f'[[sweep]]\nchannel = "{name}"\nto = {end}\nstep = {STEP}\n' for name, end in ENDS.items()))
    run(program, folder, ["nightly", "night.toml", "--hip", BONES[0], "--chest", BONES[-1], "--quick", "-o", "live"])
    report = json.loads((folder / "live/report.json").read_text())
    found = [(each["sweep"], each["control_deg"], each["value"]) for each in report["findings"] if each["code"] == "BB001"]
    (note,) = [note for note in report["characters"][0]["notes"] if "evaluations along" in note]
    widths = {channel: float(width) for width, channel in re.findall(r"([0-9.]+) deg of ([a-z]+)", note)}
    return found, widths, int(re.search(r"(\d+) evaluations", note).group(1))


def compare(events, found, widths):
    """What is wrong, a line each; and (steps found, pulses found, pulses that had to be found)."""
    wrong, left = [], list(found)
    steps = pulses = wide = 0

    def take(channel, at, size):
        near = [each for each in left if each[0] == channel and abs(each[1] - at) <= 1e-4 * ENDS[channel]]
        for each in near:
            left.remove(each)
            if abs(each[2] - size) > 0.01 * size:
                wrong.append(f"{channel} {at:.4f}: {each[2]:.3f} deg found, {size:.3f} planted")
        return bool(near)

    for event in events:
        channel, at, size, width = (event[key] for key in ("channel", "at", "size", "width"))
        seen = take(channel, at, size)
        if width is None:
            steps += seen
            if not seen:
                wrong.append(f"{channel} {at:.4f}: a step of {size:.3f} deg was not found")
            continue
        back = take(channel, at + width, size)
        pulses += seen and back
        must = width >= widths[channel]
        wide += must
        if must and not (seen and back):
            wrong.append(f"{channel} {at:.4f}: {size:.3f} deg that come back after {width:.3f} deg were not found, "
                         f"though {widths[channel]} deg is said to be seen")
    wrong += [f"{channel} {at:.4f}: {size:.3f} deg found where nothing was planted" for channel, at, size in left]
    return wrong, (steps, pulses, wide)


EXPORT = """
import json, sys
sys.path.insert(0, {bridges!r})
import bpy
bpy.ops.wm.open_mainfile(filepath={blend!r}, use_scripts=True)
import backbend_blender
mapping = json.load(open({mapping!r}))
del mapping["mesh"]
backbend_blender.export(mapping, {out!r})
"""


def judge_clip(program, folder):
    """([(channel, angle, size)], the size from which the report says that it hides no jump)"""
    spine_rig.run_script(folder, EXPORT.format(bridges=str(SOURCE / "scenes/bridges"), blend=str(folder / "hero.blend"),
                                               mapping=str(folder / "map.json"), out=str(folder / "hero.clip")))
    run(program, folder, ["check", "--baked", "hero.clip", "--quick", "-o", "clip"])
    report = json.loads((folder / "clip/report.json").read_text())
    (line,) = [line for line in report["detectors"] if line.startswith("flips: jumps from")]
    found = [(each["sweep"], each["control_deg"], each["value"]) for each in report["findings"] if each["code"] == "BB001"]
    return found, float(re.search(r"hides those below ([0-9.]+)", line).group(1))


def compare_clip(events, found, hidden):
    """What is wrong, a line each; and how many steps were found."""
    wrong, seen = [], 0
    for event in (event for event in events if event["width"] is None):
        near = [each for each in found if each[0] == event["channel"] and abs(abs(each[1]) - event["at"]) <= STEP]
        seen += bool(near)
        if not near and event["size"] > hidden:
            wrong.append(f"clip, {event['channel']} {event['at']:.4f}: a step of {event['size']:.3f} deg was not found, though "
                         f"only those below {hidden} deg are said to be hidden")
    return wrong, seen


def main():
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--seed", type=int, default=1)
    options.add_argument("--steps", type=int, default=100)
    options.add_argument("--pulses", type=int, default=40)
    options.add_argument("--servers", type=int, default=1)
    options.add_argument("--clip", action="store_true")
    options.add_argument("--keep", help="a folder for the rig and its reports")
    asked = options.parse_args()
    program = pathlib.Path(os.environ.get("BACKBEND", SOURCE / "build/release/cli/backbend")).resolve()
    with tempfile.TemporaryDirectory(prefix="backbend steps ") as temporary:
        folder = pathlib.Path(asked.keep or temporary).resolve()
        folder.mkdir(parents=True, exist_ok=True)
        events = plant(asked.seed, asked.steps, asked.pulses)
        make(folder, events)
        found, widths, evaluations = judge_live(program, folder, asked.servers)
        wrong, (steps, pulses, wide) = compare(events, found, widths)
        clip = ""
        if asked.clip:
            found, hidden = judge_clip(program, folder)
            more, seen = compare_clip(events, found, hidden)
            wrong += more
            clip = f"; in a clip of every {STEP} degrees {seen}, said to hide those below {hidden} deg"
    print(f"seed {asked.seed}: {steps} of {asked.steps} steps found, {pulses} of {asked.pulses} pulses, of which {wide} are as "
          f"wide as the report says it sees ({widths}); {evaluations} evaluations{clip}; {len(wrong)} wrong")
    for line in wrong:
        print("  " + line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
