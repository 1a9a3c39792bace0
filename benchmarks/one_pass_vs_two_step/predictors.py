# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Which prediction needs how much share for which divergence, with one pass and with two steps."""
import statistics
from pathlib import Path

from matplotlib.ticker import LogLocator, NullFormatter

import demo_runs
import pages
import stats
from svg_figure import plt, save_svg

PREDICTORS = ("none", "euler", "replay")
COLOURS = ("#8e8e8e", "#1f5fa8", "#c0392b")
OURS = "replay"
SHARES = ("0.02", "0.08", "0.25", "0.5")
DEFAULT = {OURS: "0.25"}  # and 0.08 else
PROFILES = (3, 5)
SCHEMES = ("one-pass", "two-step")
SECONDS = {"cubes": 16, "room": 40, "piano": 18}
MOST_SEEDS = 2
KEYS = ["scenario", "scheme", "predictor", "profile", "seed", "seconds", "share"]
NEAR = 1.1     # times the best is as good
EQUAL = 0.1    # mm


def _closing(predictor, share):
    """What says how much of a gap is closed: of a replay the influence is a weight in the mean."""
    return ["--agreement", f"share={share}"] if predictor == OURS else ["--influence", share]


def _default(predictor):
    return DEFAULT.get(predictor, "0.08")


def _cells(seeds, quick):
    for scenario, seconds in SECONDS.items():
        if quick and scenario == "room":
            continue
        for profile in PROFILES[-1:] if quick else PROFILES:
            for seed in demo_runs.seeds(1 if quick else min(seeds, MOST_SEEDS)):
                for predictor in PREDICTORS:
                    for share in SHARES[1:3] if quick else SHARES:
                        for scheme in SCHEMES:
                            yield {"scenario": scenario, "profile": profile, "seed": seed,
                                   "seconds": seconds, "scheme": scheme, "share": share,
                                   "predictor": predictor,
                                   "options": ["--coupling", scheme, "--predictor", predictor,
                                               *_closing(predictor, share)]}


def measure(binaries: Path, results: Path, seeds: int, jobs: int, quick: bool) -> None:
    results.mkdir(parents=True, exist_ok=True)
    demo_runs.measure(results / "predictors.csv", list(_cells(seeds, quick)), KEYS, binaries, jobs)


def _table(rows):
    """(scenario, profile, scheme, predictor, share) -> (all p95, moving p50, jerk), None where a
    run was not stable."""
    groups = {}
    for r in rows:
        key = (r["scenario"], int(r["profile"]), r["scheme"], r["predictor"], r["share"])
        groups.setdefault(key, []).append(r)
    out = {}
    for key, found in groups.items():
        if any(r["stable"] != "1" for r in found):
            out[key] = None
            continue
        out[key] = tuple(statistics.fmean(demo_runs.numbers(found, c))
                         for c in ("all_p95_mm", "moving_p50_mm", "jerk_rms"))
    return out


def _draw(table, path):
    cells = [(s, p) for s in SECONDS for p in PROFILES if any(k[:2] == (s, p) for k in table)]
    figure, grid = plt.subplots(len(SCHEMES), len(cells), figsize=(2.7 * len(cells), 5.2),
                                squeeze=False, sharex=True)
    for line, scheme in zip(grid, SCHEMES):
        for axes, (scenario, profile) in zip(line, cells):
            for predictor, colour in zip(PREDICTORS, COLOURS):
                points = [(float(s), table[k][0]) for s in SHARES
                          if table.get(k := (scenario, profile, scheme, predictor, s))]
                axes.plot([x for x, _ in points], [y for _, y in points], "o-", ms=3, lw=1.2,
                          color=colour, label=predictor)
            axes.set_xscale("log")
            axes.set_yscale("log")
            axes.set_xticks([float(s) for s in SHARES], SHARES, fontsize=7)
            axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 1.5, 2.0, 3.0, 5.0, 7.0)))
            axes.yaxis.set_major_formatter(lambda v, _: f"{v:g}")
            axes.yaxis.set_minor_formatter(NullFormatter())
            axes.minorticks_off()
            axes.tick_params(labelsize=7)
            axes.set_title(f"{scenario}, profile {profile}, {scheme}", fontsize=8)
            axes.grid(True, which="major", alpha=0.3)
        line[0].set_ylabel("all p95, mm", fontsize=8)
    for axes in grid[-1]:
        axes.set_xlabel("share", fontsize=8)
    for k in range(len(cells)):  # the same scale for both couplings
        low = min(axes.get_ylim()[0] for axes in grid[:, k])
        high = max(axes.get_ylim()[1] for axes in grid[:, k])
        for axes in grid[:, k]:
            axes.set_ylim(low, high)
    handles, labels = grid[0][0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="upper center", ncol=len(PREDICTORS), frameon=False,
                  fontsize=8)
    figure.tight_layout(rect=(0, 0, 1, 0.94))
    save_svg(figure, path)


