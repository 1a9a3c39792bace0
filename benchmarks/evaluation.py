#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Runs the five scenarios over networks and seeds, and writes docs/evaluation.md.

    benchmarks/evaluation.py build/release/bin results            everything
    benchmarks/evaluation.py build/release/bin results --quick    two seeds
    benchmarks/evaluation.py build/release/bin results --report   from existing results
    benchmarks/evaluation.py build/release/bin results --recorded   only the section on recorded hands

Writes tables and figures too, with the long tables beside the page. Finished cells are kept, so that an interrupted
matrix continues; a cell older than its program runs again.
"""
import argparse
import os
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE / "evaluation")]

try:
    import matplotlib, scour  # noqa: E401, F401
except ImportError:
    # Another Python of this machine may have matplotlib.
    if sys.executable != "/usr/bin/python3" and Path("/usr/bin/python3").exists():
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])

import cells
import recorded


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binaries", type=Path, help="folder of the programs")
    parser.add_argument("out", type=Path, help="folder for the results")
    parser.add_argument("--quick", action="store_true", help="two seeds, shorter cliff")
    parser.add_argument("--seeds", type=int, help="how many (5, quick 2)")
    parser.add_argument("--first-seed", type=int, default=1, help="the others follow (1)")
    parser.add_argument("--profiles", type=int, nargs="*", default=[1, 2, 3, 4, 5])
    parser.add_argument("--scenarios", nargs="*", default=list(cells.SECONDS),
                        choices=list(cells.SECONDS))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--report", action="store_true", help="run nothing")
    parser.add_argument("--recorded", action="store_true",
                        help="recorded hands and what they are set beside, and that section alone")
    parser.add_argument("--note", default="", help="which code and machine were measured, for the head of the page")
    parser.add_argument("--docs", type=Path, default=HERE.parent / "docs")
    args = parser.parse_args()

    seeds = args.seeds or (2 if args.quick else 5)
    if args.recorded:
        matrix = cells.recorded(args.scenarios, args.profiles, args.first_seed, seeds)
    else:
        matrix = cells.matrix(args.scenarios, args.profiles, args.first_seed, seeds, args.quick)
    if not args.report:
        cells.run_all(matrix, args.binaries, args.out, args.jobs)
    if args.recorded:
        recorded.write(cells.load(matrix, args.out), args.docs)
        return
    import page  # draws
    page.write(cells.load(matrix, args.out), args.out, args.docs, args.note)


if __name__ == "__main__":
    main()
