#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The section on scenes of joints of docs/numerics.md, from what `run.py --joints` wrote.

    python3 benchmarks/peers/joints.py results/joints.csv
"""
import csv
import json
import statistics
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "work_precision"))

import results as runs

DATA = Path(__file__).resolve().parent.parent / "data"
HEADING = "## Scenes of joints"
WHAT = {
    "human": "a doll of 14 capsules falls 1 m",
    "rain": "twelve fall 20 m on grids with a torus each",
    "wedge": "six fall into a groove of two slopes of 45 degrees",
    "joint_grid": "a net of 30 x 30 balls hangs by its upper row",
    "ball_and_chain": "32 links, and a ball of 33.5 t on the last, fall from the level",
    "bridge": "200 planks of 31 kg hang, and a car of 120 kg drives over",
    "crane": "a jib swings a ball of 2 t on 20 links of 5 kg into a wall",
    "doors": "100 doors on two hinges each are driven against stops",
    "rain 20": "sixty dolls",
    "joint_grid 100": "100 x 100 balls",
}
INTRODUCTION = """\
`benchmarks/scenes/joint_scenes.cpp`: Box3D's benchmarks and samples of joints by their published sizes (rain, human,
joint_grid, ball_and_chain; of bridge and doors what is jointed), and what games build besides; Box3D has no scene of dolls
called wedge. The doll is Box3D's human to the millimetre, but no joint of it is open at the start, none has a spring, and
nothing rolls with resistance. In Box3D's own rain a row of ten groups is dropped every 0.8 s, here all fall at once. Friction
is 0.5, gravity 9.81 m/s^2, frames are of 1/60 s, one thread, 10 s (rain 6 s, joint_grid 5 s). Each engine is at its defaults,
asleep where it lets bodies be, but without damping; joint_grid is kept awake, as in Box3D's own. Limbs rest in Tandem below
the 0.03 m/s and 0.3 rad/s of its own ragdolls, and everything rests below 0.03 m/s in Jolt and 0.05 m/s in Box3D. Figures of time are of
frames in which something was awake. The adapters of Bullet and PhysX have no such joints."""


def read(path):
    """Rows of each scene and engine, over the repeats."""
    found = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            found.setdefault(row["scene"], {}).setdefault(row["engine"], []).append(row)
    return found


def median(rows, name):
    return statistics.median(runs.number(row[name]) for row in rows)


def short(value):
    return f"{value:.0f}" if 1000 <= abs(value) < 1e6 else f"{value:.3g}"


def time(rows, ours):
    own = median(rows, "cpu_ms_p50")
    beside = "" if rows is ours else f" ({median(ours, 'cpu_ms_p50') / own:.2g})"
    return (f"{short(own)}{beside}; {short(median(rows, 'cpu_ms_p99'))}; "
            f"{short(median(rows, 'cpu_ms_max'))}")


def steadiness(rows, _):
    return (f"{median(rows, 'cpu_ms_first') / median(rows, 'cpu_ms_p50'):.2g}; "
            f"{median(rows, 'slow_frames'):.0f}; {median(rows, 'substeps'):.0f}")


def separation(rows, _):
    return "; ".join(f"{1e3 * median(rows, f'separation_{name}'):.2g}" for name in ("p50", "p99", "max"))


def energy(rows, _):
    start, end, rise = (1e-3 * median(rows, name) for name in
                        ("energy_start", "energy_end", "energy_rise_max"))
    failed = median(rows, "failed_steps")
    return (f"{short(start)} to {short(end)}; {rise:.2g}"
            + (f"; **{failed:.0f} steps failed**" if failed else ""))


def rest(rows, _):
    asleep = median(rows, "bodies") - median(rows, "awake_end")
    last = f" at {median(rows, 'frames_awake'):.0f}" if median(rows, "awake_end") == 0 else ""
    return f"{asleep:.0f}{last}; {short(median(rows, 'lowest_end'))}"


TABLES = (
    ("Processor time of a frame, ms: median (Tandem's over it; more than 1: Tandem is slower); 99 %; "
     "largest:", time),
    ("First frame over the median; frames above four medians from the third on; most substeps or "
     "collision steps of a frame:", steadiness),
    ("Distance of a joint's two anchors, mm: median; 99 %; largest, over all joints and frames:",
     separation),
    ("Mechanical energy, kJ: start to end; largest rise in one frame. Motors work in bridge, crane and "
     "doors:", energy),
    ("Bodies asleep at the end (all of them: since which frame); the lowest body then, m:", rest),
)


def tables(found):
    out = []
    for title, cell in TABLES:
        engines = [e for e in runs.NAMES if any(e in scene for scene in found.values())]
        out += [title, "", "| scene | bodies, joints | " + " | ".join(runs.NAMES[e] for e in engines) + " |",
                "|---" * (len(engines) + 2) + "|"]
        for scene in WHAT:
            if scene not in found or "tandem" not in found[scene]:
                continue
            ours = found[scene]["tandem"]
            size = f"{median(ours, 'bodies'):.0f}, {median(ours, 'joints'):.0f}"
            cells = [cell(found[scene][e], ours) if e in found[scene] else "-" for e in engines]
            out.append(f"| {scene} | {size} | {' | '.join(cells)} |")
        out.append("")
    return out


def section(results):
    """@param results  folder that has joints.csv where the scenes were run with the rest
    @return lines of Markdown"""
    folder = results if (results / "joints.csv").exists() else DATA
    found = read(folder / "joints.csv")
    machine = json.loads((DATA / "joints.json").read_text())
    repeats = max(len(rows) for scene in found.values() for rows in scene.values())
    names = "; ".join(f"{scene}: {what}" for scene, what in WHAT.items() if scene in found)
    return [HEADING, "", INTRODUCTION, "", f"{names}.", "",
            f"{machine['peers']}; {machine['processor']}, {machine['cores']} cores, {machine['load']}, "
            f"{machine['date']}; the engines taking turns, medians of {repeats} runs. "
            "[Adapters](../benchmarks/peers/README.md).", "", *tables(found), machine["notes"], ""]


if __name__ == "__main__":
    print("\n".join(tables(read(sys.argv[1]))))
