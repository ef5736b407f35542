#!/usr/bin/env python3
"""Plots how far each version of a character is clean: headroom_over_versions.py hero_v*.glb -o headroom.png"""

import argparse
import pathlib

import backbend
import matplotlib

matplotlib.use("Agg")  # no window
from matplotlib import pyplot  # noqa: E402


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("characters", nargs="+", help="versions of one character, oldest first")
    parser.add_argument("--rig", default="even")
    parser.add_argument("-o", "--output", default="headroom.png")
    arguments = parser.parse_args()

    clean: dict[str, list[float]] = {}
    needs: dict[str, float] = {}
    for file in arguments.characters:
        for room in backbend.judge(file, arguments.rig).rigs[0].headroom:
            clean.setdefault(room.channel, []).append(room.clean_to_deg or 0.0)
            needs[room.channel] = room.needs_deg or 0.0

    figure, axes = pyplot.subplots(figsize=(8, 4.5))
    names = [pathlib.Path(file).stem for file in arguments.characters]
    for number, (channel, degrees) in enumerate(clean.items()):
        axes.plot(names, degrees, color=f"C{number}", marker="o", label=f"{channel}, needs {needs[channel]:g}")
        axes.axhline(needs[channel], color=f"C{number}", linestyle=":", linewidth=1)
    axes.set_ylabel("clean to (degrees)")
    axes.set_ylim(bottom=0)
    axes.legend()
    figure.savefig(arguments.output, dpi=120)
    for channel, degrees in clean.items():
        print(channel, *(f"{each:g}" for each in degrees))


if __name__ == "__main__":
    main()
