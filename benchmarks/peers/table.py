#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Seven scenes in every measured engine, as Markdown: time, Tandem's time over it, result.

    python3 benchmarks/peers/table.py results/work_precision.csv
"""
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "work_precision"))

import results

# Columns for every scene with contacts: (measure, factor, name, unit; none for counts).
OVERLAP = [("penetration_mean_end", 1e3, "overlap", "mm"),
           ("penetration_max_run", 1e3, "largest", "mm")]
CONTACTS = OVERLAP + [("kinetic_max_last_second", 1.0, "energy left", "J")]
DRIFT = [("drift_end", 1e3, "drift", "mm")]
PILE = [("mean_z", 1.0, "mean height", "m"), ("touching_pairs", 1.0, "pairs", "")]
OUTCOMES = {
    "stacks": DRIFT + CONTACTS,
    "pyramid": DRIFT + CONTACTS,
    "ratio": [("top_error", 1e3, "top error", "mm")] + CONTACTS,
    "chain": [("separation_max", 1e3, "separation", "mm"), ("ball_error_max", 1.0, "ball error", "m"),
              ("energy_drift_max", 100.0, "energy drift", "%")],
    "cliff": OVERLAP + [("tunnelled", 1.0, "tunnelled", "")],
    "katamari": CONTACTS + PILE,
    "heap": CONTACTS + PILE,
}


def ratio_cell(ours, theirs):
    if not theirs:
        return "-"
    if theirs is ours:
        return f"{ours.time:.3g}"
    return f"{theirs.time:.3g} ({ours.time / theirs.time:.2g})"


def outcome(point):
    told = [f"{name} {point.error(measure, factor):{'.3g' if unit else '.0f'}} {unit}".rstrip()
            for measure, factor, name, unit in OUTCOMES[point.scene]]
    if point.value("fell") == 1.0:
        told.insert(0, "**falls**")
    return ", ".join(told)


def times(points):
    engines = [e for e in results.NAMES if results.select(points, e, setting="default")]
    lines = ["| scene | " + " | ".join(results.NAMES[e] for e in engines) + " |",
             "|---" * (len(engines) + 1) + "|"]
    for scene in OUTCOMES:
        ours = results.default_of(points, "tandem", scene)
        if ours:
            lines.append(f"| {scene} | " + " | ".join(
                ratio_cell(ours, results.default_of(points, e, scene)) for e in engines) + " |")
    return lines


def outcomes(points):
    lines = ["| scene | engine | outcome |", "|---|---|---|"]
    for scene in OUTCOMES:
        for engine, name in results.NAMES.items():
            point = results.default_of(points, engine, scene)
            if point:
                lines.append(f"| {scene} | {name} | {outcome(point)} |")
    return lines


def tables(points):
    return ["ms for a frame; in brackets Tandem's time over it, so that more than 1 means that Tandem is slower:", "",
            *times(points), "", "@csv outcomes Overlap, drift, energy and other outcomes, all engines",
            *outcomes(points)]


if __name__ == "__main__":
    print("\n".join(line for line in tables(results.read(sys.argv[1])) if not line.startswith("@csv")))
