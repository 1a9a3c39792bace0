#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Writes docs/numerics.md and its figure from measured files.

    benchmarks/measure.sh build/release/bin results          measures, then runs this
    python3 benchmarks/numerics_report.py results            this alone

A section without files in the folder of results is kept.
"""
import argparse
import csv
import json
import shutil
import sys
import textwrap
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "work_precision"), str(HERE / "peers")]

import everyday.report as everyday
import joints
import must_hold
import pages
import results as runs
import table as peer_table

# Columns of the table of default settings: (measure, factor, heading).
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
SCENES = {
    "stacks": "ten stacks of ten cubes",
    "pyramid": "120 cubes",
    "ratio": "five cubes, each ten times as heavy as the one below",
    "chain": "50 links and a ball of 1000 times the mass of one",
    "cliff": "1000 balls over a step of 8192 triangles",
    "katamari": "900 cubes under one of 53 times their mass",
    "heap": "8000 boxes between walls",
}
FLOOR = 1e-6  # mm or m; smaller errors are not distinguished
# Measures without a better direction.
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
    """One line per case and measure, the engines beside each other."""
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


def errors(peers):
    """Each scene with its plotted measure: our point, the others', the measure, its factor and name."""
    for scene in SCENES:
        ours = runs.default_of(peers, "tandem", scene)
        others = [p for p in (runs.default_of(peers, e, scene) for e in runs.NAMES if e != "tandem") if p]
        if ours and others:
            measure, factor, what = runs.ERRORS[scene][0]
            yield ours, others, measure, factor, what


def finding_table(peers):
    lines = ["| scene | error | Tandem | the best other |", "|---|---|---|---|"]
    for ours, others, measure, factor, what in errors(peers):
        best = min(others, key=lambda p: p.error(measure))
        own = ours.error(measure, factor)
        lines.append(f"| {ours.scene} | {what} | {f'{own:.3g}' if own >= FLOOR else f'< {FLOOR:g}'} | "
                     f"{float(f'{best.error(measure, factor):.3g}'):g} ({runs.NAMES[best.engine]}) |")
    return lines


def time_lines(peers):
    """Tandem's time over that of each other engine."""
    out = []
    for engine, name in runs.NAMES.items():
        ratios = [ours.time / p.time for ours, others, *_ in errors(peers) for p in others if p.engine == engine]
        if ratios:
            out.append(f"{name} {min(ratios):.2g} to {max(ratios):.2g} (slower in {sum(r > 1 for r in ratios)})")
    return ", ".join(out)


def findings(peers, rows, bounds, results):
    scenes = list(errors(peers))
    least = sum(ours.error(m) <= min(p.error(m) for p in others) for ours, others, m, *_ in scenes)
    ours = [row for row in rows if row["engine"] == "tandem" and row["pass"] != "n/a"]
    held = sum(row["pass"] == "yes" for row in ours)
    kept = sum(not line.endswith("**no** |") for line in bounds[2:])
    names = "; ".join(f"*{scene}*, {what}" for scene, what in SCENES.items())
    return ["## Findings", "",
            f"Seven scenes, each engine at its default: {names}.", "", *finding_table(peers), "",
            f"- **Error**: Tandem's is the least in {least} of {len(scenes)} scenes.",
            f"- **Time**: Tandem's over theirs, in the best scene and in the worst: {time_lines(peers)}.",
            f"- **Bounds**: {held} of {len(ours)} lines of the [numerics set](#the-numerics-set) hold, and {kept} of "
            f"{len(bounds) - 2} of the [bounds](#what-must-hold) on these scenes.",
            *everyday.findings(results), *joints.findings(results),
            *(HERE / "data" / "findings.md").read_text().splitlines(), ""]


def worse_lines(points, rows, peers, bounds):
    """All measures but times in which Tandem is worse."""
    lines = []
    for scene in DEFAULTS:
        ours = runs.default_of(peers, "tandem", scene)
        others = [p for p in peers if ours and p.scene == scene and p.setting == "default" and p is not ours]
        for measure, factor, what, unit in peer_table.OUTCOMES[scene]:
            less = ", ".join(f"{p.error(measure, factor):.3g} in {runs.NAMES[p.engine]}" for p in others
                             if measure not in NEUTRAL and ours.error(measure) > p.error(measure))
            if less:
                lines.append(f"- {scene}, {what}, {unit}: {ours.error(measure, factor):.3g}; {less}.")
    by_line = {}
    for row in rows:
        by_line.setdefault((row["case"], row["measure"]), {})[row["engine"]] = row
    for (case, measure), found in by_line.items():
        ours, theirs = found.get("tandem"), found.get("bullet64")
        if not ours or ours["pass"] in ("yes", "n/a"):
            continue
        beside = f"; Bullet double: {short(theirs['value'])}" if theirs and \
            theirs["pass"] == "yes" else ""
        error = f", error {short(ours['error'])}" if ours["error"] != ours["value"] else ""
        lines.append(f"- {case}, {measure}, {ours['unit']}: {short(ours['value'])}{error}, the bound is "
                     f"{short(ours['bound'])}{beside}.")
    for line in bounds[2:]:
        what, measured, bound, holds = (cell.strip() for cell in line.strip("|").split(" | "))
        if holds != "yes":
            lines.append(f"- {what}: {measured}, the bound is {bound}.")
    return lines


