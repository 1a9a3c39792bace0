# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""What each part of the agreement is worth: one run without it for each, and its price."""
import csv
import math
import re
import shutil
import statistics
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from matplotlib.colors import LogNorm

import demo_runs
import stats
from svg_figure import on_page, plt, save_svg

PROFILES = (3, 5)
SECONDS = {"cubes": 16, "room": 40, "piano": 18, "cliff": 2}
MOST_SEEDS = {"cliff": 1}
SEEDS = 4
KEYS = ["scenario", "part", "profile", "seed", "seconds"]
WHOLE = "-"
# Name of --ablate, and what the run does without.
PARTS = {
    "channels": "the displacement channel: what agreement moves becomes velocity",
    "velocities": "agreement of velocities",
    "motion": "targets that feel what the body feels within the step",
    "rotation": "the exact rotation mean; plain geodesics",
    "replay": "the replay; states carried to now by velocity",
    "initiative": "whoever acted last leading",
    "leading": "a leader's higher share; it still does not listen",
    "arbitration": "the lower id deciding where no average helps",
    "ramp": "authority that grows from zero",
    "refine": "more substeps where they are needed",
}
MEASURES = {"moving_p50_mm": "moving p50", "all_p95_mm": "all p95", "overlap_p99_mm": "overlap p99",
            "overlap_max_mm": "overlap max", "correction_p99_mm": "correction p99",
            "jerk_rms": "jerk", "peak_speed_m_s": "peak speed"}
# What counts as equal: m/s3, m/s; else mm:
EQUAL = {"jerk_rms": 0.0, "peak_speed_m_s": 0.01}
EQUAL_LENGTH = 0.1
# Refinement is off where prices are compared: it answers to the least change of the motion.
PRICE_RUN = ["--print", "nothing", "--profile", "3"]
PRICE_SEEDS = ("1", "2")
# The own step; a replay's are within before_step, where another Solver::step would switch off again.
COUNTED = ("tandem::demos::(anonymous namespace)::TandemPhysics::step(tandem::demos::Scene&, "
           "tandem::consensus::Peer&, double)", "tandem::consensus::Peer::before_step(long)",
           "tandem::consensus::Peer::after_step(long)")
# Function that a stage's instructions are counted in.
STAGES = {
    "step": "TandemPhysics::step",
    "take over targets": "Solver::Impl::collect_targets",
    "agree velocities": "Targets::agree_velocities",
    "displace": "Solver::Impl::agree()",
    "peer before the step": "Peer::before_step",
    "of it, replays": "Replay::update",
    "peer after the step": "Peer::after_step",
}
# Whatever the solver does for agreement.
AGREEMENT = ("take over targets", "agree velocities", "displace")
CASES = {"one pass": [], "two steps": ["--coupling", "two-step"], "nothing agreed": ["--coupling", "none"],
         "one peer": ["--peers", "1"]}


def _options(part, more=""):
    """Of a run without a part. @param more  parts to leave out as well"""
    other = {"replay": ["--predictor", "euler"]}
    if part in other:
        return [*other[part], *(["--ablate", more] if more else [])]
    names = ",".join(n for n in (part if part != WHOLE else "", more) if n)
    return ["--ablate", names] if names else []


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


def _count(binaries, options):
    """Instructions of solver and peers, in all and by stage."""
    with tempfile.NamedTemporaryFile() as out:
        subprocess.run(["valgrind", "--tool=callgrind", f"--callgrind-out-file={out.name}",
                        *(f"--toggle-collect={f}" for f in COUNTED), str(binaries / "cubes"),
                        *PRICE_RUN, *options], capture_output=True, check=False)
        text = subprocess.run(["callgrind_annotate", "--inclusive=yes", "--threshold=100", out.name],
                              capture_output=True, check=False, text=True).stdout
    # The first line of a name counts: a function may be listed for each of its callers' files.
    counts = {}
    for line in text.splitlines():
        found = re.match(r"\s*([\d,]+) \([^)]*\)\s+(.*)", line)
        if not found:
            continue
        number = int(found[1].replace(",", ""))
        if "PROGRAM TOTALS" in found[2]:
            counts["all"] = number
        for stage, name in STAGES.items():
            if name in found[2]:
                counts.setdefault(stage, number)
    return counts


