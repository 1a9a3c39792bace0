#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Writes docs/numerics.md and its figure from measured files.

    benchmarks/measure.sh build/release/bin results          measures, then runs this
    python3 benchmarks/numerics_report.py results            this alone

Where the folder of results lacks the files of a section, the page keeps what it has of it.
"""
import argparse
import csv
import json
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "work_precision"), str(HERE / "peers")]

import everyday.report as everyday
import joints
import must_hold
import pages
import results as runs
import table as peer_table

# What the table of default settings shows: (measure, factor, heading).
DEFAULTS = {
    "stacks": [("drift_end", 1e3, "drift, mm"), ("penetration_mean_end", 1e3, "overlap, mm")],
    "chain": [("separation_max", 1e3, "separation, mm"), ("ball_error_max", 1, "ball error, m"),
              ("energy_drift_max", 100, "energy drift, %")],
    "ratio": [("top_error", 1e3, "top error, mm")],
    "pyramid": [("drift_end", 1e3, "drift, mm"), ("penetration_mean_end", 1e3, "overlap, mm")],
    "katamari": [("penetration_mean_end", 1e3, "overlap, mm"),
                 ("penetration_max_run", 1e3, "largest, mm")],
    "cliff": [("penetration_mean_end", 1e3, "overlap, mm"),
              ("penetration_max_run", 1e3, "largest, mm"), ("tunnelled", 1, "tunnelled")],
    "heap": [("penetration_mean_end", 1e3, "overlap, mm"), ("mean_z", 1, "mean height, m"),
             ("touching_pairs", 1, "pairs")],
}
# Neither more nor less of these is better.
NEUTRAL = ("mean_z", "touching_pairs")


def short(text):
    try:
        return f"{float(text):.4g}"
    except ValueError:
        return text or "-"


def machine_lines(machine):
    return [f"{machine['processor']}, {machine['cores']} cores (shared), {machine['system']}, "
            f"{machine['compiler']}, `{machine['flags']}`, Bullet {machine['bullet']} as Debian "
            f"builds it, {machine['date']}."]


def default_lines(points):
    lines = ["| scene | engine | ms, mean over frames | ms, median | outcome |", "|---|---|---|---|---|"]
    for scene, measures in DEFAULTS.items():
        for engine, name in runs.ENGINES.items():
            p = runs.default_of(points, engine, scene)
            if not p:
                continue
            outcome = ", ".join(f"{heading.split(',')[0]} {p.error(m, f):.3g}"
                                f"{' ' + heading.split(', ')[1] if ', ' in heading else ''}"
                                for m, f, heading in measures)
            lines.append(f"| {scene} | {name} | {p.time:.3g} ({p.times[0]:.3g} to {p.times[-1]:.3g})"
                         f" | {p.median_time:.3g} | {outcome} |")
    return lines


def read_csv(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def numerics_lines(rows):
    """One line for each case and measure, the engines beside each other."""
    table = {}
    missing = {}
    for row in rows:
        if row["pass"] == "n/a":
            missing[(row["engine"], row["case"])] = row["source"]
        else:
            table.setdefault((row["case"], row["measure"]), {})[row["engine"]] = row
    lines = ["| case | measure | bound on the error | Tandem | Bullet double | reference | source |",
             "|---|---|---|---|---|---|---|"]

    def cell(found, engine, case):
        row = found.get(engine)
        if not row:
            return "not built" if (engine, case) in missing else "-"
        mark = "" if row["pass"] == "yes" else " **no**"
        return f"{short(row['value'])}{mark}"

    last = None
    for (case, measure), found in table.items():
        row = next(iter(found.values()))
        unit = "" if row["unit"] in ("", "relative") else " " + row["unit"]
        bound = f"{100 * float(row['bound']):g} %" if row["unit"] == "relative" and \
            float(row["bound"]) >= 1e-4 else short(row["bound"]) + unit
        lines.append(f"| {case if case != last else ''} | {measure} | {bound} | "
                     f"{cell(found, 'tandem', case)} | {cell(found, 'bullet64', case)} | "
                     f"{short(row['reference'])} | {row['source']} |")
        last = case
    return lines


def worse_lines(points, rows, peers):
    """Everything in these files at which Tandem comes off worse."""
    lines = []
    for scene, measures in DEFAULTS.items():
        ours = runs.default_of(points, "tandem", scene)
        for engine in ("bullet64", "bullet32"):
            theirs = runs.default_of(points, engine, scene)
            if not ours or not theirs:
                continue
            if ours.time > theirs.time:
                lines.append(f"- {scene}: {runs.ENGINES[engine]} at its default needs "
                             f"{theirs.time:.3g} ms, Tandem {ours.time:.3g} ms.")
            for measure, factor, heading in measures:
                if measure not in NEUTRAL and ours.error(measure) > theirs.error(measure):
                    lines.append(f"- {scene}: {heading}: {runs.ENGINES[engine]} "
                                 f"{theirs.error(measure, factor):.3g}, Tandem "
                                 f"{ours.error(measure, factor):.3g}.")
        ours = runs.default_of(peers, "tandem", scene)
        for engine, name in runs.PEERS.items():
            theirs = runs.default_of(peers, engine, scene)
            if not ours or not theirs:
                continue
            if ours.time > theirs.time:
                falls = ", and falls" if theirs.value("fell") == 1.0 else ""
                lines.append(f"- {scene}: {name} needs {theirs.time:.3g} ms{falls}; Tandem beside it "
                             f"{ours.time:.3g} ms.")
            for measure, factor, what, unit in peer_table.OUTCOMES[scene]:
                if measure not in NEUTRAL and ours.error(measure) > theirs.error(measure):
                    lines.append(f"- {scene}: {what}: {name} {theirs.error(measure, factor):.3g} {unit}, "
                                 f"Tandem {ours.error(measure, factor):.3g} {unit}.")
    by_line = {}
    for row in rows:
        by_line.setdefault((row["case"], row["measure"]), {})[row["engine"]] = row
    for (case, measure), found in by_line.items():
        ours, theirs = found.get("tandem"), found.get("bullet64")
        if not ours or ours["pass"] in ("yes", "n/a"):
            continue
        beside = f"; Bullet double: {short(theirs['value'])}" if theirs and \
            theirs["pass"] == "yes" else ""
        lines.append(f"- {case}, {measure}: {short(ours['value'])}, error {short(ours['error'])}, "
                     f"the bound is {short(ours['bound'])} {ours['unit']}{beside}.")
    return lines or ["Nowhere in what was measured here."]


def peer_lines(points, machine):
    """All engines beside each other. What each of them runs with: benchmarks/peers/README.md."""
    versions = f"{machine['peers']}. " if "peers" in machine else ""
    heap = runs.default_of(points, "tandem", "heap")
    repeats = max(len(p.times) for p in points)
    return [f"{versions}All in one session on {machine['date']}, the engines taking turns, each at its "
            f"default, as long as above, medians of {repeats} runs"
            f"{f', {len(heap.times)} of the heap' if heap else ''}. The machine was in use: ratios "
            "count, times do not. What each engine runs with, how it is built and how to repeat this: "
            "[benchmarks/peers](../benchmarks/peers/README.md). A heap whose columns still stand has "
            "fewer pairs to solve: its mean height says so.", "",
            "![Error and time of seven engines](engines.svg)", "",
            *peer_table.tables(points)]


def kernel_lines(path):
    lines = ["| kernel | ns | for one |", "|---|---|---|"]
    for b in json.loads(path.read_text())["benchmarks"]:
        for counter, what in (("pair_time", "pair"), ("row_time", "row and substep"),
                              ("body_time", "body and step")):
            if counter in b:
                lines.append(f"| {b['name']} | {1e9 * b[counter]:.4g} | {what} |")
                break
        else:
            lines.append(f"| {b['name']} | {b['cpu_time']:.4g} | call |")
    return lines


def compared(results):
    """What stands before the first section, and the sections that compare engines over seven scenes."""
    points = runs.read(results / "work_precision.csv")
    rows = read_csv(results / "numerics.csv")
    machine = json.loads((results / "machine.json").read_text())
    # Measured here where the build had them, else on the day when they were measured last.
    peers, peers_machine = points, machine
    if not any(p.engine in runs.PEERS for p in points):
        peers = runs.read(HERE / "data" / "peers.csv")
        peers_machine = json.loads((HERE / "data" / "peers.json").read_text())
    out = ["# Numerics", "",
           "Written by `benchmarks/measure.sh` from what it measured: run that again instead of "
           "editing here.", "", *machine_lines(machine), "",
           "Times are processor time of one thread for a frame of 1/60 s. Times on this machine "
           "vary with what else it does: compare within this page only. Each engine is at its "
           "default setting unless said; no scene is tuned.", "",
           "## What must hold", "", *must_hold.table(points), "",
           "## Error against run time", "",
           "Seven scenes, the engines taking turns, each over its range of substeps and iterations. "
           "Overlap is measured from the poses with the sharp shapes, the same for all engines. All "
           "runs on this page last 10 s, the chain's 5 s.", "",
           "![Error against run time](work_precision.svg)", "",
           "At the default settings; in brackets the spread over the repeats:", "",
           *default_lines(points), "",
           "## Beside Jolt, Box3D and PhysX", "", *peer_lines(peers, peers_machine), "",
           "## Where Tandem is worse", "", *worse_lines(points, rows, peers), ""]
    return out, peers


def numerics_set(results):
    return ["## The numerics set", "",
            "`benchmarks/numerics`, at the default settings over 10 s. \"no\" = outside the bound.", "",
            *numerics_lines(read_csv(results / "numerics.csv")), ""]


def kernels(results):
    return ["## Kernels", "", *kernel_lines(results / "kernels.json"), ""]


def time_section(_):
    """Measured with perf and by hand."""
    return ["## Where the time goes", "", (HERE / "data" / "time.md").read_text()]


COMPARED = ("", "## What must hold", "## Error against run time", "## Beside Jolt, Box3D and PhysX",
            "## Where Tandem is worse")
# The other sections in the page's order.
SECTIONS = {"## The numerics set": numerics_set, everyday.HEADING: everyday.section,
            joints.HEADING: joints.section, "## Kernels": kernels, "## Where the time goes": time_section}


def draw(peers, results, docs):
    figure = results / "work_precision.svg"
    if figure.exists():
        shutil.copyfile(figure, docs / "work_precision.svg")
    try:
        import chart
    except ImportError:
        print("no matplotlib in this Python, so engines.svg is as it was: see peers/chart.py")
    else:
        chart.draw(peers, docs)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("results", type=Path)
    parser.add_argument("--docs", type=Path, default=HERE.parent / "docs")
    args = parser.parse_args()
    page = args.docs / "numerics.md"
    before = pages.sections(page)

    def kept(heading):
        print(f"not measured, as it was: {heading or 'head of the page'}")
        return [*before.get(heading, "").rstrip("\n").split("\n"), ""]

    try:
        out, peers = compared(args.results)
    except FileNotFoundError:
        out = [line for heading in COMPARED for line in kept(heading)]
    else:
        draw(peers, args.results, args.docs)
    for heading, section in SECTIONS.items():
        try:
            out += section(args.results)
        except FileNotFoundError:
            out += kept(heading)
    pages.write(page, "\n".join(out))
    print(f"wrote {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
