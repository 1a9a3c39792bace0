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
import pages
import stats
from svg_figure import plt, save_svg

PROFILES = (3, 5)
SECONDS = {"cubes": 16, "room": 40, "piano": 18, "cliff": 2}
MOST_SEEDS = {"cliff": 1}
SEEDS = 4
KEYS = ["scenario", "part", "profile", "seed", "seconds"]
WHOLE = "-"
# Name of --ablate, and what the run does without.
PARTS = {
    "channels": "the displacement channel: corrections become velocity",
    "velocities": "agreement of velocities",
    "motion": "targets that follow the body's forces within the step",
    "rotation": "the exact rotation mean; plain geodesics",
    "replay": "the replay; states carried to now by velocity",
    "initiative": "the last to act leads",
    "leading": "a leader's higher share",
    "arbitration": "the lower id decides where no average helps",
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


def _matters(effects, part, measure):
    """Whether a part makes a difference beyond the interval in any cell."""
    return any(e[1] > 1.0 or e[2] < 1.0 for (p, _, m), e in effects.items() if p == part and m == measure)


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


def _aggregation(results, page):
    """One target that is the mean, against one row for each peer."""
    rows = {(int(r["peers"]), int(r["sweeps"])): r
            for r in demo_runs.read(results / "ablation_rows.csv")}
    if not rows:
        return []
    peers, sweeps = sorted({p for p, _ in rows}), sorted({s for _, s in rows})

    def miss(p, s):
        return (f"{100 * float(rows[p, s]['miss_position']):.2g} % / "
                f"{100 * float(rows[p, s]['miss_rotation']):.2g} %")

    def time(p, s):
        return f"{1e-3 * float(rows[p, s]['cpu_ns']):.2g} us"

    file = pages.aside(page, "rows_for_each_peer", pages.table(
        ["target", *(f"{p + 1} peers" for p in peers)],
        [["the mean" if s == 0 else f"rows, {s} sweep{'s' if s > 1 else ''}",
          *(f"{miss(p, s)}, {time(p, s)}" for p in peers)] for s in sweeps]))
    most = peers[-1]
    return [f"*One target against one row for each peer*, {most + 1} peers, per body and step: the mean as target "
            f"misses {miss(most, 0)} of the way (position / rotation, rms) in {time(most, 0)}; rows miss "
            f"{miss(most, 1)} in one sweep and {time(most, 1)}, {miss(most, sweeps[-1])} in {sweeps[-1]} sweeps and "
            f"{time(most, sweeps[-1])} ([all]({file}); no contacts).", ""]


def _finding(effects, prices):
    lost = {p: n for p in PARTS if (n := sum(math.isinf(effects[k][0]) for k in effects
                                             if k[0] == p and k[2] == "all_p95_mm"))}
    cells = len({k[1] for k in effects})
    silent = [p for p in PARTS if not any(_matters(effects, p, m) for m in MEASURES)]
    text = "".join(f"Without {PARTS[p].split(':')[0]} {n} of {cells} cells break. " for p, n in lost.items())
    if prices:
        shared, none = _overhead(prices["one pass"]), _overhead(prices["nothing agreed"])
        text += (f"Targets and displacement add {100 * shared:.1f} % to a step of cubes (bound 10 %), "
                 f"{100 * none:.3f} % where nothing is shared. The replay adds {_price(prices, 'replay')} "
                 "instructions. ")
    if silent:
        text += f"No effect shows of the parts {', '.join(f'*{p}*' for p in silent)}."
    return text.strip()


def report(results: Path, docs: Path) -> str:
    rows, prices = demo_runs.read(results / "ablation.csv"), _prices(results)
    if not rows:
        return "## What each part is worth\n\nNot measured."
    effects = _effects(rows)
    seeds = sorted({int(r["seed"]) for r in rows})
    _draw(rows, effects, results / "figures" / "ablation.svg")
    page = docs / "one-pass-vs-two-step.md"
    whole = pages.aside(page, "ablation", pages.table(
        ["without", "description", *MEASURES.values(), "energy, J", "price"],
        [["-", "nothing", *[""] * len(MEASURES), _energy(rows, WHOLE), ""],
         *([p, what, *(_summary(effects, p, m) for m in MEASURES), _energy(rows, p), _price(prices, p)]
           for p, what in PARTS.items())]))
    lines = ["## What each part is worth", "", _finding(effects, prices), "",
             f"Each run leaves out one part (`--ablate`; seeds {seeds[0]} to {seeds[-1]}). Ratios are without / with, "
             "above 1 the part helps: geometric means over scenes at profiles "
             f"{' and '.join(str(p) for p in PROFILES)}; in brackets, cells that are worse / better without beyond "
             "the interval; *lost*: cells that broke. Cliff has one seed, so no verdict. Prices are additional "
             "instructions of solver and peers (callgrind, cubes, 3 s, two seeds, no refinement); below 3 % they are "
             "chance.", "",
             *pages.table(["without", "description", "all p95", "price"],
                          [[p, what, _summary(effects, p, "all_p95_mm"), _price(prices, p)]
                           for p, what in PARTS.items() if _matters(effects, p, "all_p95_mm")]), "",
             f"The table has the parts with an effect on p95 beyond the interval. [All parts and measures]({whole}) "
             "include peak speed and the energy that agreement puts into velocities. *arbitration* is for copies "
             "caught apart and *ramp* for newcomers: see `coupling_test` and `peer_newcomer_test`.", ""]
    if prices:
        steps = {name: counts.get("step", 0) for name, counts in prices.items() if name in CASES}
        stages = [[stage, *(_percent(prices[n].get(stage, 0), steps[n]) for n in steps)]
                  for stage in STAGES if stage != "step"]
        stages.append(["agreement, of the step without it", *(f"{100.0 * _overhead(prices[n]):.1f} %" for n in steps)])
        stages.append(["the step, millions", *(f"{s / 1e6:.0f}" for s in steps.values())])
        file = pages.aside(page, "instructions", pages.table(["stage", *steps], stages))
        lines += [f"[Instructions by stage of the step]({file}): cubes, profile 3, 6 s.", ""]
    return "\n".join(lines + _aggregation(results, page))
