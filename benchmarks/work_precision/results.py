# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The CSV of runs: reading it, medians over repeats, fronts of error against time."""
import csv
import math
import statistics

ENGINES = {"tandem": "Tandem", "bullet64": "Bullet double", "bullet32": "Bullet single"}
# Optional engines: at their defaults only.
PEERS = {"jolt": "Jolt", "box3d": "Box3D", "physx_pgs": "PhysX PGS", "physx_tgs": "PhysX TGS"}
NAMES = ENGINES | PEERS

# Measures of each scene: (measure, factor to the unit, unit). The first is plotted first.
ERRORS = {
    "stacks": [("drift_end", 1e3, "top drift, mm"),
               ("penetration_mean_end", 1e3, "mean overlap, mm")],
    "chain": [("separation_max", 1e3, "largest separation, mm"),
              ("ball_error_max", 1.0, "largest ball error, m")],
    "ratio": [("top_error", 1e3, "top error, mm")],
    "pyramid": [("drift_end", 1e3, "largest drift, mm"),
                ("penetration_mean_end", 1e3, "mean overlap, mm")],
    "katamari": [("penetration_mean_end", 1e3, "mean overlap, mm"),
                 ("penetration_max_run", 1e3, "largest overlap, mm")],
    "cliff": [("penetration_mean_end", 1e3, "mean overlap, mm"),
              ("penetration_max_run", 1e3, "largest overlap, mm")],
    "heap": [("penetration_mean_end", 1e3, "mean overlap, mm"),
             ("penetration_max_run", 1e3, "largest overlap, mm")],
}


class Point:
    """One engine at one setting: times over the repeats, and results."""

    def __init__(self, rows):
        first = rows[0]
        self.engine, self.scene, self.setting = first["engine"], first["scene"], first["setting"]
        self.values = {k: number(v) for k, v in first.items()
                       if k not in ("engine", "scene", "setting", "hash")}
        self.hashes = {r.get("hash", "") for r in rows}  # of the last frame's states: must be one
        self.wall_times = sorted(number(r["wall_ms_mean"]) for r in rows)
        # Mean over the frames, to include expensive ones.
        self.times = sorted(number(r["cpu_ms_mean"]) for r in rows)
        self.median_times = sorted(number(r["cpu_ms_p50"]) for r in rows)

    @property
    def time(self):
        """ms for a frame of 1/60 s: mean over the frames, median over the repeats."""
        return statistics.median(self.times)

    @property
    def median_time(self):
        """ms: median over the frames and over the repeats."""
        return statistics.median(self.median_times)

    @property
    def wall_time(self):
        """ms, wall time: mean over the frames, median over the repeats."""
        return statistics.median(self.wall_times)

    def value(self, name):
        return self.values.get(name, math.nan)

    def error(self, name, factor=1.0):
        return abs(self.value(name)) * factor


def number(text):
    try:
        return float(text)
    except (TypeError, ValueError):
        return math.nan


def read(path):
    groups = {}
    with open(path, newline="") as file:
        for row in csv.DictReader(file):
            groups.setdefault((row["engine"], row["scene"], row["setting"]), []).append(row)
    return [Point(rows) for rows in groups.values()]


def write(path, rows):
    names = []
    for row in rows:
        names += [k for k in row if k not in names]
    with open(path, "w", newline="") as file:
        writer = csv.DictWriter(file, names, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def select(points, engine=None, scene=None, setting=None):
    """Those with these names; runs on several threads only if the setting is asked for."""
    return [p for p in points
            if engine in (None, p.engine) and scene in (None, p.scene)
            and (p.setting == setting if setting else "threads" not in p.setting)]


def default_of(points, engine, scene):
    found = select(points, engine, scene, "default")
    return found[0] if found else None


def front(points, measure):
    """Those that no other beats in both time and error, by rising time."""
    best = math.inf
    result = []
    for p in sorted(points, key=lambda p: (p.time, p.error(measure))):
        if p.error(measure) < best:
            best = p.error(measure)
            result.append(p)
    return result


def best_until(line, measure, time):
    return min(p.error(measure) for p in line if p.time <= time)


def compare_fronts(ours, theirs, measure):
    """(times at which our front has no more error than theirs, times compared): every step of
    either front once both have a point."""
    fronts = [front(ours, measure), front(theirs, measure)]
    if not all(fronts):
        return 0, 0
    start = max(line[0].time for line in fronts)
    times = [start] + [p.time for line in fronts for p in line if p.time > start]
    below = sum(best_until(fronts[0], measure, t) <= best_until(fronts[1], measure, t)
                for t in times)
    return below, len(times)
