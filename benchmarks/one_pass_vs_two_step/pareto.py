# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Error against run time: one pass and two steps over substeps and sweeps, as Pareto fronts."""
import math
import statistics
from pathlib import Path

import demo_runs
import pages
import stats

PROFILES = (3, 5)
SECONDS = {"cubes": 16, "room": 40, "piano": 18, "cliff": 2}
MOST_SEEDS = {"cliff": 2}
KEYS = ["scenario", "scheme", "profile", "seed", "seconds", "setting"]
# Substeps, and sweeps of the pass.
FULL = {"1": [], "2": [], "4": [], "8": [], "16": [], "4, 4 sweeps": ["--iterations", "4"]}
SHORT = {"1": [], "4": [], "16": []}
CLIFF = {"1": [], "2": [], "4": [], "8": []}
BULLET = ("5", "10", "50", "100")
SCHEMES = ("one-pass", "two-step", "two-step-paper")
PAIRS = (("one-pass", "two-step"), ("one-pass", "two-step-paper"), ("one-pass", "bullet"))
ERRORS = {"moving_p50_mm": "moving p50", "all_p95_mm": "all p95",
          "overlap_p99_mm": "overlap p99", "overlap_max_mm": "overlap max"}
EQUAL = 0.1  # mm: smaller differences count as equal


def _settings(scenario, scheme):
    if scenario == "cliff":
        return CLIFF if scheme in ("one-pass", "two-step") else {"2": [], "4": []}
    return FULL if scheme in ("one-pass", "two-step") else SHORT


def _cells(binaries, seeds, quick):
    has_bullet = demo_runs.has_bullet(binaries)
    for scenario, seconds in SECONDS.items():
        if quick and scenario == "cliff":
            continue
        for profile in PROFILES[-1:] if quick else PROFILES:
            for seed in demo_runs.seeds(min(seeds, MOST_SEEDS.get(scenario, seeds))):
                cell = {"scenario": scenario, "profile": profile, "seed": seed, "seconds": seconds}
                for scheme in SCHEMES:
                    if scenario == "cliff" and scheme == "two-step-paper":
                        continue
                    for setting, options in _settings(scenario, scheme).items():
                        substeps = setting.split(",")[0]
                        yield cell | {"scheme": scheme, "setting": setting,
                                      "options": ["--coupling", scheme, "--substeps", substeps,
                                                  *options]}
                if not has_bullet or scenario not in ("cubes", "cliff"):
                    continue
                for iterations in BULLET[1:4:2] if scenario == "cliff" else BULLET:
                    yield cell | {"scheme": "bullet", "setting": iterations,
                                  "options": ["--engines", "bullet", "--coupling",
                                              "two-step-paper", "--iterations", f"1,{iterations}"]}


def measure(binaries: Path, results: Path, seeds: int, jobs: int, quick: bool) -> None:
    results.mkdir(parents=True, exist_ok=True)
    cells = list(_cells(binaries, 1 if quick else seeds, quick))
    demo_runs.measure(results / "pareto.csv", cells, KEYS, binaries, jobs)


def _unstable(row):
    # None of Bullet's undisturbed stacks of cubes meets the demo's 5 mm, with or without peers.
    return row["stable"] != "1" and (row["scheme"], row["scenario"]) != ("bullet", "cubes")


class Front:
    """Stable settings of one scheme in one cell: time and error by seed."""

    def __init__(self, rows, scheme, error):
        self.points = {}
        self.lost = 0
        by_setting = {}
        for r in rows:
            if r["scheme"] == scheme:
                by_setting.setdefault(r["setting"], []).append(r)
        for setting, found in by_setting.items():
            if any(_unstable(r) for r in found):
                self.lost += 1
                continue
            errors = {r["seed"]: demo_runs.number(r, error) for r in found}
            errors = {s: e for s, e in errors.items() if e is not None and math.isfinite(e)}
            if errors:
                time = statistics.median(demo_runs.numbers(found, "cpu_us"))
                self.points[setting] = (time, errors)

    def cheapest(self):
        return min(t for t, _ in self.points.values())

    def dearest(self):
        return max(t for t, _ in self.points.values())

    def best(self, budget):
        """Errors by seed of the setting within the budget that is best on average."""
        within = [e for t, e in self.points.values() if t <= budget * (1 + 1e-9)]
        return min(within, key=lambda e: statistics.fmean(e.values())) if within else None

