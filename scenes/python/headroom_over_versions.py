#!/usr/bin/env python3
"""Plots how far each version of a character is clean: headroom_over_versions.py hero_v*.glb -o headroom.png"""

import argparse
import math
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
    for number, file in enumerate(arguments.characters):
        for room in backbend.judge(file, arguments.rig).rigs[0].headroom:
            degrees = clean.setdefault(room.channel, [math.nan] * len(arguments.characters))
            degrees[number] = math.nan if room.clean_to_deg is None else room.clean_to_deg
            needs[room.channel] = room.needs_deg or 0.0

    versions = range(len(arguments.characters))
    names = [pathlib.Path(file).stem for file in arguments.characters]
    figure, (panels,) = pyplot.subplots(1, len(clean), figsize=(2.5 * len(clean), 4), sharey=True, squeeze=False,
                                        layout="constrained")
    for axes, (channel, degrees) in zip(panels, clean.items()):
        axes.set_title(f"{channel}, needs {needs[channel]:g}")
        axes.plot(versions, degrees, marker="o")
        axes.axhline(needs[channel], color="C3", linestyle=":")
        axes.set_xticks(versions, names, rotation=45, ha="right")
    panels[0].set_ylabel("clean to (degrees)")
    panels[0].set_ylim(bottom=0)
    figure.savefig(arguments.output, dpi=120)
    for channel, degrees in clean.items():
        print(channel, *(f"{each:g}" for each in degrees))


if __name__ == "__main__":
    main()
