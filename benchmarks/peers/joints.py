#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The section of docs/numerics.md on scenes of joints, from the output of `run.py --joints`.

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
`benchmarks/scenes/joint_scenes.cpp` has Box3D's benchmarks and samples of joints at their published sizes (rain, human,
joint_grid, ball_and_chain; the jointed parts of bridge and doors), and more that games build
([differences](../benchmarks/peers/README.md#what-they-run-with)). Friction is 0.5, gravity 9.81 m/s^2, a frame 1/60 s.
One thread, 10 s (rain 6 s, joint_grid 5 s). Engines run at their defaults without damping. Bodies may sleep, except in
joint_grid, as in Box3D's own: limbs below 0.03 m/s and 0.3 rad/s in Tandem, bodies below 0.03 m/s in Jolt and 0.05 m/s
in Box3D. Times are of frames in which something was awake. The adapters of Bullet and PhysX lack such joints."""


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


def two(value):
    """Two digits, without an exponent if readable."""
    return f"{float(f'{value:.2g}'):g}"


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


# Name, title, contents of a cell.
TABLES = (
    ("joints_time", "Processor time of a frame, ms: median (Tandem's over it); 99 %; largest:", time),
    ("joints_steadiness", "First frame over median; frames above four medians, from the third; most substeps:",
     steadiness),
    ("joints_gap", "Distance of a joint's anchors, mm: median; 99 %; largest, over joints and frames:",
     separation),
    ("joints_energy", "Energy, kJ: start to end; largest rise in one frame (motors: bridge, crane, doors):", energy),
    ("joints_rest", "Bodies asleep at the end (all: since which frame); the lowest body then, m:", rest),
)


def scenes_of(found):
    return [scene for scene in WHAT if "tandem" in found.get(scene, {})]


def engines_of(found):
    return [e for e in runs.NAMES if any(e in scene for scene in found.values())]


def tables(found, beside=False):
    """@param beside  as files beside the page"""
    out = []
    for name, title, cell in TABLES:
        engines = engines_of(found)
        out += [*([f"@csv {name} {title.rstrip(':')}"] if beside else [title, ""]),
                "| scene | bodies, joints | " + " | ".join(runs.NAMES[e] for e in engines) + " |",
                "|---" * (len(engines) + 2) + "|"]
        for scene in scenes_of(found):
            ours = found[scene]["tandem"]
            size = f"{median(ours, 'bodies'):.0f}, {median(ours, 'joints'):.0f}"
            cells = [cell(found[scene][e], ours) if e in found[scene] else "-" for e in engines]
            out.append(f"| {scene} | {size} | {' | '.join(cells)} |")
        out += [] if beside else [""]
    return [*out, ""] if beside else out


def ratio(found, scene, engine, measure):
    return median(found[scene]["tandem"], measure) / median(found[scene][engine], measure)


def overview(found):
    """Time and gaps in one table."""
    others = [e for e in engines_of(found) if e != "tandem"]
    lines = ["| scene | Tandem, ms | " + " | ".join(f"over {runs.NAMES[e]}" for e in others) + " | gap, mm: Tandem | "
             + " | ".join(runs.NAMES[e] for e in others) + " |", "|---" * (3 + 2 * len(others)) + "|"]
    for scene in scenes_of(found):
        times = [f"{ratio(found, scene, e, 'cpu_ms_p50'):.2g}" for e in others]
        gaps = [two(1e3 * median(found[scene][e], "separation_p99")) for e in ("tandem", *others)]
        lines.append(f"| {scene} | {short(median(found[scene]['tandem'], 'cpu_ms_p50'))} | "
                     f"{' | '.join(times + gaps)} |")
    return lines


def folder_of(results):
    """Today's runs, otherwise the stored ones."""
    return results if (results / "joints.csv").exists() else DATA


def findings(results):
    """@return lines of Markdown"""
    found = read(folder_of(results) / "joints.csv")
    times = []
    for engine in engines_of(found):
        ratios = [ratio(found, scene, engine, "cpu_ms_p50") for scene in scenes_of(found)]
        if engine != "tandem":
            times.append(f"{min(ratios):.2g} to {max(ratios):.2g} times as long as {runs.NAMES[engine]}")
    gaps = [[1e3 * median(found[scene][e], "separation_p99") for scene in scenes_of(found)]
            for e in engines_of(found)]
    widest = ", ".join(f"{two(max(gap))} mm in {runs.NAMES[e]}" for e, gap in zip(engines_of(found), gaps))
    return [f"- **[Scenes of joints](#scenes-of-joints)**: Tandem takes {' and '.join(times)}. In the worst scene 99 % "
            f"of the joints' gaps are below {widest}."]


def section(results):
    """@param results  folder with joints.csv if the scenes were run
    @return lines of Markdown"""
    found = read(folder_of(results) / "joints.csv")
    machine = json.loads((DATA / "joints.json").read_text())
    repeats = max(len(rows) for scene in found.values() for rows in scene.values())
    names = "; ".join(f"*{scene}*, {what}" for scene, what in WHAT.items() if scene in found)
    return [HEADING, "", f"{names}.", "", INTRODUCTION, "",
            f"{machine['peers']}; {machine['processor']}, {machine['cores']} cores, {machine['load']}, "
            f"{machine['date']}; the engines taking turns, medians of {repeats} runs. "
            "[Adapters](../benchmarks/peers/README.md).", "",
            "Median time of a frame, Tandem's over the other engine's, and the gap between a joint's two anchors below "
            "which 99 % of joints and frames are:", "", *overview(found), "", machine["notes"], "",
            "By scene and engine:", "", *tables(found, beside=True)]


if __name__ == "__main__":
    print("\n".join(tables(read(sys.argv[1]))))
