# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Couplings beside each other on the same scenes, links, inputs and shares."""
import math
import statistics
from collections import defaultdict

import demo_runs
import stats

NAME = "couplings.csv"
KEYS = ["scenario", "scheme", "profile", "seed", "seconds"]
SECONDS = {"cubes": 20, "room": 40, "piano": 22, "cliff": 6}
MOST_SEEDS = {"cliff": 1}  # a thousand bodies are many samples
# Name, options, and what it is.
SCHEMES = {
    "one-pass": ([], "the default: targets in the solver's pass, our prediction and rules"),
    "two-step": (["--coupling", "two-step"],
                 "averaged before the step, with our prediction and rules: only the coupling differs"),
    "euler": (["--predictor", "euler"], "the default with states carried to now by velocity"),
    "one-pass-plain": (["--coupling", "one-pass-plain"],
                       "in the pass, with the paper's prediction (Euler) and share"),
    "two-step-plain": (["--coupling", "two-step-plain"],
                       "before the step, with the paper's prediction and share, no thresholds"),
    "two-step-paper": (["--coupling", "two-step-paper"], "as published: and with its thresholds"),
    "single-owner": (["--coupling", "single-owner"], "the transactional scheme"),
    "pd": (["--coupling", "pd"], "virtual coupling by spring and damper"),
    "none": (["--coupling", "none"], "no consensus; springs are shared all the same"),
    "bullet": (["--engines", "bullet", "--coupling", "two-step-paper"],
               "PhysX-style: as published, in front of Bullet"),
    "bullet-50": (["--engines", "bullet", "--coupling", "two-step-paper", "--iterations", "1,50"],
                  "the same with 50 iterations instead of 10"),
}
BULLET_SCENES = ("cubes", "cliff")
# What agrees without giving up that nobody owns anything.
RIVALS = ("one-pass", "two-step", "euler", "one-pass-plain", "two-step-plain", "two-step-paper")
MEASURES = {
    "moving p50, mm": "moving_p50_mm",
    "all p95, mm": "all_p95_mm",
    "all p99, mm": "all_p99_mm",
    "resting p50, mm": "resting_p50_mm",
    "overlap p99, mm": "overlap_p99_mm",
    "overlap max, mm": "overlap_max_mm",
    "correction p99, mm": "correction_p99_mm",
    "jerk rms, m/s3": "jerk_rms",
    "free speed p50, m/s": "free_speed_p50_m_s",
    "E displacement, J": "e_displacement_J",
    "E velocity, J": "e_velocity_J",
    "E potential, J": "e_potential_J",
    "CPU, s": "cpu_s",
}
PROFILES = [1, 2, 3, 4, 5]


def _cells(profiles, seeds, with_bullet):
    for scenario, seconds in SECONDS.items():
        for seed in demo_runs.seeds(min(seeds, MOST_SEEDS.get(scenario, seeds))):
            for profile in profiles:
                for scheme, (options, _) in SCHEMES.items():
                    if scheme.startswith("bullet") and (
                            scenario not in BULLET_SCENES or not with_bullet):
                        continue
                    yield {"scenario": scenario, "scheme": scheme, "profile": profile,
                           "seed": seed, "seconds": seconds, "options": options}


def measure(binaries, results, seeds, jobs, quick):
    cells = _cells([1, 3, 5] if quick else PROFILES, seeds, demo_runs.has_bullet(binaries))
    demo_runs.measure(results / NAME, list(cells), KEYS, binaries, jobs)


def _verdict(ours, theirs, column):
    """Ratio theirs over ours, seed by seed; differences below 0.1 mm count as equal."""
    ratios = []
    for a, b in zip(ours, theirs):
        x, y = demo_runs.number(a, column), demo_runs.number(b, column)
        if x is None or y is None:
            continue
        ratios.append(1.0 if abs(x - y) < 0.1 else y / max(x, 1e-6))
    mean, half = stats.interval(ratios)
    if mean is None:
        return "-"
    return f"{mean:.2f}" if half is None else f"{mean:.2f} ± {half:.2f}"


def _text(rows, column):
    mean, half = stats.interval(demo_runs.numbers(rows, column))
    return "-" if mean is None else stats.short(mean) + (
        "" if half is None else f" ± {stats.short(half)}")


def _compare(runs_of, ours, theirs):
    """Cells in which the second scheme is better, equal and worse than the first, beyond the seeds'
    interval, and the geometric mean of ratios; by measure."""
    lines = []
    for name, column in list(MEASURES.items())[:8]:
        better = worse = equal = 0
        logs = []
        for scenario in SECONDS:
            for profile in PROFILES:
                pairs = [(demo_runs.number(a, column), demo_runs.number(b, column))
                         for a, b in zip(runs_of[scenario, ours, profile],
                                         runs_of[scenario, theirs, profile])]
                ratios = [0.0 if abs(x - y) < 0.1 else math.log(max(y, 1e-6) / max(x, 1e-6))
                          for x, y in pairs if x is not None and y is not None]
                mean, half = stats.interval(ratios)
                if mean is None:
                    continue
                logs.append(mean)
                half = half if half is not None else 0.1  # one seed: a tenth counts as nothing
                better += mean + half < 0.0
                worse += mean - half > 0.0
                equal += abs(mean) <= half
        if logs:
            lines.append(f"| {name} | {math.exp(statistics.fmean(logs)):.2f} | {worse} | {equal} | "
                         f"{better} |")
    return lines


