#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Sessions over UDP between processes, through a bad network, beside the same in virtual time.

    benchmarks/network.py build/release/bin results            three seeds
    benchmarks/network.py build/release/bin results --report   from existing results

Writes network.csv, docs/network-measurements.md and the rows in its folder. Runs in wall time: other load changes the
result. Existing runs are kept; a run older than its program runs again.
"""
import argparse
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path.insert(0, str(HERE / "network"))

import section
import sessions


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binaries", type=Path, help="folder of the programs")
    parser.add_argument("out", type=Path, help="folder for the results")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--scenes", nargs="*", default=["cubes", "room"])
    parser.add_argument("--losses", type=float, nargs="*", default=[0.0, 0.05, 0.25])
    parser.add_argument("--profile", type=int, default=5)
    parser.add_argument("--jobs", type=int, default=2, help="sessions at once, two processes each")
    parser.add_argument("--report", action="store_true", help="run nothing")
    parser.add_argument("--note", default="", help="about the machine, for the document")
    parser.add_argument("--docs", type=Path, default=HERE.parent / "docs")
    args = parser.parse_args()

    cells = [sessions.Cell(scene, kind, args.profile, loss, seed)
             for seed in range(1, args.seeds + 1) for loss in args.losses for scene in args.scenes
             for kind in ("virtual", "udp")]
    if not args.report:
        sessions.run_all(cells, args.binaries, args.out, args.jobs)
    rows = [row for cell in cells for row in sessions.rows(cell, args.out)]
    section.write_csv(rows, args.out / "network.csv")
    section.write(rows, args.docs / "network-measurements.md", args.note)


if __name__ == "__main__":
    main()
