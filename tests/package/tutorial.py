#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Runs a tutorial as it stands: tutorial.py FILE.md PREFIX

In an empty folder, block by block, with CMAKE_PREFIX_PATH at an installed Tandem:
  ```cpp NAME, ```cmake NAME   written to that file
  ```sh                        run, must succeed
  ```sh terminal               run at the same time as the next one of these
  ```sh install                left out: PREFIX is what it makes
  ```text                      each line has been printed since the last of these, but for digits
"""
import os
import pathlib
import re
import socket
import subprocess
import sys
import tempfile

SECONDS = 600  # a hang, and not a machine that has much to do


def blocks(text):
    for match in re.finditer(r"^```(\w+)(?: (\S+))?\n(.*?)^```$", text, re.M | re.S):
        yield match.group(1), match.group(2), match.group(3)


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return str(probe.getsockname()[1])


def run(commands, folder, environment):
    """All at once; what they print, the first one's first."""
    running = [subprocess.Popen(["bash", "-euc", command], cwd=folder, env=environment, text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
               for command in commands]
    printed = ""
    for process, command in zip(running, commands):
        try:
            out, _ = process.communicate(timeout=SECONDS)
        except subprocess.TimeoutExpired:
            for other in running:
                other.kill()
            sys.exit(f"tutorial: not done in {SECONDS} s:\n{command}")
        printed += out
        if process.returncode != 0:
            print(printed)
            sys.exit(f"tutorial: ended with {process.returncode}:\n{command}")
    return printed


def main():
    text = pathlib.Path(sys.argv[1]).read_text()
    environment = dict(os.environ, CMAKE_PREFIX_PATH=sys.argv[2],
                       CXXFLAGS="-Wall -Wextra -Wpedantic -Werror")
    port = free_port()
    counts = {}
    with tempfile.TemporaryDirectory() as folder:
        printed = ""
        terminals = []
        for language, name, body in blocks(text):
            kind = name if language == "sh" and name else language
            counts[kind] = counts.get(kind, 0) + 1
            if kind == "terminal":
                terminals.append(body.replace("7777", port))
                if len(terminals) == 2:
                    printed += run(terminals, folder, environment)
                    terminals = []
            elif kind == "sh":
                printed += run([body], folder, environment)
            elif kind in ("cpp", "cmake"):
                pathlib.Path(folder, name).write_text(body)
            elif kind == "text":
                for line in body.splitlines():
                    pattern = re.sub(r"\d+", r"\\d+", re.escape(line))
                    if not re.search(f"^{pattern}$", printed, re.M):
                        print(printed)
                        sys.exit(f"tutorial: nothing like this was printed: {line}")
                printed = ""
            elif kind != "install":
                sys.exit(f"tutorial: what is a block of {kind}?")
    if counts.get("sh", 0) < 1 or counts.get("text", 0) < 1 or counts.get("terminal", 0) != 2:
        sys.exit(f"tutorial: blocks were not found: {counts}")
    print(f"tutorial: holds: {counts}")


if __name__ == "__main__":
    main()
