# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Divergence, penetration, energy, speed and success over influence, link and scene."""
import statistics
from pathlib import Path

from matplotlib.colors import LogNorm, TwoSlopeNorm

import demo_runs
import stats
from svg_figure import on_page, plt, save_svg

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
    return f"{statistics.median(out):.2f}" if out else "-"


def _wins(rows):
    """Two steps' all p95 over ours, where they differ: at small shares, at large ones, and at those on
    the long links."""
    small, large, far = [], [], []
    for scenario in SECONDS:
        for profile in PROFILES:
            for influence in INFLUENCES:
                found = _of(rows, scenario=scenario, profile=profile, influence=influence)
                a, b = (_mean(_of(found, scheme=s), "all_p95_mm") for s in SCHEMES)
                if a is None or b is None or abs(a - b) < 0.1:
                    continue
                (small if float(influence) <= 0.1 else large).append(b / a)
                if float(influence) > 0.1 and profile >= 4:
                    far.append(b / a)
    return small, large, far


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
    lines = [
        "## Influence", "",
        "Baseline shares from 0.02 to 0.98 on all links, one pass and two steps with the same "
        "prediction and rules, the same inputs; means over seeds. What is heard is bounded whatever is "
        "announced: 0.5 of one that does not own the body. It is a weight in the mean of all peers' "
        "states, and says nothing of how fast the gap to that closes. Success is the part of what the users set out to do that was "
        "done at the peer where it was least.", "",
        "| must hold | measured | holds |", "|---|---|---|",
        f"| stable at every influence and link | {stable[0]} of {len(ours)} "
        f"(two steps {stable[1]} of {len(theirs)}) | {'yes' if stable[0] == len(ours) else 'no'} |",
        f"| the displacement channel carries no kinetic energy | at most {carried:.2g} J | "
        f"{'yes' if carried < 1e-9 else 'no'} |",
        f"| users achieve no less than with two steps | {100 * done[0]:.1f} % and "
        f"{100 * done[1]:.1f} % | {'yes' if done[0] >= done[1] - 0.005 else 'no'} |", "",
        on_page(figure, docs, "maps over influence and profile"), "",
        "Ranges over influence, link and seed, one pass; energies are sums over both peers and the "
        "run. The solver's account is one pass's alone: two steps move bodies behind its back.", "",
        "| scenario | " + " | ".join(f"{n}, J" for n in ENERGY.values())
        + " | peak speed, m/s | of two steps | success, one pass / two steps |",
        "|---|" + "---|" * (len(ENERGY) + 3),
    ]
    for scenario in SECONDS:
        a, b = _of(ours, scenario=scenario), _of(theirs, scenario=scenario)
        if not a:
            continue
        lines.append(
            f"| {scenario} | " + " | ".join(_range(a, c) for c in ENERGY)
            + f" | {_range(a, 'peak_speed_m_s')} | {_range(b, 'peak_speed_m_s')} | "
            f"{_mean(a, 'success'):.3f} / {_mean(b, 'success'):.3f} |")
    wins = _wins(rows)
    lines += ["", f"By how much two steps' all p95 is above ours where both differ by more than 0.1 mm: "
              f"at shares up to 0.1 median {_median(wins[0])} ({len(wins[0])} cells), from 0.2 on "
              f"{_median(wins[1])} ({len(wins[1])}), and of these at profiles 4 and 5 "
              f"{_median(wins[2])} ({len(wins[2])})."]
    lines += ["", "What influence is worth: largest over least all p95 over the influences (median "
              "over links), and the influence with the least mean.", "",
              "| scenario | one pass | two steps | best, one pass | best, two steps |",
              "|---|---|---|---|---|"]
    for scenario in SECONDS:
        a, b = _of(ours, scenario=scenario), _of(theirs, scenario=scenario)
        if a:
            lines.append(f"| {scenario} | {_spread(a, 'all_p95_mm')} | {_spread(b, 'all_p95_mm')} | "
                         f"{_best_influence(a, 'all_p95_mm')} | "
                         f"{_best_influence(b, 'all_p95_mm')} |")
    return "\n".join(lines) + "\n"