def verdict(rows, ours, theirs, error, budgets=9):
    """Their best error over ours at equal time: geometric mean over budgets and seeds, and its 95 % interval over
    seeds; infinite if they have no stable setting, 0 if we have none; None if there is nothing to compare."""
    a, b = Front(rows, ours, error), Front(rows, theirs, error)
    said = any(demo_runs.number(r, error) is not None for r in rows)
    if not said or not (a.points or a.lost) or not (b.points or b.lost):
        return None
    if not a.points or not b.points:
        return None if not a.points and not b.points else (math.inf if a.points else 0.0,) * 3
    low, high = max(a.cheapest(), b.cheapest()), max(a.dearest(), b.dearest())
    logs = {}
    for k in range(budgets):
        budget = low * (high / low) ** (k / (budgets - 1))
        x, y = a.best(budget), b.best(budget)
        for seed in x.keys() & y.keys():
            equal = abs(x[seed] - y[seed]) < EQUAL
            ratio = 0.0 if equal else math.log(max(y[seed], 1e-6) / max(x[seed], 1e-6))
            logs.setdefault(seed, []).append(ratio)
    mean, half = stats.interval([statistics.fmean(v) for v in logs.values()])
    if mean is None:
        return None
    half = half or 0.0
    return math.exp(mean), math.exp(mean - half), math.exp(mean + half)


def _kind(v):
    if v[2] < 0.999:
        return "worse"
    return "2x" if v[0] >= 2.0 and v[1] > 1.0 else "not worse"


def _by_cell(rows):
    cells = {}
    for r in rows:
        cells.setdefault((r["scenario"], r["profile"]), []).append(r)
    return cells


def verdicts(rows):
    """(pair, cell, error) -> verdict."""
    out = {}
    for cell, found in _by_cell(rows).items():
        for pair in PAIRS:
            for error in ERRORS:
                v = verdict(found, *pair, error)
                if v is not None:
                    out[pair, cell, error] = v
    return out


def _text(v):
    if v is None:
        return "-"
    if math.isinf(v[0]):
        return "two steps lost **2x**"
    if v[0] == 0.0:
        return "one pass lost (worse)"
    mark = {"worse": " (worse)", "2x": " **2x**", "not worse": ""}[_kind(v)]
    return f"{v[0]:.2f} [{v[1]:.2f}, {v[2]:.2f}]{mark}"


def _table(found, pair):
    cells = sorted({cell for p, cell, _ in found if p == pair})
    return pages.table(["cell", "profile", *ERRORS.values()],
                       [[*cell, *(_text(found.get((pair, cell, e))) for e in ERRORS)] for cell in cells])


def _count(found, pair, errors=tuple(ERRORS)):
    """Cells, and in how many the first is worse, twice as good, and better beyond the interval."""
    here = [v for (p, _, e), v in found.items() if p == pair and e in errors]
    kinds = [_kind(v) for v in here]
    return len(here), kinds.count("worse"), kinds.count("2x"), sum(v[1] > 1.001 for v in here)


def _rate(rows, scheme):
    found = [r for r in rows if r["scheme"] == scheme]
    return f"{scheme} {sum(r['stable'] == '1' for r in found)} of {len(found)}"


def _beside_bullet(found):
    """How often one pass has less, and more error than two steps before Bullet."""
    texts = []
    for name, errors in (("divergence", ("moving_p50_mm", "all_p95_mm")),
                         ("overlap", ("overlap_p99_mm", "overlap_max_mm"))):
        n, worse, _, better = _count(found, PAIRS[2], errors)
        texts.append(f"lower {name} in {better} of {n}, higher in {worse}")
    return f" Against two steps in front of Bullet it has {'; '.join(texts)}."


def report(results: Path, docs: Path) -> str:
    rows = demo_runs.read(results / "pareto.csv")
    if not rows:
        return "## Error against run time\n\nNot measured."
    found, page = verdicts(rows), docs / "one-pass-vs-two-step.md"
    n, worse, twice, better = _count(found, PAIRS[0])
    losses = [f"{cell[0]}, profile {cell[1]}, {ERRORS[e]} ({v[0]:.2f})"
              for (p, cell, e), v in found.items() if p == PAIRS[0] and _kind(v) == "worse"]
    finding = (f"At equal time one pass is better in {better} of {n} cells and measures, two steps in {worse}; the "
               f"others do not differ. One pass is at least twice as good in {twice}; the aim was half.")
    links = []
    for pair, file in zip(PAIRS, ("fronts", "fronts_published", "fronts_bullet")):
        if any(p == pair for p, _, _ in found):
            links.append(f"[{pair[1]}]({pages.aside(page, file, _table(found, pair))})")
    if len(links) == len(PAIRS):
        finding += _beside_bullet(found)
    return "\n".join([
        "## Error against run time", "", finding, "",
        "Substeps 1 to 16, and more sweeps; profiles "
        f"{' and '.join(str(p) for p in PROFILES)}. Time is processor time of one peer's step, agreement and solver, "
        "median over seeds. A setting counts if it is stable with each seed. Ratios are another scheme's best error "
        "over one pass's, geometric means over nine budgets from the dearer scheme's cheapest setting on: "
        f"{', '.join(links)}.", "",
        "- One pass is worse than two steps in: " + ("; ".join(losses) if losses else "none") + ".",
        "- Stable runs: " + ", ".join(_rate(rows, s) for s in dict.fromkeys(r["scheme"] for r in rows)) + ".", ""])
