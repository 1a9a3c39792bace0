#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Error against run time: seven scenes in Tandem, both Bullets and the other engines of this build.

    python3 benchmarks/work_precision/run.py build/release/bin --out results          full, an hour
    python3 benchmarks/work_precision/run.py build/release/bin --quick --out quick    ten minutes
    python3 benchmarks/work_precision/run.py build/release/bin --joints --out joints  scenes of joints

Tandem and Bullet run over their settings, other engines at their defaults. Runs have their scene's length, 10 s, the
chain's 5 s: a falling heap costs a quarter of a settled one. Engines and settings take turns, so that a drift of the
machine's speed affects all. One thread. Writes work_precision.csv (joints.csv; one line per run), machine.json and,
with matplotlib, the plots.
"""
import argparse
import itertools
import json
import subprocess
import sys
import time
from pathlib import Path

import machine
import must_hold
import results

SMALL = ("stacks", "ratio", "pyramid", "chain")
LARGE = ("katamari", "cliff", "heap")
# Scenes of joints, only at the defaults, with sleep except for the grid, which Box3D's own benchmark keeps awake. A
# number at the end of a name is the size.
JOINTS = ("human", "rain", "wedge", "joint_grid", "ball_and_chain", "bridge", "crane", "doors")
LARGE_JOINTS = ("rain 20", "joint_grid 100")
REFERENCE = Path(__file__).resolve().parent.parent / "data" / "chain_reference.txt"

# (substeps, iterations); None = the engine's default, all None = the default row. The heap runs with two threads too.
DEFAULT = (None, None)
TWO_THREADS = "2 threads"
FULL = {
    "tandem": {"small": [(n, i) for n in (1, 2, 4, 8, 16, 32) for i in (1, 2, 4)],
               "large": [(1, 1), (2, 1), (4, 1), (8, 1), (2, 2), (4, 2)],
               "heap": [TWO_THREADS, (2, 1), (4, 1), (8, 1)]},
    "bullet": {"small": [(n, i) for n in (1, 2, 4, 8, 16, 32) for i in (3, 10, 40)],
               "large": [(1, 3), (1, 40), (2, 10), (4, 3), (4, 10)],
               "heap": [(1, 40), (2, 10)]},
}
QUICK = {
    "tandem": {"small": [(2, 1), (4, 1), (8, 1), (16, 1)], "large": [(4, 1)],
               "heap": [TWO_THREADS]},
    "bullet": {"small": [(1, 40), (4, 10)], "large": [(1, 40)], "heap": []},
}


def arguments_of(scene):
    if scene not in JOINTS + LARGE_JOINTS:
        return ["--scene", scene]
    name, *size = scene.split()
    words = ["--scene", name, *(["--size", *size] if size else [])]
    return words if name == "joint_grid" else [*words, "--sleeping"]


def settings_of(engine, scene, quick):
    if engine in results.PEERS or scene in JOINTS + LARGE_JOINTS:
        return [DEFAULT]
    table = (QUICK if quick else FULL)["tandem" if engine == "tandem" else "bullet"]
    kind = scene if scene == "heap" else "large" if scene in LARGE else "small"
    return [DEFAULT] + table[kind]


def label(setting):
    if setting in (DEFAULT, TWO_THREADS):
        return "default" if setting == DEFAULT else setting
    return f"{setting[0]}x{setting[1]}"


def run(binaries, engine, scene, setting, extra, limit):
    command = [str(binaries / f"work_precision_{engine}"), *arguments_of(scene), "--json", *extra]
    if setting == TWO_THREADS:
        command += ["--threads", "2"]
    else:
        for option, value in zip(("--substeps", "--iterations"), setting):
            if value is not None:
                command += [option, str(value)]
    if scene == "chain":
        command += ["--reference", str(REFERENCE)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=limit)
    except subprocess.TimeoutExpired:
        print(f"  {engine} {scene} {label(setting)}: longer than {limit:g} s, left out")
        return None
    if done.returncode != 0:
        print(f"  {engine} {scene} {label(setting)}: {done.stderr.strip()}")
        return None
    found = json.loads(done.stdout)
    return {"engine": engine, "scene": scene, "setting": label(setting),
            **{k: "" if v is None else v for k, v in found.items()
               if k not in ("engine", "scene")}}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binaries", type=Path, help="folder of the programs work_precision_*")
    parser.add_argument("--out", type=Path, required=True, help="folder for CSV and plots")
    parser.add_argument("--quick", action="store_true", help="ten minutes: fewer settings")
    parser.add_argument("--repeats", type=int, help="3 by default, 1 with --quick")
    parser.add_argument("--scenes", nargs="*", default=[*SMALL, *LARGE],
                        choices=[*SMALL, *LARGE, *JOINTS, *LARGE_JOINTS])
    parser.add_argument("--joints", action="store_true", help="the scenes of joints instead of those")
    parser.add_argument("--engines", nargs="*", default=list(results.NAMES),
                        choices=list(results.NAMES))
    parser.add_argument("--defaults-only", action="store_true", help="no other setting")
    parser.add_argument("--limit", type=float, default=900, help="s, at most for one run")
    parser.add_argument("--extra", nargs="*", default=[], help="passed on to Tandem's program")
    args = parser.parse_args()
    repeats = args.repeats or (1 if args.quick else 3)
    if args.joints:
        args.scenes = [*JOINTS, *LARGE_JOINTS]
    engines = [e for e in args.engines if (args.binaries / f"work_precision_{e}").exists()]
    file = "joints.csv" if args.joints else "work_precision.csv"
    args.out.mkdir(parents=True, exist_ok=True)

    rows = []
    begin = time.monotonic()
    for scene in args.scenes:
        per_engine = [[(e, s) for s in settings_of(e, scene, args.quick)
                       if not args.defaults_only or s == DEFAULT] for e in engines]
        cells = [c for turn in itertools.zip_longest(*per_engine) for c in turn if c]
        for repeat in range(repeats):
            for engine, setting in cells:
                row = run(args.binaries, engine, scene, setting,
                          args.extra if engine == "tandem" else [], args.limit)
                if row:
                    rows.append({**row, "repeat": repeat})
        results.write(args.out / file, rows)
        print(f"{scene}: {len(cells)} settings, {time.monotonic() - begin:.0f} s since the start",
              flush=True)
    (args.out / "machine.json").write_text(json.dumps(machine.describe(args.binaries), indent=2))
    if args.joints:
        return 0

    points = results.read(args.out / file)
    print()
    print("\n".join(must_hold.table(points)))
    try:
        import plot
    except ImportError:
        print("no matplotlib in this Python, so no plots: see plot.py")
        return 0
    for path in plot.draw(points, args.out):
        print(f"wrote {path.name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
