# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Processor, system, compiler, flags and date of the measurement. No host names."""
import datetime
import os
import platform
import re
import subprocess
from pathlib import Path


def first_match(path, pattern, otherwise="unknown"):
    try:
        found = re.search(pattern, Path(path).read_text(), re.MULTILINE)
    except OSError:
        return otherwise
    return found.group(1).strip() if found else otherwise


def output(command, otherwise="unknown"):
    try:
        return subprocess.run(command, capture_output=True, text=True, check=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        return otherwise


def describe(binaries):
    cache = Path(binaries).parent / "CMakeCache.txt"
    compiler = first_match(cache, r"^CMAKE_CXX_COMPILER:\w+=(.*)$", "c++")
    build = first_match(cache, r"^CMAKE_BUILD_TYPE:\w+=(.*)$")
    flags = [first_match(cache, r"^CMAKE_CXX_FLAGS:\w+=(.*)$", ""),
             first_match(cache, rf"^CMAKE_CXX_FLAGS_{build.upper()}:\w+=(.*)$", ""),
             "-ffp-contract=off"]
    return {
        "processor": first_match("/proc/cpuinfo", r"^model name\s*:\s*(.*)$"),
        "cores": os.cpu_count(),
        "system": first_match("/etc/os-release", r'^PRETTY_NAME="?([^"\n]*)'),
        "kernel": platform.release().split("-")[0],
        "compiler": output([compiler, "--version"]).splitlines()[0],
        "flags": " ".join(f for f in flags if f),
        "bullet": output(["pkg-config", "--modversion", "bullet-float64"], "absent"),
        "date": datetime.date.today().isoformat(),
    }
