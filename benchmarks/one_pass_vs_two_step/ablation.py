# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The effect of each part of the agreement: one run without each."""
import math
import statistics
from pathlib import Path

import demo_runs
import pages
import stats

PROFILES = (3, 5)
SECONDS = {"cubes": 16, "room": 40, "piano": 18, "cliff": 2}
MOST_SEEDS = {"cliff": 1}
SEEDS = 4
KEYS = ["scenario", "part", "profile", "seed", "seconds"]
WHOLE = "-"
# Name of --ablate, and the effect of omission.
PARTS = {
    "channels": "the displacement channel: corrections become velocity",
    "velocities": "agreement of velocities",
    "replay": "the replay; states carried to now by velocity",
    "initiative": "the last to act leads",
    "leading": "a leader's higher share",
}
MEASURES = {"moving_p50_mm": "moving p50", "all_p95_mm": "all p95", "overlap_p99_mm": "overlap p99",
            "overlap_max_mm": "overlap max", "correction_p99_mm": "correction p99",
            "jerk_rms": "jerk", "peak_speed_m_s": "peak speed"}
# Differences that count as equal: m/s3, m/s; else mm:
EQUAL = {"jerk_rms": 0.0, "peak_speed_m_s": 0.01}
EQUAL_LENGTH = 0.1


def _options(part):
    if part == WHOLE:
        return []
    return ["--predictor", "euler"] if part == "replay" else ["--ablate", part]


def _cells(seeds, quick):
    for scenario, seconds in SECONDS.items():
        if quick and scenario in ("cliff", "room"):
            continue
        for profile in PROFILES[-1:] if quick else PROFILES:
            for seed in demo_runs.seeds(min(1 if quick else seeds, SEEDS,
                                            MOST_SEEDS.get(scenario, seeds))):
                for part in (WHOLE, *PARTS):
                    yield {"scenario": scenario, "profile": profile, "seed": seed,
                           "seconds": seconds, "part": part,
                           "options": _options(part)}


def measure(binaries: Path, results: Path, seeds: int, jobs: int, quick: bool) -> None:
    demo_runs.measure(results / "ablation.csv", list(_cells(seeds, quick)), KEYS, binaries, jobs)


def _effect(rows, part, cell, measure):
    """The value without the part over that with it, by seeds: geometric mean and its 95 % interval; None if undefined,
    infinity if a run without it was not stable."""
    of = {r["seed"]: r for r in rows if r["part"] == WHOLE and (r["scenario"], r["profile"]) == cell}
    ratios = []
    for r in rows:
        if r["part"] != part or (r["scenario"], r["profile"]) != cell or r["seed"] not in of:
            continue
        a, b = demo_runs.number(of[r["seed"]], measure), demo_runs.number(r, measure)
        if r["stable"] != "1":
            return math.inf, math.inf, math.inf
        if a is None or b is None:
            continue
        equal = abs(a - b) < EQUAL.get(measure, EQUAL_LENGTH)
        ratios.append(0.0 if equal else math.log(max(b, 1e-6) / max(a, 1e-6)))
    mean, half = stats.interval(ratios)
    if mean is None:
        return None
    if half is None:  # one seed proves nothing
        return math.exp(mean), 0.0, math.inf
    return math.exp(mean), math.exp(mean - half), math.exp(mean + half)


def _cells_of(rows):
    return sorted({(r["scenario"], r["profile"]) for r in rows},
                  key=lambda c: (list(SECONDS).index(c[0]), c[1]))


def _effects(rows):
    return {(part, cell, m): e for part in PARTS for cell in _cells_of(rows) for m in MEASURES
            if (e := _effect(rows, part, cell, m)) is not None}


def _energy(rows, part):
    """J, energy that agreement added to velocities in a run: median over runs of all scenes but cliff."""
    found = [sum(demo_runs.number(r, f"e_{k}_J") or 0.0 for k in ("displacement", "velocity"))
             for r in rows if r["part"] == part and r["scenario"] != "cliff"]
    return stats.short(statistics.median(found)) if found else "-"


def _summary(effects, part, measure):
    """Geometric mean over cells, and in how many it is worse and better without."""
    found = [e for (p, _, m), e in effects.items() if p == part and m == measure]
    if not found:
        return "-"
    finite = [e for e in found if math.isfinite(e[0])]
    worse = sum(e[1] > 1.0 for e in finite)
    better = sum(e[2] < 1.0 for e in finite)
    mean = math.exp(statistics.fmean(math.log(e[0]) for e in finite)) if finite else math.inf
    lost = len(found) - len(finite)
    text = f"{mean:.2f} ({worse}/{better})" if finite else "-"
    return text + (f", {lost} lost" if lost else "")


def _matters(effects, part, measure):
    """True if a part makes a difference beyond the interval in any cell."""
    return any(e[1] > 1.0 or e[2] < 1.0 for (p, _, m), e in effects.items() if p == part and m == measure)


def _finding(effects):
    lost = {p: n for p in PARTS if (n := sum(math.isinf(effects[k][0]) for k in effects
                                             if k[0] == p and k[2] == "all_p95_mm"))}
    cells = len({k[1] for k in effects})
    silent = [p for p in PARTS if not any(_matters(effects, p, m) for m in MEASURES)]
    text = "".join(f"Without {PARTS[p].split(':')[0]} {n} of {cells} cells break. " for p, n in lost.items())
    if silent:
        text += f"No effect shows of the parts {', '.join(f'*{p}*' for p in silent)}."
    return text.strip()


def report(results: Path, docs: Path) -> str:
    rows = demo_runs.read(results / "ablation.csv")
    if not rows:
        return "## What each part is worth\n\nNot measured."
    effects = _effects(rows)
    seeds = sorted({int(r["seed"]) for r in rows})
    page = docs / "one-pass-vs-two-step.md"
    whole = pages.aside(page, "ablation", pages.table(
        ["without", "description", *MEASURES.values(), "energy, J"],
        [["-", "nothing", *[""] * len(MEASURES), _energy(rows, WHOLE)],
         *([p, what, *(_summary(effects, p, m) for m in MEASURES), _energy(rows, p)]
           for p, what in PARTS.items())]))
    lines = ["## What each part is worth", "", _finding(effects), "",
             f"Each run leaves out one part (`--ablate`; seeds {seeds[0]} to {seeds[-1]}). Ratios are without / with, "
             "above 1 the part helps: geometric means over scenes at profiles "
             f"{' and '.join(str(p) for p in PROFILES)}; in brackets, cells that are worse / better without beyond "
             "the interval; *lost*: cells that broke. Cliff has one seed, so no verdict.", "",
             *pages.table(["without", "description", "all p95"],
                          [[p, what, _summary(effects, p, "all_p95_mm")]
                           for p, what in PARTS.items() if _matters(effects, p, "all_p95_mm")]), "",
             f"The table has the parts with an effect on p95 beyond the interval. [All parts and measures]({whole}) "
             "include peak speed and the energy that agreement puts into velocities.", ""]
    return "\n".join(lines)
