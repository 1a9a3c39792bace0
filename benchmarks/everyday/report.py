# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The section on everyday scenes of docs/numerics.md, from what `everyday --json` wrote."""
import json
from pathlib import Path

import results as runs

DATA = Path(__file__).resolve().parent.parent / "data"
HEADING = "## Everyday scenes"
# Topic of a kind, by its number.
KINDS = {
    "E1": "seams of tiles",
    "E2": "hulls of random points",
    "E3": "bumpy cubes; scanned tins, parcels",
    "E4": "rods, pencils, dowels",
    "E5": "hinges and anchors at the start",
    "E7": "columns of small things",
    "E8": "bats, plates, swords",
    "E9": "uneven steps",
    "E10": "house of cards of 1 cm",
    "E12": "loads that swing on a rope",
    "E14": "what is left alone",
}
ENGINES = runs.NAMES
INTRODUCTION = """\
`benchmarks/everyday` runs small scenes that users of any engine build, over many neighbours (shapes, sizes, speeds,
phases within a step, grounds), at the default settings. A line is the worst of its cases beside what physics allows.
`--cases` prints each case beyond its bound; `known.cpp` gives reasons. `everyday_test` runs a few, `.ci/run everyday`
all."""
# Counterparts of the scenes in other engines.
BESIDE = """\
`--engine` runs them in [another engine](../benchmarks/peers/README.md#what-they-run-with), at its defaults but without
damping. A dash: its adapter lacks such a body (cones, compounds, height fields, kinematic bodies), or only Tandem was
run. No body is marked as fast (bullet, linear cast). Jolt and Box3D limit spin to 47 rad/s. Jolt lets bodies sink by
20 mm, which counts as a hop and as depth. Its bodies fall asleep by the distance they moved, not by speed."""


def number(value):
    # The program writes 1e300 where the value is infinite: JSON has no infinity.
    return "infinite" if value >= 1e300 else f"{value:.3g}"


def value(line):
    if line["unit"] == "cases":
        return f"{number(line['worst'])} of {line['cases']}"
    return f"{number(line['worst'])} {line['unit']}"


def holds(line):
    return line["holds"] == "ok"


def beyond(lines):
    """Of each measure the line that is furthest beyond its bound."""
    worst = {}
    for line in lines:
        share = line["worst"] / line["bound"] if line["bound"] > 0.0 else line["worst"]
        if not holds(line) and share > worst.get(line["measure"], (0.0,))[0]:
            worst[line["measure"]] = (share, line)
    return "; ".join(f"{measure}: {value(line)} ({number(line['bound'])}; {line['name']}, {line['ground']})"
                     for measure, (_, line) in worst.items())


def key(line):
    return line["kind"], line["name"], line["ground"], line["measure"]


def read(path):
    return {key(line): line for line in json.loads(path.read_text())}


def peers(results):
    """Lines of each other engine: those of this run, else those that were measured last."""
    found = {}
    for engine in ENGINES:
        files = [folder / f"everyday_{engine}.json" for folder in (results, DATA)]
        file = next((file for file in files if file.exists()), None)
        if file:
            found[engine] = read(file)
    return found


def findings(results):
    """@return lines of Markdown: how many lines hold in each engine, none where nothing was measured"""
    if not (results / "everyday.json").exists():
        return []
    lines = list(read(results / "everyday.json").values())
    beside = ", ".join(f"{sum(not holds(line) for line in other.values())} of {len(other)} in {ENGINES[engine]}"
                       for engine, other in peers(results).items())
    return [f"- **[Everyday scenes](#everyday-scenes)**: {sum(not holds(line) for line in lines)} of {len(lines)} "
            f"lines do not hold{f'; {beside} do not, where they can be run' if beside else ''}."]


def overview(lines, others):
    names = "".join(f" {ENGINES[engine]} |" for engine in others)
    out = [f"| kind | lines | Tandem |{names}", f"|---|---|---|{'---|' * len(others)}"]
    worst = []
    for kind in dict.fromkeys(line["kind"] for line in lines):
        own = [line for line in lines if line["kind"] == kind]
        cells = []
        for other in others.values():
            theirs = [line for line in other.values() if line["kind"] == kind]
            cells.append(f"{sum(not holds(line) for line in theirs)} of {len(theirs)}" if theirs else "-")
        cells = [f"{sum(not holds(line) for line in own)}", *cells]
        out.append(f"| {kind} {KINDS.get(kind, '')} | {len(own)} | {' | '.join(cells)} |")
        worst += [f"- {kind}: {beyond(own)}."] if beyond(own) else []
    return [*out, "", "Tandem's worst of each measure (bound; where):", "", *worst]


def table(lines, others):
    names = "".join(f" {ENGINES[engine]} |" for engine in others)
    out = [f"| kind | what | ground | measure | bound | Tandem |{names} Tandem holds |",
           f"|---|---|---|---|---|---|{'---|' * len(others)}---|"]
    for line in lines:
        bound = number(line["bound"]) + ("" if line["unit"] == "cases" else " " + line["unit"])
        cells = [line["kind"], line["name"], line["ground"], line["measure"], bound, value(line)]
        cells += [value(other[key(line)]) if key(line) in other else "-" for other in others.values()]
        out.append(f"| {' | '.join(cells)} | {'yes' if holds(line) else 'no'} |")
    return out


def section(results):
    """@param results  folder that has everyday.json, and everyday_ENGINE.json of others
    @return lines of Markdown"""
    lines = list(read(results / "everyday.json").values())
    others = peers(results)
    return [HEADING, "", INTRODUCTION, "", *([BESIDE, ""] if others else []),
            "Lines that do not hold:", "", *overview(lines, others), "",
            "@csv everyday_scenes All lines by kind, ground, measure and engine", *table(lines, others), ""]
