# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Error against run time: a pendulum released at 60 degrees, after a quarter of its period.

It then hangs straight down, so that its angle is the error: half a substep's way, by which positions
and velocities of the scheme lie apart. The period is the exact one of a rigid body, by the
arithmetic-geometric mean. Prints a table; --plot draws it where matplotlib is there.
"""

import sys
import time
from math import cos, pi, radians, sin, sqrt

import tandem

ANGLE, LENGTH, RADIUS, STEPS = radians(60.0), 1.0, 0.1, 16


def quarter_period() -> float:
    """s: a ball on a massless rod turns with it, so that its moment about the pivot counts."""
    a, b = 1.0, cos(ANGLE / 2)
    while a - b > 1e-15:
        a, b = (a + b) / 2, sqrt(a * b)
    return pi / 2 * sqrt((LENGTH**2 + 0.4 * RADIUS**2) / (9.81 * LENGTH)) / a


def error_and_time(substeps: int) -> tuple[float, float]:
    scene = tandem.Scene(substeps=substeps, refine=False, sleep_after=0.0)
    ball = scene.add(tandem.Sphere(RADIUS), position=(LENGTH * sin(ANGLE), 0, -LENGTH * cos(ANGLE)))
    hinge = scene.hinge(None, ball, anchor=(0, 0, 0), axis=(0, 1, 0))
    begin = time.thread_time()
    scene.step(quarter_period() / STEPS, STEPS)
    return abs(hinge.angle - ANGLE), time.thread_time() - begin


rows = [(substeps, *error_and_time(substeps)) for substeps in (1, 2, 4, 8, 16)]
print("substeps   error, rad   CPU time, ms")
for substeps, error, cpu in rows:
    print(f"{substeps:8d} {error:12.2e} {1e3 * cpu:14.3f}")
if rows[0][1] < 8 * rows[-1][1]:
    sys.exit("the error does not fall with the number of substeps")

if "--plot" in sys.argv:
    import matplotlib.pyplot as plt  # type: ignore[import]

    plt.loglog([cpu for _, _, cpu in rows], [error for _, error, _ in rows], "o-")
    plt.xlabel("CPU time, s")
    plt.ylabel("error, rad")
    plt.show()
