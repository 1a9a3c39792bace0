#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Prediction with rollback compared with agreement and single owners (docs/rollback.md).

  benchmarks/rollback.py BIN run     benchmarks/data/rollback.csv, a line per run
  benchmarks/rollback.py BIN tables  means over seeds, in docs/rollback/*.csv and here; the page shows some of them

Runs bin/rollback over scenes, networks, people and seeds. BIN is the folder of a build. Processor time depends on other
load on the machine: compare it within one run.
"""
import argparse
import concurrent.futures
import csv
import math
import pathlib
import subprocess
import sys

sys.dont_write_bytecode = True
import pages

PAGE = pathlib.Path(__file__).parents[1] / "docs/rollback.md"
DATA = pathlib.Path(__file__).parent / "data/rollback.csv"
WAYS = ["tandem", "owner", "owner-shown", "rollback-0", "rollback-0-12", "rollback-0-12-100", "rollback-3-12"]
LONG = ["cubes", "room", "piano", "tennis"]


def cells():
    """Options of each run."""
    for scene in LONG:
        for profile in range(1, 6):
            yield {"scene": scene, "profile": profile}
    # Its springs are inputs, which rollback sends to all; agreement only does so in this variant.
    for profile in 3, 5:
        yield {"scene": "piano", "variant": "soft", "profile": profile}
    for scene in "cliff", "pile":
        for profile in 3, 5:
            yield {"scene": scene, "profile": profile}
    for people, profile in (2, 1), (2, 3), (2, 5), (3, 3), (3, 5), (6, 3):
        yield {"scene": "table", "people": people, "profile": profile}
    for scene in "cubes", "table":
        yield {"scene": scene, "profile": 3, "people": 3, "network": "wifi"}
        yield {"scene": scene, "profile": 3, "case": "differ"}
        yield {"scene": scene, "profile": 3, "people": 3, "case": "late"}
    # With 5 frames per packet an occasional gap would remain.
    yield {"scene": "cubes", "profile": 5, "people": 3, "loss": 0.1, "redundancy": 10}
    yield {"scene": "cubes", "profile": 5, "people": 3, "case": "late"}


def run(binary, seeds, jobs):
    def one(cell):
        words = [f"--{name}={value}" for name, value in cell.items()]
        words += [f"--seconds={20 if cell['scene'] in LONG else 10}", "--ways=" + ",".join(WAYS), "--header"]
        out = subprocess.run([binary / "rollback", *words], check=True, capture_output=True, text=True)
        print(" ".join(words[:-2]), file=sys.stderr, flush=True)
        return out.stdout.splitlines()

    lines = []
    todo = [{**cell, "seed": seed} for seed in seeds for cell in cells()]
    with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
        for header, *rows in pool.map(one, todo):
            lines += rows if lines else [header, *rows]
            DATA.write_text("\n".join(lines) + "\n")


SHOWN = ["tandem", "owner", "owner-shown", "rollback-0-12", "rollback-0-12-100", "rollback-3-12"]


def mean(rows, column):
    values = [float(row[column]) for row in rows]
    result = sum(values) / len(values) if values else math.nan
    return "-" if math.isnan(result) else f"{result:.0f}" if result >= 100 else f"{result:.2g}"


def table(file, name, keys, columns, rows):
    """A line per each of `keys` (values of the CSV's columns), means over seeds: printed, and as CSV."""
    lines = []
    for label, key in keys.items():
        cell = [[row for row in rows if row["way"] == way and all(row[c] == v for c, v in key.items())]
                for way in SHOWN]
        lines.append([label, *(" / ".join(mean(group, column) for column in columns) for group in cell),
                      str(len(cell[0]))])
    found = pages.table([name, *SHOWN, "seeds"], lines)
    print("", *found, sep="\n")
    pages.aside(PAGE, file, found)


def tables():
    rows = list(csv.DictReader(DATA.open()))
    plain = {"variant": "", "network": "", "case": "plain", "loss": "0"}
    keys = {}
    for scene, people in [(scene, "2") for scene in ("cubes", "room", "piano", "tennis", "cliff", "pile")] + [
            ("table", "2"), ("table", "3"), ("table", "6")]:
        for profile in "12345":
            key = {"scene": scene, "people": people, "profile": profile, **plain}
            if any(all(row[c] == v for c, v in key.items()) for row in rows):
                keys[f"{scene}, {people} people, profile {profile}"] = key
    for profile in "35":
        keys[f"piano, soft, 2 people, profile {profile}"] = {
            "scene": "piano", "people": "2", "profile": profile, **plain, "variant": "soft"}
    others = {"3 people, a tenth lost": {"loss": "0.1"}, "3 people, wifi": {"network": "wifi"},
              "engines that differ": {"case": "differ"}, "3 people, the last late": {"case": "late"}}
    special = {f"{scene}, {label}, profile {profile}": {"scene": scene, "profile": profile, **key}
               for scene in ("cubes", "table") for label, key in others.items() for profile in "35"
               if any(all(row[c] == v for c, v in {"scene": scene, "profile": profile, **key}.items()) for row in rows)}
    keys.update(special)
    table("apart_and_jumps", "apart p95, mm / jump p99, mm / largest jump, mm", keys,
          ["moving_p95_mm", "jump_p99_mm", "jump_max_mm"], rows)
    table("stretch", "stretch p95, mm: held by one / by several", keys,
          ["stretch_one_p95_mm", "stretch_several_p95_mm"], rows)
    table("cost", "processor time, ms: mean / p50 / p99 / solver steps a frame / kB/s", keys,
          ["cpu_mean_ms", "cpu_p50_ms", "cpu_p99_ms", "steps_per_frame", "kbyte_per_s"], rows)
    table("special", "frames stalled / s to come in / first frame that differs (-1: none)", special,
          ["stalled", "joined_s", "desync_frame"], rows)
    table("faults", "peers with faults", keys, ["faults"], rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary", type=pathlib.Path, metavar="BIN")
    parser.add_argument("what", choices=["run", "tables"])
    parser.add_argument("--seeds", type=int, nargs="+", default=[911, 912, 913])
    parser.add_argument("--jobs", type=int, default=2)
    args = parser.parse_args()
    if args.what == "run":
        run(args.binary, args.seeds, args.jobs)
    tables()


if __name__ == "__main__":
    main()
