#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Runs the cubes demo over profiles and seeds, and prints what the paper's Figure 9 shows.

    python3 benchmarks/cubes_matrix.py build/release/bin/cubes --seeds 5 --csv matrix.csv
"""
import argparse
import csv
import itertools
import json
import statistics
import subprocess
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

VARIANTS = {
    "one-pass": [],
    "no agreement": ["--influence", "0"],
    "two-step": ["--coupling", "two-step"],
    "euler": ["--predictor", "euler"],
    "uneven": ["--rates", "60,72"],
}
CLASSES = ("divergence_m", "divergence_contested_m", "divergence_moving_m", "divergence_resting_m")


def run(binary, variant, profile, seed, seconds):
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "result.json"
        subprocess.run(
            [binary, "--print", "nothing", "--profile", str(profile), "--seed", str(seed),
             "--seconds", str(seconds), "--json", str(out), *VARIANTS[variant]],
            check=False, stdout=subprocess.DEVNULL)
        return json.loads(out.read_text())


def mm(result, name, quantile):
    value = result[name][quantile]
    return float("nan") if value is None else 1e3 * value


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binary")
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--seconds", type=float, default=20)
    parser.add_argument("--profiles", type=int, nargs="*", default=[1, 2, 3, 4, 5])
    parser.add_argument("--variants", nargs="*", default=list(VARIANTS), choices=list(VARIANTS))
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--csv")
    args = parser.parse_args()

    cells = list(itertools.product(args.variants, args.profiles, range(1, args.seeds + 1)))
    with ThreadPoolExecutor(args.jobs) as pool:
        results = list(pool.map(lambda c: run(args.binary, *c, args.seconds), cells))

    rows = []
    for (variant, profile, seed), r in zip(cells, results):
        row = {"variant": variant, "profile": profile, "seed": seed, "stable": r["stable"]}
        for name in CLASSES:
            for q in ("p50", "p95", "p99", "max"):
                row[f"{name[:-2]}_{q}_mm"] = mm(r, name, q)
        row["penetration_max_mm"] = 1e3 * r["penetration_m"]["max"]
        for term, joule in r["energy_J"].items():
            row[f"energy_{term}_J"] = joule
        row["step_ms_p50"] = r["step_ms"]["p50"]
        row["hash"] = r["hash"]
        rows.append(row)
    if args.csv:
        with open(args.csv, "w", newline="") as file:
            writer = csv.DictWriter(file, rows[0].keys())
            writer.writeheader()
            writer.writerows(rows)

    print("Divergence in mm, median over seeds (worst seed):")
    print("| variant | profile | stable | resting p50 | moving p50 | contested p50 | all p95 | all p99 | penetration max |")
    print("|---|---|---|---|---|---|---|---|---|")
    for variant, profile in itertools.product(args.variants, args.profiles):
        group = [r for r in rows if r["variant"] == variant and r["profile"] == profile]

        def cell(key):
            values = [r[key] for r in group]
            return f"{statistics.median(values):.3g} ({max(values):.3g})"

        stable = sum(r["stable"] for r in group)
        print(f"| {variant} | {profile} | {stable}/{len(group)} | "
              + " | ".join(cell(k) for k in (
                  "divergence_resting_p50_mm", "divergence_moving_p50_mm",
                  "divergence_contested_p50_mm", "divergence_p95_mm", "divergence_p99_mm",
                  "penetration_max_mm")) + " |")
    return 0 if all(r["stable"] for r in rows) else 1


if __name__ == "__main__":
    sys.exit(main())
