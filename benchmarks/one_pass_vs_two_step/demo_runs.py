# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Runs of the demos for the sections: users' inputs are recorded with the default coupling and replayed with all
others; one line of a CSV per run."""
import csv
import json
import subprocess
import tempfile
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import stats

first_seed = 1  # of all sections; the others follow
VARIANT = {"piano": ["--variant", "soft"]}
# Column, place in a result, factor.
MEASURES = {
    "cpu_us": ("step_cpu_us", 1.0),
    "cpu_s": ("cpu_s", 1.0),
    "moving_p50_mm": ("divergence_shared_moving_m.p50", 1e3),
    "all_p95_mm": ("divergence_shared_m.p95", 1e3),
    "all_p99_mm": ("divergence_shared_m.p99", 1e3),
    "resting_p50_mm": ("divergence_resting_m.p50", 1e3),
    "overlap_p99_mm": ("penetration_m.p99", 1e3),
    "overlap_max_mm": ("penetration_m.max", 1e3),
    "correction_p99_mm": ("smoothness.correction_m.p99", 1e3),
    "jerk_rms": ("smoothness.jerk_rms_m_s3", 1.0),
    "free_speed_p50_m_s": ("smoothness.free_speed_m_s.p50", 1.0),
    "peak_speed_m_s": ("peak_speed_m_s", 1.0),
    "e_displacement_J": ("energy_J.displacement", 1.0),
    "e_velocity_J": ("energy_J.velocity_agreement", 1.0),
    "e_potential_J": ("energy_J.potential", 1.0),
}
COLUMNS = ["stable", *MEASURES]


def seeds(count):
    return range(first_seed, first_seed + count)


def has_bullet(binaries):
    """True if the demos were built with Bullet."""
    tried = subprocess.run([str(binaries / "cubes"), "--print", "nothing", "--seconds", "0.1", "--engines",
                            "bullet"], capture_output=True, check=False, text=True)
    return "--engines" not in tried.stderr


def _command(binaries, cell):
    return [str(binaries / cell["scenario"]), "--print", "nothing", "--profile", str(cell["profile"]),
            "--seed", str(cell["seed"]), "--seconds", str(cell["seconds"]),
            *VARIANT.get(cell["scenario"], [])]


def _inputs(folder, cell):
    return folder / (f"{cell['scenario']}-p{cell['profile']}-s{cell['seed']}"
                     f"-{cell['seconds']}.inputs")


def _record(binaries, folder, cell):
    path = _inputs(folder, cell)
    newest = (binaries / cell["scenario"]).stat().st_mtime
    if path.exists() and path.stat().st_mtime >= newest:
        return
    subprocess.run(_command(binaries, cell) + ["--record", str(path)], stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL, check=False)


def _run(binaries, folder, cell, keys):
    with tempfile.NamedTemporaryFile(suffix=".json") as out:
        done = subprocess.run(
            _command(binaries, cell) + cell["options"]
            + ["--script", str(_inputs(folder, cell)), "--json", out.name],
            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, check=False, text=True)
        text = Path(out.name).read_text()
    row = {k: str(cell[k]) for k in keys}
    if not text:
        # 1: the run failed, as by a state that is not finite. Other codes are errors of the call.
        if done.returncode != 1:
            raise RuntimeError(f"{cell}: {done.stderr.strip()}")
        return row | dict.fromkeys(COLUMNS) | {"stable": 0}
    result = json.loads(text)
    row["stable"] = int(result["stable"])
    for name, (path, factor) in MEASURES.items():
        value = stats.get(result, path)
        row[name] = None if value is None else f"{factor * value:.6g}"
    return row


def read(path):
    if not path.exists():
        return []
    with path.open() as file:
        return list(csv.DictReader(file))


def measure(path, cells, keys, binaries, jobs):
    """Runs the cells (dicts with scenario, profile, seed, seconds, options and all of `keys`) that are missing from the
    CSV at `path`; starts again if a program is newer."""
    newest = max((binaries / c["scenario"]).stat().st_mtime for c in cells)
    rows = read(path) if path.exists() and path.stat().st_mtime >= newest else []
    have = {tuple(r[k] for k in keys) for r in rows}
    missing = [c for c in cells if tuple(str(c[k]) for k in keys) not in have]
    if not missing:
        return
    folder = path.parent / "inputs"
    folder.mkdir(parents=True, exist_ok=True)
    recorded = {_inputs(folder, c): c for c in missing}
    with ThreadPoolExecutor(jobs) as pool, path.open("w", newline="") as file:
        table = csv.DictWriter(file, [*keys, *COLUMNS])
        table.writeheader()
        table.writerows(rows)
        list(pool.map(lambda c: _record(binaries, folder, c), recorded.values()))
        for row in pool.map(lambda c: _run(binaries, folder, c, keys), missing):
            table.writerow(row)
            file.flush()


def number(row, column):
    """A float, or None if it is missing."""
    text = row.get(column)
    return float(text) if text not in (None, "") else None


def numbers(rows, column):
    return [v for v in (number(r, column) for r in rows) if v is not None]
