# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""One session: its run and its results."""
import json
import re
import signal
import socket
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass

import tracks

# s of session time: the length of the script.
SECONDS = {"cubes": 20, "room": 40}
PROGRAMS = ("proxy",)


@dataclass(frozen=True)
class Cell:
    scene: str
    kind: str  # virtual: all peers in one process; udp: two processes and a proxy
    profile: int
    loss: float
    seed: int

    @property
    def name(self):
        return f"{self.scene}-{self.kind}-p{self.profile}-l{100 * self.loss:g}-s{self.seed}"

    def common(self):
        return ["--print", "nothing", "--seed", str(self.seed), "--seconds", str(SECONDS[self.scene])]


def free_port():
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as s:
        s.bind(("127.0.0.1", 0))
        return s.getsockname()[1]


def _run_virtual(cell, binaries, folder):
    subprocess.run([binaries / cell.scene, *cell.common(), "--profile", str(cell.profile),
                    "--loss", f"{cell.loss:g}", "--json", folder / "a.json"],
                   check=False, stdout=subprocess.DEVNULL)


def _run_udp(cell, binaries, folder):
    port = free_port()
    proxy = subprocess.Popen(
        [binaries / "proxy", "--profile", str(cell.profile), "--loss", f"{cell.loss:g}",
         "--seed", str(cell.seed), f"0=127.0.0.1:{port}"], stdout=subprocess.PIPE, text=True)
    try:
        entrance = int(proxy.stdout.readline())
        peers = []
        for name, way in (("a", ["--listen", str(port)]),
                          ("b", ["--connect", f"127.0.0.1:{entrance}"])):
            peers.append(subprocess.Popen(
                [binaries / cell.scene, *cell.common(), *way, "--transport", "udp", "--wait", "20",
                 "--json", folder / f"{name}.json", "--csv", folder / name],
                stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True))
        for peer in peers:
            _, trouble = peer.communicate(timeout=SECONDS[cell.scene] + 60)
            # 1 means that a world was not stable, which is a result.
            if peer.returncode not in (0, 1):
                raise RuntimeError(f"{cell.name}: {trouble.strip()}")
    finally:
        proxy.send_signal(signal.SIGTERM)
        told, _ = proxy.communicate(timeout=10)
    (folder / "proxy.txt").write_text(told)


def _run(cell, binaries, out):
    folder = out / "network" / cell.name
    result = folder / "done"
    newest = max((binaries / p).stat().st_mtime for p in (cell.scene, *PROGRAMS))
    if result.exists() and result.stat().st_mtime >= newest:
        return
    folder.mkdir(parents=True, exist_ok=True)
    (_run_virtual if cell.kind == "virtual" else _run_udp)(cell, binaries, folder)
    if not (folder / "a.json").exists():
        raise RuntimeError(f"{cell.name}: no result")
    if cell.kind == "udp":
        # Both ends' own tracks are more complete than either end's view of the other.
        (folder / "tracks.json").write_text(json.dumps(tracks.divergence(folder)))
        for name in ("a", "b"):
            for table in (folder / name).glob("*.csv"):
                table.unlink()
    result.touch()


def run_all(cells, binaries, out, jobs):
    with ThreadPoolExecutor(jobs) as pool:
        pending = [pool.submit(_run, cell, binaries, out) for cell in cells]
        for done, future in enumerate(as_completed(pending), 1):
            future.result()
            if done % 6 == 0 or done == len(cells):
                print(f"{done} of {len(cells)} sessions", file=sys.stderr, flush=True)


def _at(result, path):
    for key in path.split("."):
        result = result.get(key) if result else None
    return result


def _row(cell, measure, result, loss):
    millimetres = {
        "moving_p50_mm": "divergence_shared_moving_m.p50",
        "resting_p50_mm": "classes.resting.divergence_m.p50",
        "all_p99_mm": "divergence_shared_m.p99",
    }
    row = {"scene": cell.scene, "seed": cell.seed, "loss": cell.loss, "measure": measure,
           "lost": loss, "stable": int(result.get("stable", True)),
           "kbit_s": 8e-3 * result["bytes_per_second"] if "bytes_per_second" in result else None}
    for name, path in millimetres.items():
        value = _at(result, path)
        row[name] = None if value is None else 1e3 * value
    return row


def _lost(text):
    """The share of all datagrams that the proxy lost."""
    taken = sum(int(n) for n in re.findall(r"(\d+) in,", text))
    lost = sum(int(n) for n in re.findall(r"(\d+) lost,", text))
    return lost / taken if taken else None


def rows(cell, out):
    folder = out / "network" / cell.name
    if not (folder / "done").exists():
        return []
    a = json.loads((folder / "a.json").read_text())
    if cell.kind == "virtual":
        return [_row(cell, "virtual", a, cell.loss)]
    lost = _lost((folder / "proxy.txt").read_text())
    b = json.loads((folder / "b.json").read_text())
    joined = json.loads((folder / "tracks.json").read_text())
    joined["stable"] = a["stable"] and b["stable"]
    return [_row(cell, "udp, heard by 1", a, lost), _row(cell, "udp, heard by 2", b, lost),
            _row(cell, "udp, both tracks", joined, lost)]
