#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""One pass against two steps: measures every section and writes docs/one-pass-vs-two-step.md.

    benchmarks/one_pass_vs_two_step.py build/release/bin results            everything
    benchmarks/one_pass_vs_two_step.py build/release/bin results --quick    two seeds, fewer cells
    benchmarks/one_pass_vs_two_step.py build/release/bin results --report   from what is there
    benchmarks/one_pass_vs_two_step.py build/release/bin results --sections couplings stability

A section is a module in one_pass_vs_two_step/ with two functions: measure(binaries, results, seeds,
jobs, quick) writes tables into the folder of results, report(results, docs) turns them into a
section of text and draws its figures beside it. Where the folder has no results of a section, the page
keeps what it has of it.
"""
import argparse
import importlib
import os
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE / "one_pass_vs_two_step"), str(HERE / "evaluation")]
SECTIONS = {"couplings": "## The couplings", "pareto": "## Error against run time",
            "stability": "## Which shares are stable at which delay",
            "extreme": "## Stiff and extreme, with two and more peers", "influence": "## Influence",
            "predictors": "## Which prediction with which share",
            "ablation": "## What each part is worth"}

import pages

try:
    import matplotlib, scour  # noqa: E401, F401
except ImportError:
    # Another Python of this machine may be able to draw.
    if sys.executable != "/usr/bin/python3" and Path("/usr/bin/python3").exists():
        os.execv("/usr/bin/python3", ["/usr/bin/python3", *sys.argv])

HEAD = """# One pass against two steps

Written by `benchmarks/one_pass_vs_two_step.py` from what it measured: run that again instead of editing here.
"""


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binaries", type=Path, help="folder of the programs")
    parser.add_argument("out", type=Path, help="folder for the results")
    parser.add_argument("--quick", action="store_true", help="two seeds, fewer cells")
    parser.add_argument("--seeds", type=int, help="how many (5, quick 2)")
    parser.add_argument("--first-seed", type=int, default=1, help="the others follow (1)")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--sections", nargs="*", default=list(SECTIONS), choices=SECTIONS,
                        help="what to measure; all are reported")
    parser.add_argument("--report", action="store_true", help="run nothing")
    parser.add_argument("--docs", type=Path, default=HERE.parent / "docs")
    args = parser.parse_args()

    importlib.import_module("demo_runs").first_seed = args.first_seed
    args.out.mkdir(parents=True, exist_ok=True)
    page = args.docs / "one-pass-vs-two-step.md"
    texts, before = [HEAD], pages.sections(page)
    for name, heading in SECTIONS.items():
        section = importlib.import_module(name)
        if not args.report and name in args.sections:
            begun = time.monotonic()
            section.measure(args.binaries, args.out, args.seeds or (2 if args.quick else 5),
                            args.jobs, args.quick)
            print(f"{name}: {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)
        try:
            text = section.report(args.out, args.docs)
        except FileNotFoundError:
            text = ""
        if text and "Not measured." not in text:
            texts.append(text.rstrip() + "\n")
        elif heading in before:
            # The page begins with what the couplings show.
            kept = ["## Findings", heading] if name == "couplings" else [heading]
            texts += [before[h].rstrip() + "\n" for h in kept if h in before]
        else:
            print(f"{name}: not measured yet", file=sys.stderr)
    pages.write(page, "\n".join(texts))


if __name__ == "__main__":
    main()
