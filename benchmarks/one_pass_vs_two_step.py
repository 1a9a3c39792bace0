#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""One pass against two steps: measures every section and writes docs/one-pass-vs-two-step.md.

    benchmarks/one_pass_vs_two_step.py build/release/bin results            everything
    benchmarks/one_pass_vs_two_step.py build/release/bin results --quick    two seeds, fewer cells
    benchmarks/one_pass_vs_two_step.py build/release/bin results --report   from existing results
    benchmarks/one_pass_vs_two_step.py build/release/bin results --sections couplings stability

A section is a module with two functions: measure(binaries, results, seeds, jobs, quick) writes tables into the folder
of results; report(results, docs) returns text and writes long tables as CSV beside the page. The first paragraph is the
section's finding, shown at the page's head. A section without results is kept.
"""
import argparse
import importlib
import re
import sys
import time
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.dont_write_bytecode = True
sys.path[:0] = [str(HERE), str(HERE / "one_pass_vs_two_step"), str(HERE / "evaluation")]
SECTIONS = {"couplings": "## The couplings", "pareto": "## Error against run time",
            "stability": "## Which shares are stable at which delay",
            "extreme": "## Stiff and extreme, with two and more peers",
            "ablation": "## What each part is worth"}

import pages

HEAD = """# One pass against two steps

This page measures what each choice in [the method](method.md) is worth. *One pass* puts the agreed target into the \
solver's pass, among contacts and joints. *Two steps* averages states before the step, as [friston] published it; \
contacts and joints answer afterwards.

Two peers unless said, on virtual links with the profiles of [friston] Table 3: 3.5, 6, 28.5, 63.5 and 123.5 ms one \
way at profiles 1 to 5. All schemes get the same scenes, links, seeds and recorded inputs. Figures are means over \
seeds, intervals are of 95 %. Differences below 0.1 mm count as equal. Compare processor times within one table only. \
`benchmarks/one_pass_vs_two_step.py build/release/bin RESULTS` writes this page: edit the program.
"""
STATE = "**State.**"  # begins the paragraph on the measured code


def anchor(heading):
    return re.sub(r"[^a-z0-9 -]", "", heading.removeprefix("## ").lower()).replace(" ", "-")


def lifted(text):
    """A section's finding, as a line of the list at the head, and the section without it."""
    heading, finding, rest = text.split("\n\n", 2)
    return (f"- [{heading.removeprefix('## ')}](#{anchor(heading)}). {finding}",
            f"{heading}\n\n{rest.strip()}\n")


def findings_before(page):
    """The present list at the head of the page, by the section of each line."""
    found = {}
    for line in re.split(r"^(?=- )", page.get("## Findings", ""), flags=re.MULTILINE)[1:]:
        if link := re.search(r"\]\(#([^)]*)\)", line):
            found[link[1]] = line.strip()
    return found


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
    parser.add_argument("--note", help="which code was measured, for the head of the page; where sections "
                        "are kept, so is the note")
    parser.add_argument("--docs", type=Path, default=HERE.parent / "docs")
    args = parser.parse_args()

    importlib.import_module("demo_runs").first_seed = args.first_seed
    args.out.mkdir(parents=True, exist_ok=True)
    page = args.docs / "one-pass-vs-two-step.md"
    before = pages.sections(page)
    state = re.search(rf"^{re.escape(STATE)}.*?(?=\n\n|\Z)", before[""], flags=re.MULTILINE | re.DOTALL)
    list_before, kept = findings_before(before), False
    findings, texts = [], []
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
            finding, text = lifted(text)
            findings.append(finding)
            texts.append(text)
        elif heading in before:
            kept = True
            findings.append(list_before.get(anchor(heading), ""))
            texts.append(before[heading].rstrip() + "\n")
        else:
            print(f"{name}: not measured yet", file=sys.stderr)
    note = f"{STATE} {args.note}\n" if args.note else state[0] + "\n" if kept and state else ""
    head = [HEAD, *([note] if note else []), "## Findings\n", "\n".join(f for f in findings if f) + "\n"]
    pages.write(page, pages.wrapped("\n".join([*head, *texts])))


if __name__ == "__main__":
    main()
