# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Couplings beside each other on the same scenes, links, inputs and shares.

What the users do is recorded with the default coupling and done again with the others, so that all
see the same inputs. Cells that are finished are kept.
"""
import csv
import json
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

import stats

SECONDS = {"cubes": 20, "room": 40, "piano": 22, "cliff": 6}
MOST_SEEDS = {"cliff": 1}  # a thousand bodies are many samples
# Name, options, and what it is.
SCHEMES = {
    "one-pass": ([], "the default: targets in the solver's pass, our prediction and rules"),
    "two-step": (["--coupling", "two-step"],
                 "averaged before the step, with our prediction and rules: only the coupling differs"),
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
    "bullet-50": (["--engines", "bullet", "--coupling", "two-step-paper", "--bullet-iterations", "50"],
                  "the same with 50 iterations instead of 10"),
}
BULLET_SCENES = ("cubes", "cliff")
MEASURES = [
    ("moving p50, mm", "divergence_shared_moving_m.p50", 1e3),
    ("all p95, mm", "divergence_shared_m.p95", 1e3),
    ("all p99, mm", "divergence_shared_m.p99", 1e3),
    ("resting p50, mm", "divergence_resting_m.p50", 1e3),
    ("overlap p99, mm", "penetration_m.p99", 1e3),
    ("overlap max, mm", "penetration_m.max", 1e3),
    ("correction p99, mm", "smoothness.correction_m.p99", 1e3),
    ("jerk rms, m/s3", "smoothness.jerk_rms_m_s3", 1.0),
    ("free speed p50, m/s", "smoothness.free_speed_m_s.p50", 1.0),
    ("E displacement, J", "energy_J.displacement", 1.0),
    ("E velocity, J", "energy_J.velocity_agreement", 1.0),
    ("E potential, J", "energy_J.potential", 1.0),
    ("CPU, s", "cpu_s", 1.0),
]


def cells(scenarios, profiles, seeds):
    for scenario in scenarios:
        for seed in range(1, min(seeds, MOST_SEEDS.get(scenario, seeds)) + 1):
            for profile in profiles:
                for scheme in SCHEMES:
                    if scheme.startswith("bullet") and scenario not in BULLET_SCENES:
                        continue
                    yield scenario, scheme, profile, seed


def path_of(folder, scenario, scheme, profile, seed):
    return folder / f"{scenario}-{scheme}-p{profile}-s{seed}.json"


def run(cell, binaries, folder):
    scenario, scheme, profile, seed = cell
    out = path_of(folder, *cell)
    if out.exists() and out.stat().st_mtime >= (binaries / scenario).stat().st_mtime:
        return
    inputs = folder / f"{scenario}-p{profile}-s{seed}.inputs"
    command = [str(binaries / scenario), "--quiet", "--profile", str(profile), "--seed", str(seed),
               "--seconds", str(SECONDS[scenario]), *SCHEMES[scheme][0]]
    if scenario == "piano":
        command += ["--variant", "soft"]
    command += ["--record", str(inputs)] if scheme == "one-pass" else ["--replay", str(inputs)]
    part = out.with_suffix(".part")
    done = subprocess.run(command + ["--json", str(part)], stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, check=False, text=True)
    if not part.exists():
        raise RuntimeError(f"{out.stem}: {done.stderr.strip()}")
    part.rename(out)


def run_all(wanted, binaries, folder, jobs):
    folder.mkdir(parents=True, exist_ok=True)
    # Inputs are recorded before they are replayed.
    rounds = [[c for c in wanted if c[1] == "one-pass"], [c for c in wanted if c[1] != "one-pass"]]
    done = 0
    for cells_of_round in rounds:
        with ThreadPoolExecutor(jobs) as pool:
            for _ in pool.map(lambda c: run(c, binaries, folder), cells_of_round):
                done += 1
                if done % 20 == 0 or done == len(wanted):
                    print(f"{done}/{len(wanted)}", file=sys.stderr, flush=True)


def load(wanted, folder):
    results = {}
    for scenario, scheme, profile, seed in wanted:
        path = path_of(folder, scenario, scheme, profile, seed)
        if path.exists():
            results.setdefault((scenario, scheme, profile), []).append(json.loads(path.read_text()))
    return results


def write_csv(results, path):
    with path.open("w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["scenario", "scheme", "profile", "seed", "stable", "fault"]
                       + [name for name, _, _ in MEASURES])
        for (scenario, scheme, profile), runs in sorted(results.items()):
            for r in runs:
                table.writerow([scenario, scheme, profile, r["seed"], r["stable"], r["fault"]]
                               + [None if stats.get(r, p) is None else f * stats.get(r, p)
                                  for _, p, f in MEASURES])


def verdict(results, scenario, profile, ours, theirs, path):
    """Ratio theirs over ours, seed by seed; differences below 0.1 mm count as equal."""
    ratios = []
    for a, b in zip(results.get((scenario, ours, profile), []),
                    results.get((scenario, theirs, profile), [])):
        x, y = stats.get(a, path), stats.get(b, path)
        if x is None or y is None:
            continue
        ratios.append(1.0 if abs(x - y) < 1e-4 else y / max(x, 1e-9))
    mean, half = stats.interval(ratios)
    if mean is None:
        return "-"
    return f"{mean:.2f}" if half is None else f"{mean:.2f} ± {half:.2f}"


PROFILES = [1, 2, 3, 4, 5]


def wanted(seeds, quick):
    return list(cells(SECONDS, [1, 3, 5] if quick else PROFILES, seeds))


def measure(binaries, results, seeds, jobs, quick):
    run_all(wanted(seeds, quick), binaries, results / "couplings", jobs)


def report(results_folder, _docs):
    results = load(wanted(9, False), results_folder / "couplings")
    write_csv(results, results_folder / "couplings.csv")
    lines = [
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
                for measure in ("divergence_shared_moving_m.p50", "divergence_shared_m.p95",
                                "penetration_m.max"):
                    row.append(verdict(results, scenario, profile, ours, theirs, measure))
            lines.append("| " + " | ".join(row) + " |")
    for scenario in SECONDS:
        lines += ["", f"### {scenario}", "",
                  "| profile | scheme | stable | " + " | ".join(n for n, _, _ in MEASURES) + " |",
                  "|---|---|---|" + "---|" * len(MEASURES)]
        for profile in PROFILES:
            for scheme in SCHEMES:
                runs = results.get((scenario, scheme, profile))
                if not runs:
                    continue
                stable = sum(1 for r in runs if r["stable"])
                lines.append(f"| {profile} | {scheme} | {stable} of {len(runs)} | "
                             + " | ".join(stats.text(runs, p, f) for _, p, f in MEASURES) + " |")
    return "\n".join(lines)