def peer_lines(points, machine):
    """All engines beside each other. Their settings: benchmarks/peers/README.md."""
    versions = f"{machine['peers']}. " if "peers" in machine else ""
    heap = runs.default_of(points, "tandem", "heap")
    repeats = max(len(p.times) for p in points)
    return [f"{versions}One session on {machine['date']}, the engines taking turns, "
            f"{f'medians of {repeats} runs' if repeats > 1 else 'one run each'}"
            f"{f', {len(heap.times)} of the heap' if heap and repeats > 1 else ''}. "
            "The machine was in use: compare ratios, not times. [benchmarks/peers](../benchmarks/peers/README.md) "
            "has settings, builds and commands. A heap whose columns still stand (mean height) has fewer pairs to "
            "solve.", "",
            *peer_table.tables(points)]


def wrapped(lines):
    """Wraps paragraphs and list items at 120 columns; all else is kept."""
    text = ""
    for line in [*lines, ""]:
        ends = not line or line[0] in "|!#@" or line.startswith("- ")
        if ends and text:
            yield from textwrap.wrap(text, 120, break_long_words=False, break_on_hyphens=False,
                                     subsequent_indent="  " if text.startswith("- ") else "")
            text = ""
        if ends and not line.startswith("- "):
            yield line
        else:
            text = f"{text} {line.strip()}".lstrip()


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
    """The text before the first section, and the sections that compare engines over seven scenes."""
    points = runs.read(results / "work_precision.csv")
    rows = read_csv(results / "numerics.csv")
    machine = json.loads((results / "machine.json").read_text())
    # Measured here if the build has them, otherwise on the day of the last measurement.
    peers, peers_machine = points, machine
    if not any(p.engine in runs.PEERS for p in points):
        peers = runs.read(HERE / "data" / "peers.csv")
        peers_machine = json.loads((HERE / "data" / "peers.json").read_text())
    bounds = must_hold.table(points)
    out = ["# Numerics", "",
           "How exact Tandem is and what it costs beside Bullet, Jolt, Box3D and PhysX. "
           "`benchmarks/measure.sh` measures all of it and writes this page: run that instead of editing here.", "",
           *findings(peers, rows, bounds, results),
           "## Where Tandem is worse", "",
           "Its time, wherever a figure in brackets [below](#seven-scenes) is more than 1. Beyond that:", "",
           *worse_lines(points, rows, peers, bounds), "",
           "## Seven scenes", "",
           *machine_lines(machine), "",
           "Times are processor time of one thread for a frame of 1/60 s. No scene is tuned. Runs last 10 s, the "
           "chain's 5 s. Overlap is measured from the poses with sharp shapes, the same in all engines.", "",
           "![Error and time of seven engines](engines.svg)", "",
           *peer_lines(peers, peers_machine), "",
           "Error against run time, Tandem and Bullet over their ranges of substeps and iterations:", "",
           "![Error against run time](work_precision.svg)", "",
           "@csv at_the_default_settings Tandem and Bullet at their defaults: means, medians, outcomes",
           *default_lines(points), "",
           "## What must hold", "", *bounds, ""]
    return out, peers


def numerics_set(results):
    return ["## The numerics set", "",
            "`benchmarks/numerics`, at the default settings over 10 s, beside a closed form, a difference equation or "
            "a converged reference. \"no\" = outside the bound.", "",
            *numerics_lines(read_csv(results / "numerics.csv")), ""]


def kernels(results):
    return ["## Kernels", "", *kernel_lines(results / "kernels.json"), ""]


def time_section(_):
    """Measured with perf and by hand."""
    return ["## Where the time goes", "", (HERE / "data" / "time.md").read_text()]


COMPARED = ("", "## Findings", "## Where Tandem is worse", "## Seven scenes", "## What must hold")
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
    pages.write(page, "\n".join(wrapped("\n".join(out).splitlines())))
    print(f"wrote {page}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
