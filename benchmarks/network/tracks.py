# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Divergence from the tracks that both processes of a session recorded of their own bodies, by the
rules of demos/measures/metrics.cpp and demos/session/track.cpp."""
import bisect
import csv
import json
import math

MOVING = 0.05  # m/s, kMovingSpeed
HIT = 40.0  # m/s^2, kHitAcceleration
OWNED = ("head/", "hand/", "racket/")  # moved by one user alone


def _load(folder, name, peer):
    """{body: [(time in ns, position, velocity, users)]} of a process's own peer."""
    start = json.loads((folder / f"{name}.json").read_text())["tables_start_ns"]
    bodies = {}
    with (folder / name / "tracks.csv").open() as file:
        for row in csv.DictReader(file):
            if row["peer"] != str(peer) or row["body"].startswith(OWNED):
                continue
            bodies.setdefault(row["body"], []).append(
                (start + round(1e9 * float(row["time_s"])),
                 tuple(float(row[k]) for k in ("x", "y", "z")),
                 tuple(float(row[k]) for k in ("vx", "vy", "vz")), int(row["users"])))
    return bodies


def _dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def _between(before, after, time):
    """Position and velocity between two samples: the cubic, or two lines with an impact."""
    dt = 1e-9 * (after[0] - before[0])
    s = 1e-9 * (time - before[0]) / dt
    way = tuple(b - a for a, b in zip(before[1], after[1]))
    change = tuple(b - a for a, b in zip(before[2], after[2]))
    if math.sqrt(_dot(change, change)) > HIT * dt:
        missing = tuple(dt * v - w for v, w in zip(after[2], way))
        at = min(1.0, max(0.0, _dot(missing, change) / (dt * _dot(change, change))))
        corner = tuple(0.5 * (at * dt * u + w - (1.0 - at) * dt * v)
                       for u, w, v in zip(before[2], way, after[2]))
        if s < at:
            moved = tuple(s / at * c for c in corner)
        else:
            rest = (1.0 - s) / max(1.0 - at, 1e-9)
            moved = tuple(w - rest * (w - c) for w, c in zip(way, corner))
    else:
        bend = s * (1.0 - s)
        moved = tuple(s * w + bend * ((1.0 - s) * (dt * u - w) - s * (dt * v - w))
                      for w, u, v in zip(way, before[2], after[2]))
    position = tuple(p + m for p, m in zip(before[1], moved))
    speed = (1.0 - s) * math.sqrt(_dot(before[2], before[2])) + s * math.sqrt(
        _dot(after[2], after[2]))
    return position, speed


def _percentiles(values):
    values.sort()
    pick = lambda p: values[max(math.ceil(p * len(values)), 1) - 1] if values else None
    return {"p50": pick(0.5), "p95": pick(0.95), "p99": pick(0.99),
            "max": values[-1] if values else None, "count": len(values)}


def divergence(folder):
    """In the form of a demo's result, for unowned bodies."""
    first, second = _load(folder, "a", 1), _load(folder, "b", 2)
    every, resting, moving = [], [], []
    for body, samples in first.items():
        other = second.get(body, [])
        times = [sample[0] for sample in other]
        for time, position, velocity, users in samples:
            i = bisect.bisect_left(times, time)
            if i == len(times) or (i == 0 and times[0] != time):
                continue
            there, speed = _between(other[i - 1], other[i], time) if i > 0 else (
                other[0][1], math.sqrt(_dot(other[0][2], other[0][2])))
            apart = math.dist(position, there)
            every.append(apart)
            fastest = max(speed, math.sqrt(_dot(velocity, velocity)))
            held = users + other[max(i - 1, 0)][3] > 0
            (moving if held or fastest > MOVING else resting).append(apart)
    return {"divergence_shared_m": _percentiles(every),
            "divergence_shared_moving_m": _percentiles(moving),
            "classes": {"resting": {"divergence_m": _percentiles(resting)}}}