def _measure_price(path, binaries, jobs, quick):
    if path.exists() and path.stat().st_mtime >= (binaries / "cubes").stat().st_mtime:
        return
    if shutil.which("valgrind") is None or shutil.which("callgrind_annotate") is None:
        return
    seconds = "2" if quick else "6"
    runs = {name: ["--seconds", seconds, *options] for name, options in CASES.items()}
    if not quick:
        for seed in PRICE_SEEDS:
            here = ["--seconds", "3", "--seed", seed]
            for part in (WHOLE, *PARTS):
                if part == "refine":
                    runs[f"refined/{seed}"] = here
                elif part != "channels":
                    runs[f"{part}/{seed}"] = here + _options(part, "refine")
    with ThreadPoolExecutor(jobs) as pool:
        counts = list(pool.map(lambda options: _count(binaries, options), runs.values()))
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["run", "stage", "instructions"])
        for name, found in zip(runs, counts):
            for stage in ("all", *STAGES):
                table.writerow([name, stage, found.get(stage, 0)])


def measure(binaries: Path, results: Path, seeds: int, jobs: int, quick: bool) -> None:
    results.mkdir(parents=True, exist_ok=True)
    rows = results / "ablation_rows.csv"
    program = binaries / "aggregation"
    if not rows.exists() or rows.stat().st_mtime < program.stat().st_mtime:
        rows.write_text(subprocess.run([str(program)], capture_output=True, check=True,
                                       text=True).stdout)
    _measure_price(results / "ablation_price.csv", binaries, jobs, quick)
    demo_runs.measure(results / "ablation.csv", list(_cells(seeds, quick)), KEYS, binaries, jobs)


def _effect(rows, part, cell, measure):
    """Without the part over with it, by seeds: geometric mean and its 95 % interval; None where it
    cannot be said, infinity where a run without it was not stable."""
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
    """J, what agreement put into velocities in a run: median over runs of all scenes but cliff."""
    found = [sum(demo_runs.number(r, f"e_{k}_J") or 0.0 for k in ("displacement", "velocity"))
             for r in rows if r["part"] == part and r["scenario"] != "cliff"]
    return stats.short(statistics.median(found)) if found else "-"


def _prices(results):
    prices = {}
    for r in demo_runs.read(results / "ablation_price.csv"):
        prices.setdefault(r["run"], {})[r["stage"]] = int(r["instructions"])
    return prices


def _draw(rows, effects, path):
    cells = _cells_of(rows)
    shown = ("moving_p50_mm", "all_p95_mm", "overlap_max_mm", "correction_p99_mm", "jerk_rms")
    norm = LogNorm(0.5, 2.0, clip=True)
    figure, grid = plt.subplots(1, len(shown), figsize=(3.1 * len(shown) + 1.0, 6.2), squeeze=False)
    parts = list(PARTS)
    for axes, measure in zip(grid[0], shown):
        for y, part in enumerate(parts):
            for x, cell in enumerate(cells):
                e = effects.get((part, cell, measure))
                if e is None:
                    continue
                axes.fill_between([x - 0.5, x + 0.5], y - 0.5, y + 0.5, lw=0,
                                  color="#333333" if math.isinf(e[0])
                                  else plt.get_cmap("RdBu_r")(norm(e[0])))
                sure = math.isinf(e[0]) or e[1] > 1.0 or e[2] < 1.0
                axes.text(x, y, "lost" if math.isinf(e[0]) else f"{e[0]:.2f}", ha="center",
                          va="center", fontsize=5.5, weight="bold" if sure else "normal",
                          color="white" if not 0.58 < e[0] < 1.7 else "black")
        axes.set_xlim(-0.5, len(cells) - 0.5)
        axes.set_ylim(len(parts) - 0.5, -0.5)
        axes.set_xticks(range(len(cells)), [f"{s} {p}" for s, p in cells], rotation=90, fontsize=7)
        axes.set_yticks(range(len(parts)), parts if axes is grid[0][0] else [], fontsize=7)
        axes.set_title(f"{MEASURES[measure]}, without / with", fontsize=8)
    figure.tight_layout()
    save_svg(figure, path)


def _summary(effects, part, measure):
    """Geometric mean over cells, in how many it is worse and in how many better without."""
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


def _price(prices, part):
    """How many more instructions the whole takes than without the part, least to most over seeds."""
    found = []
    for seed in PRICE_SEEDS:
        whole, rest = prices.get(f"{WHOLE}/{seed}"), prices.get(f"{part}/{seed}")
        if part == "refine":
            whole, rest = prices.get(f"refined/{seed}"), whole
        if whole and rest:
            found.append(100.0 * (whole["all"] / rest["all"] - 1.0))
    return f"{min(found):.1f} to {max(found):.1f} %" if found else "-"


def _percent(part, whole):
    return f"{100.0 * part / whole:.1f} %" if whole else "-"