def _needed(table, scenario, profile, scheme, predictor, best):
    """The least share whose all p95 is as near as the best of all gets."""
    for share in SHARES:
        value = table.get((scenario, profile, scheme, predictor, share))
        if value and (value[0] <= NEAR * best or value[0] - best < EQUAL):
            return share
    return "-"


def _best(table, column, **wanted):
    names = ("scenario", "profile", "scheme", "predictor", "share")
    found = [v[column] for k, v in table.items()
             if v and all(dict(zip(names, k))[n] == w for n, w in wanted.items())]
    return min(found) if found else None


def report(results: Path, docs: Path) -> str:
    rows = demo_runs.read(results / "predictors.csv")
    if not rows:
        return "## Which prediction with which share\n\nNot measured."
    table = _table(rows)
    figure = results / "figures" / "predictors.svg"
    _draw(table, figure)
    cells = [(s, p) for s in SECONDS for p in PROFILES if any(k[:2] == (s, p) for k in table)]
    first = {}
    for scheme in SCHEMES:
        for scenario, profile in cells:
            ranked = {p: _best(table, 0, scenario=scenario, profile=profile, scheme=scheme,
                               predictor=p) for p in PREDICTORS}
            best = min(v for v in ranked.values() if v is not None)
            ours = ranked[OURS]
            first[scheme, scenario, profile] = ours is not None and (
                ours <= NEAR * best or ours - best < EQUAL)
    unstable = {}
    for (scenario, profile, scheme, predictor, share), v in table.items():
        if v is None:
            unstable.setdefault((scheme, scenario, profile, predictor), []).append(share)
    def value(scenario, profile, scheme, predictor):
        return table.get((scenario, profile, scheme, predictor, _default(predictor)))

    whole, brief = [], []
    for predictor in PREDICTORS:
        row = []
        for scenario, profile in cells:
            parts = []
            for scheme in SCHEMES:
                best = _best(table, 0, scenario=scenario, profile=profile, scheme=scheme)
                found = value(scenario, profile, scheme, predictor)
                parts.append(f"{stats.short(found[0]) if found else 'lost'} "
                             f"({_needed(table, scenario, profile, scheme, predictor, best)})")
            row.append(" / ".join(parts))
        whole.append([predictor, *row])
        brief.append([predictor, *(
            " / ".join(stats.short(v[k]) for k in (0, 2)) if (v := value(s, p, SCHEMES[0], predictor)) else "lost"
            for s, p in cells if p == PROFILES[-1])])
    for predictor in PREDICTORS:
        whole.append([f"jerk, {predictor}", *(
            " / ".join(stats.short(v[2]) if (v := value(s, p, scheme, predictor)) else "lost" for scheme in SCHEMES)
            for s, p in cells)])
    counts = {scheme: (sum(v is not None for k, v in table.items() if k[2] == scheme),
                       sum(k[2] == scheme for k in table)) for scheme in SCHEMES}
    near = {scheme: sum(first[scheme, s, p] for s, p in cells) for scheme in SCHEMES}
    file = pages.aside(docs / "one-pass-vs-two-step.md", "predictors", pages.table(
        ["predictor", *(f"{s} {p}" for s, p in cells)], whole))
    return "\n".join([
        "## Which prediction with which share", "",
        f"The {OURS} at its best share is within 10 % of the best predictor at its own in {near['one-pass']} of "
        f"{len(cells)} cells in one pass and {near['two-step']} in two steps. {counts['one-pass'][0]} of "
        f"{counts['one-pass'][1]} combinations are stable in one pass, {counts['two-step'][0]} of "
        f"{counts['two-step'][1]} in two steps.", "",
        f"A share ({SHARES[0]} to {SHARES[-1]}) is the influence that a peer announces (a leader's is raised); for a "
        f"replay, the part of the gap that it closes. One pass, profile {PROFILES[-1]}, default share "
        f"({_default('')}, of a replay {DEFAULT[OURS]}), all p95 in mm / jerk in m/s³:", "",
        *pages.table(["predictor", *(s for s, p in cells if p == PROFILES[-1])], brief), "",
        *(["Not stable: " + "; ".join(
            f"{scheme}, {scenario} {profile}, {predictor} at "
            + ("all shares" if set(shares) == set(SHARES) else ", ".join(shares))
            for (scheme, scenario, profile, predictor), shares in sorted(unstable.items())) + ".", ""]
          if unstable else []),
        f"[All cells, both couplings]({file}), with the least share within 10 % of the best of the cell.", ""])
