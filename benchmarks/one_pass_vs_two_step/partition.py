# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""One world solved in parts, beside the same world solved by one peer."""
import csv
import json
import subprocess
from concurrent.futures import ThreadPoolExecutor

NAME = "partition.csv"
PEERS = [2, 4, 8]
LATENCIES = [0.0001, 0.001, 0.005, 0.01, 0.03]  # s
OPTIONS = {"cliff": ["--seconds", "5", "--overlap", "0.15", "--reach", "0.3"],
           "cubes": ["--seconds", "5"]}


def _cells(quick):
    for scene in OPTIONS:
        yield scene, 1, 0.001
        for peers in [4] if quick else PEERS:
            for latency in [0.001, 0.03] if quick else LATENCIES:
                yield scene, peers, latency


def _path(folder, cell):
    scene, peers, latency = cell
    return folder / f"{scene}-{peers}-{latency * 1e3:g}ms.json"


def measure(binaries, results, _seeds, jobs, quick):
    folder = results / "partition"
    folder.mkdir(exist_ok=True)
    program = binaries / "partition"

    def run(cell):
        out = _path(folder, cell)
        if out.exists() and out.stat().st_mtime >= program.stat().st_mtime:
            return
        scene, peers, latency = cell
        done = subprocess.run([str(program), "--scene", scene, "--peers", str(peers), "--latency",
                               str(latency), *OPTIONS[scene]], capture_output=True, text=True,
                              check=False)
        if done.returncode != 0:
            raise RuntimeError(f"{out.stem}: {done.stderr.strip()}")
        out.write_text(done.stdout)

    with ThreadPoolExecutor(jobs) as pool:
        for _ in pool.map(run, _cells(quick)):
            pass


def _load(folder):
    found = {}
    for cell in _cells(False):
        path = _path(folder, cell)
        if path.exists():
            found[cell] = json.loads(path.read_text())
    return found


def _row(run, whole):
    """Figures of one run: name to value; lengths in mm."""
    peers = run["peer"]
    mean = sum(p["step_mean_s"] for p in peers) / len(peers)

    def mm(sample, which):
        value = run.get(sample, {}).get(which)
        return None if value is None or run[sample]["samples"] == 0 else 1e3 * value

    return {
        "lost": run["lost"], "under ground": run["under_ground"],
        "step over the whole's, mean": mean / whole["peer"][0]["step_mean_s"],
        "step over the whole's, worst": max(p["step_mean_s"] for p in peers)
                                        / whole["peer"][0]["step_mean_s"],
        "kbit/s a peer": 8e-3 * sum(p.get("bytes_per_s", 0.0) for p in peers) / len(peers),
        "overlap inside p99": mm("inside_m", "p99"), "overlap inside max": mm("inside_m", "max"),
        "overlap at seams p99": mm("seam_m", "p99"), "overlap at seams max": mm("seam_m", "max"),
        "copies apart p50": mm("apart_m", "p50"), "copies apart p95": mm("apart_m", "p95"),
    }


def _text(value):
    return "-" if value is None else f"{value:.3g}"


def _must_hold(runs):
    """The bounds of the cliff on four peers at 1 ms."""
    whole, run = runs.get(("cliff", 1, 0.001)), runs.get(("cliff", 4, 0.001))
    if not whole or not run:
        return []
    row = _row(run, whole)
    seam = row["overlap at seams p99"] / row["overlap inside p99"]
    step = row["step over the whole's, worst"]

    def line(what, value, holds):
        return f"| cliff, 4 peers, 1 ms: {what} | {value} | {'yes' if holds else 'no'} |"

    lost = row["lost"] + row["under ground"]
    return ["| must hold | measured | holds |", "|---|---|---|",
            line("balls lost or through the ground", lost, lost == 0),
            line("overlap p99 at seams at most 2 x inside", f"{seam:.2f}", seam <= 2.0),
            line("each peer's step at most 0.4 of the undivided", f"{step:.2f}", step <= 0.4), ""]


def report(results, _docs):
    runs = _load(results / "partition")
    if not runs:
        raise FileNotFoundError(2, "no runs", str(results / "partition"))
    lines = [
        "## A world in parts", "",
        "[friston] Sec. 8.3, `build/release/bin/partition`: each peer decides on the bodies of its "
        "cell, solves their contacts and follows what lies around; borders move with the bodies. "
        "*cliff*: 1000 balls; *cubes*: 100 stacks. One peer is the undivided run. Seams are pairs that "
        "two peers decide on. Lengths in mm.", ""]
    table = []
    held = _must_hold(runs)
    lines += held
    for scene in OPTIONS:
        whole = runs.get((scene, 1, 0.001))
        rows = {c: _row(r, whole) for c, r in runs.items() if c[0] == scene} if whole else {}
        if not rows:
            continue
        names = list(next(iter(rows.values())))
        lines += [f"### {scene}", "", "| peers | latency, ms | " + " | ".join(names) + " |",
                  "|---|---|" + "---|" * len(names)]
        for (_, peers, latency), row in rows.items():
            late = "-" if peers == 1 else f"{1e3 * latency:g}"
            lines.append(f"| {peers} | {late} | " + " | ".join(_text(row[n]) for n in names) + " |")
            table.append({"scene": scene, "peers": peers, "latency_ms": 1e3 * latency, **row})
        lines.append("")
    with (results / NAME).open("w", newline="") as file:
        writer = csv.DictWriter(file, table[0].keys())
        writer.writeheader()
        writer.writerows(table)
    return "\n".join(lines)
