#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Cost of many people over NATS (docs/scale.md): runs bin/plaza with its own servers on loopback.

  benchmarks/people.py BIN people    100, 300 and 1000 people at constant density, interleaved; --direct of plaza
  benchmarks/people.py BIN udp       the same eight people over UDP and NATS, by seed
  benchmarks/people.py BIN restart   a server that is killed and restarted midway

BIN is the folder of a build with -DTANDEM_WITH_NATS=ON. Costs are CPU time and bytes per person and second of session
time, of the process with all people; the server's are separate. No wall clock.
"""
import argparse
import contextlib
import json
import os
import pathlib
import re
import shutil
import socket
import statistics
import subprocess
import tempfile
import time


class Server:
    """nats-server with JetStream on a free port."""

    def __init__(self):
        self.folder = tempfile.mkdtemp()
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            self.port = probe.getsockname()[1]
        self.start()

    def start(self):
        program = shutil.which("nats-server", path=os.environ["PATH"] + ":/usr/sbin")
        self.process = subprocess.Popen(
            [program, "-a", "127.0.0.1", "-p", str(self.port), "-js", "-sd", self.folder + "/store"],
            stderr=subprocess.DEVNULL)
        while True:
            with contextlib.suppress(OSError), socket.create_connection(("127.0.0.1", self.port)):
                return
            time.sleep(0.02)

    def cpu(self):
        """s, so far."""
        fields = pathlib.Path(f"/proc/{self.process.pid}/stat").read_text().rsplit(") ", 1)[1].split()
        return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")

    def kill(self):
        self.process.kill()
        self.process.wait()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()
        shutil.rmtree(self.folder, ignore_errors=True)


def plaza(binary, server, *words):
    out = subprocess.run([binary / "plaza", "--server", f"127.0.0.1:{server.port}", "--quiet", *map(str, words)],
                         check=True, capture_output=True, text=True)
    return json.loads(out.stdout)


def people(binary, args):
    runs = {}
    for round_ in range(args.rounds):
        for count in args.counts:
            with Server() as server:
                run = plaza(binary, server, "--people", count, "--density", 20, "--seconds", args.seconds, "--seed",
                            round_ + 1, "--direct", args.direct)
                # Over the whole run, including warm-up.
                run["server"] = 1e3 * server.cpu() / count / (args.seconds + 3.0)
            runs.setdefault(count, []).append(run)
            print(json.dumps(run), flush=True)
    print("\n| People | kbit/s in, out | messages/s in, out | CPU ms/s | server ms/s | peers | bodies |")
    print("|---|---|---|---|---|---|---|")
    for count, all_ in runs.items():
        mid = lambda key: statistics.median(run[key] for run in all_)
        print(f"| {count} | {mid('kbit_in'):.0f}, {mid('kbit_out'):.0f} | {mid('messages_in'):.0f}, "
              f"{mid('messages_out'):.0f} | {mid('cpu_ms_per_person_s'):.1f} | {mid('server'):.1f} | "
              f"{mid('connected'):.1f} | {mid('simulated'):.1f} |")
    lost = sum(run["bodies_lost"] + run["bodies_twice"] for all_ in runs.values() for run in all_)
    print(f"bodies lost or found twice: {lost}")


def udp(binary, args):
    with Server() as server:
        ratios = {key: [] for key in ("moving p50", "moving p95", "resting p95", "cpu")}
        for seed in range(1, args.seeds + 1):
            by = {wire: plaza(binary, server, "--transport", wire, "--people", 8, "--bodies", 12, "--side", 8, "--near",
                              24, "--seconds", args.seconds, "--seed", seed) for wire in ("udp", "nats")}
            values = {wire: (run["moving_mm"]["p50"], run["moving_mm"]["p95"], run["resting_mm"]["p95"],
                             run["cpu_ms_per_person_s"]) for wire, run in by.items()}
            print(seed, values, flush=True)
            for key, a, b in zip(ratios, values["nats"], values["udp"]):
                ratios[key].append((a, b))
    for key, pairs in ratios.items():
        nats, over_udp = (statistics.median(column) for column in zip(*pairs))
        print(f"{key}: NATS {nats:.3f}, UDP {over_udp:.3f}, ratio of medians {nats / over_udp:.2f}, median ratio "
              f"{statistics.median(a / b for a, b in pairs if b > 0):.2f}")


def restart(binary, args):
    with Server() as server:
        run = subprocess.Popen([binary / "plaza", "--server", f"127.0.0.1:{server.port}", "--people", "20", "--density",
                                "20", "--seconds", "20", "--seed", str(args.seeds)], stderr=subprocess.PIPE,
                               stdout=subprocess.PIPE, text=True)
        for line in run.stderr:
            print(line, end="", flush=True)
            at = float(re.match(r" *(-?[\d.]+) s", line)[1])
            if at == 6.0:
                server.kill()
                print("killed", flush=True)
            if at == 8.0:
                server.start()
                print("started", flush=True)
        result = json.loads(run.stdout.read())
        run.wait()
        print({key: result[key] for key in ("bodies_lost", "bodies_twice", "crossings", "taken")})


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binary", type=pathlib.Path)
    parser.add_argument("what", choices=("people", "udp", "restart"))
    parser.add_argument("--counts", type=int, nargs="+", default=[100, 300, 1000])
    parser.add_argument("--direct", type=int, default=0)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--seeds", type=int, default=9)
    args = parser.parse_args()
    {"people": people, "udp": udp, "restart": restart}[args.what](args.binary, args)


if __name__ == "__main__":
    main()
