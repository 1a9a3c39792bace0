# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""The cells of the matrix: their options, runs and results."""
import json
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path

# s of session time: the length of the script.
SECONDS = {"cubes": 20, "room": 40, "tennis": 20, "piano": 22, "cliff": 8}
# [friston] Sec. 7.1, besides the default: soft, or asymmetric for the piano.
MODES = {"cubes": ("asymmetric", "hard"), "room": ("asymmetric", "hard"), "piano": ("hard",)}
# Records of a room's page, of users A and B, and the scenes that replay them; see docs/hands.md.
HANDS = [str(Path(__file__).resolve().parents[1] / "data/hands" / f"synthetic-pointer-{i}.txt") for i in (1, 2)]
RECORDED = ("cubes", "room", "piano")
RECORDED_SECONDS = 32  # the longest record
MOTION = "motion"  # check of speeds, see motion.cpp


@dataclass(frozen=True)
class Cell:
    scenario: str
    variant: str
    profile: int
    seed: int
    seconds: float

    @property
    def name(self):
        return f"{self.scenario}-{self.variant}-p{self.profile}-s{self.seed}-{self.seconds:g}"

    def recorded(self, folder):
        """The recorded inputs, for a replay with other options."""
        return folder / f"{self.name}.inputs"

    def command(self, binaries, folder):
        args = [str(binaries / self.scenario), "--print", "nothing", "--profile", str(self.profile),
                "--seed", str(self.seed), "--seconds", f"{self.seconds:g}"]
        extra = {
            "default": ["--reference", "--record", str(self.recorded(folder))],
            "control": ["--influence", "0"],
            "soft": ["--variant", "soft"],
            "mouse": ["--variant", "mouse"],
            "tug": ["--variant", "tug"],
            "live": [],
            "recorded": ["--script", "hands=" + ",".join(HANDS)],
            "uneven": ["--rates", "60,72"],
            "asymmetric": ["--mode", "asymmetric"],
            # The piano's default springs are asymmetric in every mode.
            "hard": ["--mode", "hard"] + (["--variant", "soft"] if self.scenario == "piano" else []),
        }[self.variant]
        return args + extra


def matrix(scenarios, profiles, first_seed, seed_count, quick):
    """In order of running: the most important first."""
    first, second = [], []
    for scenario in scenarios:
        seconds = SECONDS[scenario]
        if quick and scenario == "cliff":
            seconds = 6
        for seed in range(first_seed, first_seed + seed_count):
            def add(where, variant, profile, length=seconds):
                where.append(Cell(scenario, variant, profile, seed, length))

            for profile in profiles:
                add(first, "default", profile)
                add(second, "control", profile)
                if scenario == "piano":
                    add(second, "soft", profile)
            if 5 in profiles:
                if scenario == "piano":
                    add(second, "mouse", 5)
                    add(second, "tug", 5)
                if scenario != "cliff" or seed == first_seed:
                    add(second, "uneven", 5)
            if scenario in RECORDED:
                for profile in profiles[::2]:
                    add(second, "recorded", profile, RECORDED_SECONDS)
            if scenario in MODES and seed < first_seed + 2:
                for profile in profiles[::2]:
                    for mode in MODES[scenario]:
                        add(second, mode, profile)
            if scenario == "tennis":
                add(second, "live", 0)  # without latency
    return first, second


def recorded(scenarios, profiles, first_seed, seed_count):
    """Recorded hands, and scripted ones for comparison."""
    return ([Cell(s, variant, p, seed, RECORDED_SECONDS if variant == "recorded" else SECONDS[s])
             for s in RECORDED if s in scenarios
             for seed in range(first_seed, first_seed + seed_count)
             for p in profiles for variant in ("recorded", scripted(s))],)


def scripted(scenario):
    """The variant in which all peers know all springs, as they know those of recorded hands."""
    return "soft" if scenario == "piano" else "default"


def _fresh(path, binary):
    return path.exists() and path.stat().st_mtime >= binary.stat().st_mtime


def _run(cell, binaries, folder):
    result = folder / f"{cell.name}.json"
    if _fresh(result, binaries / cell.scenario):
        return
    part = folder / f"{cell.name}.part"
    done = subprocess.run(cell.command(binaries, folder) + ["--json", str(part)],
                          stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False, text=True)
    if not part.exists():
        raise RuntimeError(f"{cell.name}: {done.stderr.strip()}")
    part.rename(result)


def _bar(done, total, start):
    if not sys.stderr.isatty() and done % 20 and done != total:
        return
    passed = time.monotonic() - start
    width = 40
    full = width * done // max(total, 1)
    end = "\r" if sys.stderr.isatty() and done != total else "\n"
    print(f"[{'#' * full}{'.' * (width - full)}] {done}/{total}, {passed:.0f} s", end=end,
          file=sys.stderr, flush=True)


def run_all(rounds, binaries, out, jobs):
    folder = out / "cells"
    folder.mkdir(parents=True, exist_ok=True)
    motion = binaries / MOTION
    if motion.exists() and not _fresh(out / "motion.json", motion):
        (out / "motion.json").write_text(
            subprocess.run([str(motion)], check=True, capture_output=True, text=True).stdout)
    total = sum(len(cells) for cells in rounds)
    done = 0
    start = time.monotonic()
    for cells in rounds:
        # The longest first, so that none runs alone at the end.
        order = sorted(cells, key=lambda c: c.scenario not in ("cliff", "cubes"))
        with ThreadPoolExecutor(jobs) as pool:
            for future in as_completed([pool.submit(_run, c, binaries, folder) for c in order]):
                future.result()
                done += 1
                _bar(done, total, start)


def load(rounds, out):
    """{(scenario, variant, profile): [result per seed]}, without missing cells."""
    results = {}
    for cells in rounds:
        for cell in cells:
            path = out / "cells" / f"{cell.name}.json"
            if path.exists():
                key = (cell.scenario, cell.variant, cell.profile)
                results.setdefault(key, []).append(json.loads(path.read_text()))
    return results
