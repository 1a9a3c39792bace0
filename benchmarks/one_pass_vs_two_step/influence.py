# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Divergence, penetration, energy, speed and success over influence, link and scene."""
import statistics
from pathlib import Path

from matplotlib.colors import LogNorm, TwoSlopeNorm

import demo_runs
import pages
import stats
from svg_figure import plt, save_svg

INFLUENCES = ("0.02", "0.05", "0.1", "0.2", "0.5", "0.98")
PROFILES = (1, 2, 3, 4, 5)
SCHEMES = ("one-pass", "two-step")
SECONDS = {"cubes": 16, "room": 40, "piano": 18, "cliff": 2}
MOST_SEEDS = 2
KEYS = ["scenario", "scheme", "profile", "seed", "seconds", "influence"]
# Energy terms (J).
ENERGY = {"e_displacement_J": "displacement", "e_velocity_J": "velocities",
          "e_potential_J": "potential"}


def _cells(seeds, quick):
    for scenario, seconds in SECONDS.items():
        if quick and scenario == "cliff":
            continue
        cliff = scenario == "cliff"
        for profile in (1, 5) if quick else (1, 3, 5) if cliff else PROFILES:
            for seed in demo_runs.seeds(1 if quick or cliff else min(seeds, MOST_SEEDS)):
                for influence in INFLUENCES[::2] if quick or cliff else INFLUENCES:
                    for scheme in SCHEMES:
                        yield {"scenario": scenario, "profile": profile, "seed": seed,
                               "seconds": seconds, "scheme": scheme, "influence": influence,
                               "options": ["--coupling", scheme, "--influence", influence]}


def measure(binaries: Path, results: Path, seeds: int, jobs: int, quick: bool) -> None:
    results.mkdir(parents=True, exist_ok=True)
    demo_runs.measure(results / "influence.csv", list(_cells(seeds, quick)), KEYS, binaries, jobs)


def _of(rows, **wanted):
    return [r for r in rows if all(r[k] == str(v) for k, v in wanted.items())]


def _mean(rows, column):
    found = demo_runs.numbers(rows, column)
    return statistics.fmean(found) if found else None


def _map(axes, rows, scenario, value, norm, colours, title):
    for x, influence in enumerate(INFLUENCES):
        for y, profile in enumerate(PROFILES):
            found = _of(rows, scenario=scenario, profile=profile, influence=influence)
            number = value(found) if found else None
            if number is None:
                continue
            colour = plt.get_cmap(colours)(norm(number))
            axes.fill_between([x - 0.5, x + 0.5], y - 0.5, y + 0.5, color=colour, lw=0)
            axes.text(x, y, f"{number:.2g}", ha="center", va="center", fontsize=6,
                      color="white" if sum(colour[:3]) < 1.2 else "black")
    axes.set_xlim(-0.5, len(INFLUENCES) - 0.5)
    axes.set_ylim(-0.5, len(PROFILES) - 0.5)
    axes.set_xticks(range(len(INFLUENCES)), INFLUENCES, fontsize=7)
    axes.set_yticks(range(len(PROFILES)), PROFILES, fontsize=7)
    axes.set_title(title, fontsize=8)


