#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""A mesh of tandem-peer processes on this machine whose users fidget for a long time.

    benchmarks/soak.py build/release/bin                               8 peers, 10 minutes
    benchmarks/soak.py build/release/bin --minutes 2 --profile 3 --loss 0.05

--profile and --loss put a proxy into all links. Requirements: peers stay connected, memory does not grow after the
first fifth, the number of descriptors is constant, divergence stays below a bound, no world breaks, no process ends
early. Exits with 1 if one fails.
"""
import argparse
import contextlib
import re
import signal
import socket
import statistics
import subprocess
import sys
import tempfile
import time
import urllib.request
from dataclasses import dataclass, field
from pathlib import Path

CONFIG = """id = {id}
seed = {seed}
[network]
listen = {port}
connect = [{connect}]
key = "key"
kbit_per_s = {budget}
[user]
fidget = true
[log]
file = "{id}.log"
[metrics]
port = {metrics}
"""


@dataclass
class Peer:
    number: int
    process: subprocess.Popen
    metrics: int
    # Each sample: (s since the start, MiB, descriptors, connected peers, m, CPU s).
    looks: list = field(default_factory=list)
    page: str = ""

    def look(self, start):
        proc = Path(f"/proc/{self.process.pid}")
        rss = int(re.search(r"VmRSS:\s+(\d+)", (proc / "status").read_text())[1]) / 1024
        stat = (proc / "stat").read_text().rsplit(")", 1)[1].split()
        cpu = (int(stat[11]) + int(stat[12])) / 100
        descriptors = len(list((proc / "fd").iterdir()))
        with urllib.request.urlopen(f"http://127.0.0.1:{self.metrics}/metrics", timeout=5) as answer:
            self.page = answer.read().decode()
        self.looks.append((time.monotonic() - start, rss, descriptors,
                           int(self.metric("tandem_peers_connected")),
                           self.metric('tandem_divergence_metres{quantile="0.99"}'), cpu))

    def metric(self, name):
        found = re.search(rf"^{re.escape(name)} (\S+)$", self.page, re.MULTILINE)
        return float(found[1]) if found else float("nan")

    def metrics_of_all(self, name):
        return [float(v) for v in re.findall(rf"^{name}{{[^}}]*}} (\S+)$", self.page, re.MULTILINE)]


def free_ports(count, kind):
    """All open at once, so that no two are the same."""
    with contextlib.ExitStack() as stack:
        ports = []
        for _ in range(count):
            s = stack.enter_context(socket.socket(socket.AF_INET, kind))
            s.bind(("127.0.0.1", 0))
            ports.append(s.getsockname()[1])
        return ports


def start_proxy(args, ports):
    """One entrance per peer that is dialled."""
    command = [args.binaries / "proxy", "--profile", str(args.profile), "--loss", f"{args.loss:g}",
               "--seed", str(args.seed)]
    proxy = subprocess.Popen(command + [f"0=127.0.0.1:{port}" for port in ports],
                             stdout=subprocess.PIPE, text=True)
    return proxy, [int(proxy.stdout.readline()) for _ in ports]


def start_peers(args, folder, stack):
    ports = free_ports(args.peers, socket.SOCK_DGRAM)
    metrics = free_ports(args.peers, socket.SOCK_STREAM)
    entrances = ports
    if args.profile > 0 or args.loss > 0:
        proxy, entrances = start_proxy(args, ports)
        stack.callback(proxy.wait)
        stack.callback(proxy.terminate)
    key = subprocess.run([args.binaries / "tandem-key"], check=True, capture_output=True, text=True)
    (folder / "key").touch(mode=0o600)
    (folder / "key").write_text(key.stdout)
    peers = []
    for number in range(1, args.peers + 1):
        # One would be enough; all at once is quicker.
        connect = ", ".join(f'"127.0.0.1:{port}"' for port in entrances[:number - 1])
        path = folder / f"{number}.toml"
        path.write_text(CONFIG.format(id=number, seed=args.seed, port=ports[number - 1],
                                      connect=connect, budget=args.budget,
                                      metrics=metrics[number - 1]))
        process = subprocess.Popen([args.binaries / "tandem-peer", args.scene, "--config", path])
        stack.callback(process.kill)
        peers.append(Peer(number, process, metrics[number - 1]))
    return peers


def run(args, folder):
    """Returns the peers with their samples, and how they ended."""
    with contextlib.ExitStack() as stack:
        peers = start_peers(args, folder, stack)
        start = time.monotonic()
        time.sleep(3)
        while time.monotonic() - start < 60 * args.minutes:
            for peer in peers:
                if peer.process.poll() is not None:
                    log = folder / f"{peer.number}.log"
                    raise RuntimeError(f"peer {peer.number} has ended: {log.read_text()[-500:]}")
                peer.look(start)
            time.sleep(5)
        for peer in peers:
            peer.process.send_signal(signal.SIGTERM)
        ends = [peer.process.wait(timeout=20) for peer in peers]
    return peers, ends


def judge(args, peers, ends):
    """[(what, measured, bound, holds)]"""
    warm = 60 * args.minutes / 5
    after = {peer.number: [look for look in peer.looks if look[0] >= warm] for peer in peers}
    everyone = [look for looks in after.values() for look in looks]
    # The minimum of a window: short-lived memory is not a leak.
    growth, first, last = -1e9, 0.0, 0.0
    for looks in after.values():
        part = max(1, len(looks) // 5)
        begin, end = (min(look[1] for look in window) for window in (looks[:part], looks[-part:]))
        if end - begin > growth:
            growth, first, last = end - begin, begin, end
    descriptors = [len({look[2] for look in looks}) for looks in after.values()]
    connected = min(look[3] for look in everyone)
    apart = max(look[4] for look in everyone)
    faults = sum(peer.metric("tandem_faults_total") for peer in peers)
    rejected = sum(sum(peer.metrics_of_all("tandem_packets_rejected_total")) for peer in peers)
    return [
        ("memory, most growth of a peer", f"{first:.1f} to {last:.1f} MiB",
         f"<= {args.growth:g} MiB more", growth <= args.growth),
        ("descriptors after the first fifth",
         ", ".join(str(looks[-1][2]) for looks in after.values()), "constant",
         max(descriptors) == 1),
        ("connected others, least", str(connected), str(args.peers - 1),
         connected == args.peers - 1),
        ("divergence p99, worst look", f"{1e3 * apart:.1f} mm", f"<= {1e3 * args.apart:g} mm",
         apart <= args.apart),
        ("broken steps", f"{faults:g}", "0", faults == 0),
        ("packets rejected", f"{rejected:g}", "0", rejected == 0),
        ("ends", ", ".join(str(end) for end in ends), "0", not any(ends)),
    ]


def describe(args, peers):
    seconds = peers[0].looks[-1][0] - peers[0].looks[0][0]
    cpu = [100 * (p.looks[-1][5] - p.looks[0][5]) / seconds for p in peers]
    p50 = [1e3 * p.metric('tandem_divergence_metres{quantile="0.5"}') for p in peers]
    step = [1e3 * p.metric('tandem_step_seconds{quantile="0.99"}') for p in peers]
    loss = [100 * v for p in peers for v in p.metrics_of_all("tandem_loss_ratio")]
    sent = [8e-3 * v / p.metric("tandem_uptime_seconds") for p in peers
            for v in p.metrics_of_all("tandem_sent_bytes_total")]
    print(f"{args.peers} peers, {args.scene}, {args.minutes:g} minutes, profile {args.profile}, "
          f"loss {100 * args.loss:g} %")
    print(f"CPU of a peer {statistics.mean(cpu):.1f} % of a core, step p99 up to {max(step):.2f} ms,"
          f" divergence p50 up to {max(p50):.2f} mm, loss seen {statistics.mean(loss):.1f} %, "
          f"each link {statistics.mean(sent):.0f} kbit/s")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("binaries", type=Path, help="folder of the programs")
    parser.add_argument("--scene", default="cubes")
    parser.add_argument("--peers", type=int, default=8)
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--profile", type=int, default=0)
    parser.add_argument("--loss", type=float, default=0.0)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--budget", type=float, default=2000.0, help="kbit/s of each link")
    parser.add_argument("--apart", type=float, default=0.1, help="m, bound of divergence's p99")
    parser.add_argument("--growth", type=float, default=1.0, help="MiB, bound of resident memory's")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        peers, ends = run(args, Path(folder))
        logs = "".join((Path(folder) / f"{p.number}.log").read_text() for p in peers)
    describe(args, peers)
    rows = judge(args, peers, ends)
    for what, measured, bound, holds in rows:
        print(f"{'ok  ' if holds else 'FAIL'}  {what}: {measured} ({bound})")
    if not all(row[3] for row in rows):
        print("\n".join(line for line in logs.splitlines() if "level=info" not in line)[-3000:])
        sys.exit(1)


if __name__ == "__main__":
    main()