def _overhead(counts):
    """What agreement costs in the solver, of the step without it."""
    spent = sum(counts.get(s, 0) for s in AGREEMENT)
    rest = counts.get("step", 0) - spent
    return spent / rest if rest > 0 else None


def _aggregation(results):
    rows = {(int(r["peers"]), int(r["sweeps"])): r
            for r in demo_runs.read(results / "ablation_rows.csv")}
    if not rows:
        return []
    peers = sorted({p for p, _ in rows})
    sweeps = sorted({s for _, s in rows})
    lines = ["", "One target that is the mean, against one row for each peer: what is missed of the "
             "way to the weighted mean (position / rotation, rms), and CPU time per body and step of "
             "four substeps, without any contact.", "",
             "| | " + " | ".join(f"{p + 1} peers" for p in peers) + " |",
             "|---|" + "---|" * len(peers)]
    for s in sweeps:
        name = "the mean" if s == 0 else f"rows, {s} sweep{'s' if s > 1 else ''}"
        lines.append(f"| {name} | " + " | ".join(
            f"{100 * float(rows[p, s]['miss_position']):.2g} % / "
            f"{100 * float(rows[p, s]['miss_rotation']):.2g} %, "
            f"{1e-3 * float(rows[p, s]['cpu_ns']):.2g} us" for p in peers) + " |")
    return lines


def report(results: Path, docs: Path) -> str:
    rows, prices = demo_runs.read(results / "ablation.csv"), _prices(results)
    if not rows:
        return "## What each part is worth\n\nNot measured."
    effects = _effects(rows)
    seeds = sorted({int(r["seed"]) for r in rows})
    figure = results / "figures" / "ablation.svg"
    _draw(rows, effects, figure)
    lines = ["## What each part is worth", "",
             "Each run does without one part (`--ablate`), with the same inputs and seeds as the whole "
             f"(from {seeds[0]} to {seeds[-1]}). Lost are cells in which a run without the part broke. "
             "Ratios without / with: above 1 the part helps; geometric mean over cells (scenes at "
             "profiles 3 and 5), and in how many it is worse / better without beyond the seeds' 95 % "
             "interval (cliff has one seed: a number without a verdict). Lengths that differ by less "
             "than 0.1 mm count as equal. The price is in instructions of solver and peers on cubes "
             "(callgrind, 3 s, two seeds, without refinement): how many more with the part, least to "
             "most; what is below some 3 % either way is chance. Peak speed is no merit: below 1 throws "
             "and strokes lose without the part, or it disturbs. Energy is what agreement put into "
             "velocities in a run, both peers, median over all scenes but cliff.", ""]
    if prices:
        shared, none = prices["one pass"], prices["nothing agreed"]
        cost, idle = _overhead(shared), _overhead(none)
        lines += ["| must hold | measured | holds |", "|---|---|---|",
                  f"| targets and displacement cost at most 10 % of the step without them, "
                  f"cubes | {100 * cost:.1f} % | {'yes' if cost <= 0.1 else 'no'} |",
                  f"| nothing where nothing is shared | {100 * idle:.3f} % | "
                  f"{'yes' if idle < 1e-3 else 'no'} |", ""]
    lines += [on_page(figure, docs, "effects of all parts in all cells"), "",
              "| without | what it is | " + " | ".join(MEASURES.values())
              + " | energy, J | price |", "|---|---|" + "---|" * (len(MEASURES) + 2),
              "| - | nothing |" + " |" * len(MEASURES) + f" {_energy(rows, WHOLE)} | |"]
    for part, what in PARTS.items():
        lines.append(f"| {part} | {what} | " + " | ".join(
            _summary(effects, part, m) for m in MEASURES)
            + f" | {_energy(rows, part)} | {_price(prices, part)} |")
    if prices:
        steps = {name: counts.get("step", 0) for name, counts in prices.items() if name in CASES}
        lines += ["", "Where the instructions go, cubes at profile 3, 6 s, of the solver's step:", "",
                  "| stage | " + " | ".join(steps) + " |", "|---|" + "---|" * len(steps)]
        for stage in STAGES:
            if stage != "step":
                lines.append(f"| {stage} | " + " | ".join(
                    _percent(prices[n].get(stage, 0), steps[n]) for n in steps) + " |")
        lines.append("| agreement, of the step without it | " + " | ".join(
            f"{100.0 * _overhead(prices[n]):.1f} %" for n in steps) + " |")
        lines.append("| the step, millions | " + " | ".join(
            f"{s / 1e6:.0f}" for s in steps.values()) + " |")
    lines += _aggregation(results)
    return "\n".join(lines) + "\n"