def _draw(rows, path):
    length = LogNorm(0.1, 100.0, clip=True)
    ratio = TwoSlopeNorm(1.0, 0.5, 2.0)

    def of(scheme, column):
        def value(found):
            mean = _mean(_of(found, scheme=scheme), column)
            return None if mean is None else max(mean, 0.01)
        return value

    def over(column, least):
        def value(found):
            a, b = (_mean(_of(found, scheme=s), column) for s in SCHEMES)
            if a is None or b is None:
                return None
            return 1.0 if abs(a - b) < least else b / max(a, 1e-3)
        return value

    columns = [
        ("all p95, one pass, mm", of("one-pass", "all_p95_mm"), length, "YlOrRd"),
        ("all p95, two steps / one pass", over("all_p95_mm", 0.1), ratio, "RdBu"),
        ("overlap max, one pass, mm", of("one-pass", "overlap_max_mm"), length, "YlOrRd"),
        ("overlap max, two steps, mm", of("two-step", "overlap_max_mm"), length, "YlOrRd"),
        ("peak speed, two steps / one pass", over("peak_speed_m_s", 1e-3), ratio, "RdBu"),
    ]
    scenarios = [s for s in SECONDS if any(r["scenario"] == s for r in rows)]
    figure, grid = plt.subplots(len(scenarios), len(columns),
                                figsize=(3.0 * len(columns), 2.2 * len(scenarios)), squeeze=False)
    for line, scenario in zip(grid, scenarios):
        for axes, (title, value, norm, colours) in zip(line, columns):
            _map(axes, rows, scenario, value, norm, colours, f"{scenario}: {title}")
        line[0].set_ylabel("profile", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("influence", fontsize=8)
    figure.tight_layout()
    save_svg(figure, path)


def _range(rows, column):
    found = demo_runs.numbers(rows, column)
    if not found:
        return "-"
    return f"{stats.short(min(found))} to {stats.short(max(found))}"


def _best_influence(rows, column):
    """The influence with the least mean of a column over profiles and seeds."""
    means = {i: _mean(_of(rows, influence=i), column) for i in INFLUENCES}
    means = {i: m for i, m in means.items() if m is not None}
    return min(means, key=means.get) if means else "-"


def _spread(rows, column):
    """By profile: largest over least mean over influences."""
    out = []
    for profile in PROFILES:
        means = [_mean(_of(rows, profile=profile, influence=i), column) for i in INFLUENCES]
        means = [m for m in means if m is not None]
        if len(means) > 1:
            out.append(max(means) / max(min(means), 1e-6))
    return statistics.median(out) if out else None


def _wins(rows):
    """Two steps' all p95 over ours, where they differ: at small shares, and at large ones."""
    small, large = [], []
    for scenario in SECONDS:
        for profile in PROFILES:
            for influence in INFLUENCES:
                found = _of(rows, scenario=scenario, profile=profile, influence=influence)
                a, b = (_mean(_of(found, scheme=s), "all_p95_mm") for s in SCHEMES)
                if a is None or b is None or abs(a - b) < 0.1:
                    continue
                (small if float(influence) <= 0.1 else large).append(b / a)
    return small, large


def _median(ratios):
    return f"{statistics.median(ratios):.2f}" if ratios else "-"


def report(results: Path, docs: Path) -> str:
    rows = demo_runs.read(results / "influence.csv")
    if not rows:
        return "## Influence\n\nNot measured."
    figure = results / "figures" / "influence.svg"
    _draw(rows, figure)
    ours = _of(rows, scheme="one-pass")
    theirs = _of(rows, scheme="two-step")
    stable = [sum(r["stable"] == "1" for r in rs) for rs in (ours, theirs)]
    carried = max(abs(v) for v in demo_runs.numbers(ours, "e_displacement_J"))
    done = [statistics.fmean(demo_runs.numbers(rs, "success")) for rs in (ours, theirs)]
    named = [(s, _of(ours, scenario=s), _of(theirs, scenario=s)) for s in SECONDS if _of(ours, scenario=s)]
    page = docs / "one-pass-vs-two-step.md"
    energies = pages.aside(page, "influence_energy", pages.table(
        ["scenario", *(f"{n}, J" for n in ENERGY.values()), "peak speed, m/s", "of two steps",
         "success, one pass / two steps"],
        [[s, *(_range(a, c) for c in ENERGY), _range(a, "peak_speed_m_s"), _range(b, "peak_speed_m_s"),
          f"{_mean(a, 'success'):.3f} / {_mean(b, 'success'):.3f}"] for s, a, b in named]))
    spreads = [(s, a, b, _spread(a, "all_p95_mm"), _spread(b, "all_p95_mm")) for s, a, b in named]
    worth = pages.aside(page, "influence_worth", pages.table(
        ["scenario", "one pass", "two steps", "best, one pass", "best, two steps"],
        [[s, *("-" if v is None else f"{v:.2f}" for v in (x, y)), _best_influence(a, "all_p95_mm"),
          _best_influence(b, "all_p95_mm")] for s, a, b, x, y in spreads]))
    known = [x for _, _, _, x, _ in spreads if x is not None]
    wins = _wins(rows)
    return "\n".join([
        "## Influence", "",
        f"At influences of {INFLUENCES[0]} to {INFLUENCES[-1]} one pass is stable in {stable[0]} of {len(ours)} runs, "
        f"two steps in {stable[1]}; users achieve {100 * done[0]:.1f} % and {100 * done[1]:.1f} % of their tasks. The "
        f"largest all p95 over influences is {min(known):.2f} to {max(known):.2f} times the least, by scenario.", "",
        "One baseline influence on all links, the same prediction and rules. Influence is a weight in the mean of all "
        "peers' states, not the speed at which the gap to that mean closes; a peer that does not own a body is heard "
        f"with 0.5 at most. The displacement channel carries {carried:.2g} J at most.", "",
        f"[Energy, speed and success]({energies}): ranges over influence, link and seed. [Spread and best "
        f"influence]({worth}). In cells that differ by more than 0.1 mm, two steps have {_median(wins[0])} times one "
        f"pass's all p95 at influences up to 0.1 (median of {len(wins[0])}), {_median(wins[1])} times above "
        f"({len(wins[1])}).", ""])
