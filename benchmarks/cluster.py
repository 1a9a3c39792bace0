#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Step time of each rank of tandem-cluster, as if each had its own processor.

mpirun with fewer processors than ranks only records each rank's input; then each rank is replayed alone, --repeats
times, and each step counts with its least time. The undivided world is one rank, measured in between.

    benchmarks/cluster.py build/release/bin --scene cliff --ranks 4 8
    benchmarks/cluster.py build/release/bin --scene heap --per-rank 1000 --ranks 4 16 64
"""
import argparse
import json
import os
import subprocess
import tempfile
from pathlib import Path

MPIRUN = ["mpirun", "--oversubscribe", "--allow-run-as-root", "--bind-to", "none"]


def arguments_of(options, size):
    result = [options.scene, "--seconds", str(options.seconds), "--sample-every", "0"]
    result += ["--size", str(size)] if size else []
    return result + options.more


def record(options, ranks, size, prefix):
    """Runs all ranks together. Returns rank 0's output."""
    program = [str(options.binaries / "tandem-cluster"), *arguments_of(options, size)]
    environment = dict(os.environ, OMPI_MCA_mpi_yield_when_idle="1")
    out = subprocess.run([*MPIRUN, "-n", str(ranks), *program, "--record", prefix],
                         env=environment, check=True, capture_output=True, text=True)
    return json.loads(out.stdout)


def replay(options, size, tape, expected):
    """s of each step of one rank."""
    program = [str(options.binaries / "tandem-cluster"), *arguments_of(options, size)]
    out = subprocess.run([*program, "--replay", tape], check=True, capture_output=True, text=True)
    told = json.loads(out.stdout)
    if told["last_hash"] != expected:
        raise RuntimeError(f"{tape}: the replay came to other bits")
    return told["step_s"]


def least(runs):
    return [min(step) for step in zip(*runs)]


def measure(options, ranks, size, folder):
    """The least time of each step, by rank, and the run's output."""
    prefix = str(Path(folder) / f"{options.scene}_{size}_{ranks}")
    told = record(options, ranks, size, prefix)
    steps = []
    for rank in range(ranks):
        tape = f"{prefix}.{rank}"
        steps.append(least([replay(options, size, tape, told["last_hash"])
                            for _ in range(options.repeats)]))
        os.remove(tape)
    return steps, told


def mean(values):
    return sum(values) / len(values)


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binaries", type=Path)
    parser.add_argument("--scene", default="cliff")
    parser.add_argument("--size", type=int, default=0)
    parser.add_argument("--per-rank", type=int, default=0, help="bodies; weak scaling")
    parser.add_argument("--ranks", type=int, nargs="+", default=[4])
    parser.add_argument("--seconds", type=float, default=6.0)
    parser.add_argument("--repeats", type=int, default=3)
    # Unknown options are passed to tandem-cluster.
    options, options.more = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder:
        whole, _ = measure(options, 1, options.per_rank or options.size, folder)
        print(f"{options.scene}: undivided {1e3 * mean(whole[0]):.3f} ms")
        for ranks in options.ranks:
            steps, told = measure(options, ranks, options.per_rank * ranks or options.size, folder)
            slowest = [max(step) for step in zip(*steps)]
            means = [mean(rank) for rank in steps]
            print(f"{ranks} ranks: slowest {1e3 * mean(slowest):.3f} ms, "
                  f"of undivided {mean(slowest) / mean(whole[0]):.3f}, "
                  f"mean rank {1e3 * mean(means):.3f} ms, busiest {1e3 * max(means):.3f} ms, "
                  f"imbalance {mean(slowest) / mean(means):.3f} by step "
                  f"{max(means) / mean(means):.3f} by run, "
                  f"messages {told['messages_per_rank_and_step']:.0f}, "
                  f"kB {told['bytes_per_rank_and_step'] / 1e3:.1f}", flush=True)


if __name__ == "__main__":
    main()