def _not_the_best(runs_of):
    """Cells in which another scheme has less than 0.9 of what the default has apart."""
    lines = []
    for scenario in SECONDS:
        for profile in PROFILES:
            for name, column in list(MEASURES.items())[:3]:
                means = {}
                for scheme in RIVALS:
                    runs = runs_of[scenario, scheme, profile]
                    if runs and all(r["stable"] == "1" for r in runs):
                        means[scheme] = stats.interval(demo_runs.numbers(runs, column))[0]
                means = {k: v for k, v in means.items() if v is not None}
                if "one-pass" not in means:
                    continue
                best = min(means, key=means.get)
                if means[best] < 0.9 * means["one-pass"] and means["one-pass"] - means[best] > 0.1:
                    lines.append(f"| {scenario} | {profile} | {name} | {stats.short(means['one-pass'])} "
                                 f"| {best}: {stats.short(means[best])} |")
    return lines


def _findings(runs_of):
    seeds = {s: max((len(v) for k, v in runs_of.items() if k[0] == s), default=0) for s in SECONDS}
    lines = ["## Findings", "",
             "Sample: " + ", ".join(f"{s} {SECONDS[s]} s, {n} seed{'s' if n > 1 else ''}"
                                    for s, n in seeds.items())
             + "; profiles 1 to 5; two peers. What two steps leave over what one pass leaves, with the "
             "same replayed mean as target, geometric mean over cells of scenario and profile; and in "
             "how many cells one pass is better, neither, or two steps are, beyond the 95 % interval of "
             "the seeds. Differences below 0.1 mm count as equal.", "",
             "| measure | two steps / one pass | one pass is better | neither | two steps are better |",
             "|---|---|---|---|---|", *_compare(runs_of, "one-pass", "two-step"), ""]
    rivals = _not_the_best(runs_of)
    lines += [f"Cells in which one of {', '.join(RIVALS[1:])} has less than 0.9 of what the default has "
              "apart (mm, means over seeds; only schemes that are stable in all of them; slower motion "
              "is less apart, see free speed and energy below):", "",
              *(["| scenario | profile | measure | default | best |", "|---|---|---|---|---|", *rivals]
                if rivals else ["none."]), ""]
    return lines


def report(results, _docs):
    path = results / NAME
    if not path.exists():
        raise FileNotFoundError(2, "no such table", str(path))
    runs_of = defaultdict(list)
    for row in sorted(demo_runs.read(path), key=lambda r: int(r["seed"])):
        runs_of[row["scenario"], row["scheme"], int(row["profile"])].append(row)
    lines = [
        *_findings(runs_of),
        "## The couplings",
        "",
        "Two peers, the same scenes, links, seeds and recorded inputs for all; means over seeds ± half "
        "of the 95 % confidence interval. What is averaged, predicted and heard is the same in "
        "*one-pass* and *two-step*, and in the two that are *plain*: there only the coupling differs. "
        "Stable means that nothing got lost or broke and that, in cubes, what nobody touches stands to "
        "5 mm; Bullet's stacks settle by more than that by themselves. The energy of agreement is the "
        "solver's own account, which two steps bypass. Low divergence is not all: averages of late "
        "states slow down what moves (energy through velocities).",
        "",
        "| scheme | what it is |",
        "|---|---|",
    ]
    lines += [f"| {name} | {text} |" for name, (_, text) in SCHEMES.items()]
    lines += ["", "### Two steps over one pass", "",
              "Ratios of each seed's figures, two steps over one pass: above 1 one pass is better. "
              "Differences below 0.1 mm count as equal.", "",
              "| scenario | profile | moving p50, ours | all p95, ours | overlap max, ours | "
              "moving p50, plain | all p95, plain | overlap max, plain |", "|---|---|---|---|---|---|---|---|"]
    for scenario in SECONDS:
        for profile in PROFILES:
            row = [scenario, str(profile)]
            for ours, theirs in (("one-pass", "two-step"), ("one-pass-plain", "two-step-plain")):
                for column in ("moving_p50_mm", "all_p95_mm", "overlap_max_mm"):
                    row.append(_verdict(runs_of[scenario, ours, profile],
                                        runs_of[scenario, theirs, profile], column))
            lines.append("| " + " | ".join(row) + " |")
    for scenario in SECONDS:
        lines += ["", f"### {scenario}", "",
                  "| profile | scheme | stable | " + " | ".join(MEASURES) + " |",
                  "|---|---|---|" + "---|" * len(MEASURES)]
        for profile in PROFILES:
            for scheme in SCHEMES:
                runs = runs_of[scenario, scheme, profile]
                if not runs:
                    continue
                stable = sum(1 for r in runs if r["stable"] == "1")
                lines.append(f"| {profile} | {scheme} | {stable} of {len(runs)} | "
                             + " | ".join(_text(runs, c) for c in MEASURES.values()) + " |")
    return "\n".join(lines)
