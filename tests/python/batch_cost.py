# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""What a batch of worlds of ten bodies costs beside the loop in C++: batch_cost.py REFERENCE [KIND] [ROUNDS]."""

# CPU time, in turn, median of the ratios, with the package in PYTHONPATH. Not a test: it measures. KIND is
# boxes (they pile up) or balls (they fall: the cheapest step there is).

import statistics
import subprocess
import sys
import time

import tandem
from scenes import ten_bodies

PROGRAM, WORLDS = sys.argv[1], 1000
KINDS = sys.argv[2:3] or ["boxes", "balls"]
ROUNDS = int(sys.argv[3]) if len(sys.argv) > 3 else 15


def cpu_of(action) -> float:
    begin = time.process_time()  # of all threads
    action()
    return time.process_time() - begin


def compare(kind: str, threads: int, steps: int, rounds: int = ROUNDS) -> None:
    batch = tandem.Batch([ten_bodies(i, kind) for i in range(WORLDS)], threads=threads)
    loop = subprocess.Popen(
        [PROGRAM, "loop", kind, str(WORLDS)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )

    def in_cpp() -> float:
        print(steps, file=loop.stdin, flush=True)
        return float(loop.stdout.readline())

    def here() -> float:
        return cpu_of(lambda: batch.step(1 / 60, steps))

    in_cpp(), here()
    ratios, cpp = [], []
    for turn in range(rounds):
        # The order alternates: the second one runs on a warm or throttled machine.
        a, b = (in_cpp(), here()) if turn % 2 == 0 else (here(), in_cpp())[::-1]
        ratios.append(b / a)
        cpp.append(a)
    loop.stdin.close()
    loop.wait()
    low, middle, high = (sorted(ratios)[i] for i in (0, rounds // 2, rounds - 1))
    each = 1e6 * statistics.median(cpp) / WORLDS / steps
    print(
        f"{kind:6s} threads {threads} steps {steps:2d}: C++ {each:6.2f} us for a world and step, "
        f"batch {middle:.3f} times that ({low:.3f} to {high:.3f})"
    )


for kind in KINDS:
    for threads in (1, 2):
        for steps in (1, 10):
            compare(kind, threads, steps)
