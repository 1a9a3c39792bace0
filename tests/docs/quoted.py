#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Runs the commands that README.md and docs/*.md quote, and compares what they print.

    tests/docs/quoted.py build/release/bin             the quick ones, some seconds
    tests/docs/quoted.py build/release/bin --nightly   the long ones
    tests/docs/quoted.py build/release/bin docs/trace.md

A page quotes a command in either way:

    ```console
    $ COMMAND                       the lines up to the next "$ " are all that it prints;
    its output                      a line "[..]" stands for any lines
    ```

    <!-- quoted                     not seen by readers, for figures in sentences and tables
    $ COMMAND
    PHRASE => LINE                  the page has the phrase, and a line of the output has LINE; "[..]" stands
    -->                             for any text; the phrase's numbers are all in LINE or in the command.
                                    A line without an arrow is both. Without lines all that it prints is
                                    in the page, as rows of tables are.

A comment <!-- quoted: OPTION, OPTION --> stands before a block, or begins the hidden one. Options:

    nightly               too long for each run of the tests
    tolerance 5 %         of real numbers, in place of 2 %; integers are exact
    not compared: ms us   numbers before these units are anything: times, which are the machine's
    fails                 the command is meant to end with an error

A number that rounds to the digits quoted is equal. All commands of a page run in one empty folder, in bash,
with the programs in PATH and the root in TANDEM; `bash demos/run.sh` is the demo that it starts.
"""
import argparse
import os
import pathlib
import re
import subprocess
import sys
import tempfile

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).parent))
from compare import NUMBER, differs, same

ROOT = pathlib.Path(__file__).resolve().parents[2]
SECONDS = {False: 300, True: 3600}  # a hang, and not a machine that has much to do


class Options:
    def __init__(self, text):
        self.nightly, self.fails, self.tolerance, self.units = False, False, 0.02, ()
        for option in filter(None, (part.strip() for part in text.split(","))):
            if option in ("nightly", "fails"):
                setattr(self, option, True)
            elif match := re.fullmatch(r"tolerance ([\d.]+) ?%", option):
                self.tolerance = float(match.group(1)) / 100
            elif option.startswith("not compared: "):
                self.units = tuple(option.split()[2:])
            else:
                raise ValueError(f"unknown option of a quotation: {option}")


class Quotation:
    """A command with the lines that a page has of its output."""

    def __init__(self, line, command, options, hidden):
        self.line, self.command, self.options, self.hidden, self.lines = line, command, options, hidden, []


def quotations(text):
    found, options, state = [], "", None
    for number, line in enumerate(text.splitlines(), 1):
        if state is None:
            if line == "```console":
                state, given = "```", options
            elif match := re.fullmatch(r"<!-- quoted(?:: (.*?))?( -->)?", line):
                options = match.group(1) or ""
                if not match.group(2):
                    state, given = "-->", options
            elif line.strip():
                options = ""
        elif line == state:
            state, options = None, ""
        elif line.startswith("$ "):
            found.append(Quotation(number, line[2:], Options(given), state == "-->"))
        elif found and found[-1].line < number and found[-1].hidden == (state == "-->"):
            if line.strip() or state == "```":
                found[-1].lines.append(line)
        else:
            raise ValueError(f"line {number}: a quotation begins with '$ COMMAND'")
    if state is not None:
        raise ValueError(f"a quotation does not end: {state} is missing")
    return found


def hidden_fault(text, quotation, printed):
    """What is wrong with the phrases of a hidden quotation, or None."""
    visible = re.sub(r"<!--.*?-->", " ", text, flags=re.S)
    if not quotation.lines:
        for line in printed:
            row = " ".join(line.split())
            if not any(row in " ".join(each.split()) or same(each, line, quotation.options)
                       for each in visible.splitlines()):
                return f"the page does not have: {line}"
        return None
    visible = " ".join(visible.split())
    for line in quotation.lines:
        phrase, arrow, wanted = (part.strip() for part in line.partition(" => "))
        wanted = wanted if arrow else phrase
        if " ".join(phrase.split()) not in visible:
            return f"the page does not say: {phrase}"
        known = NUMBER.findall(wanted) + NUMBER.findall(quotation.command)
        for number in NUMBER.findall(phrase):
            if number not in known:
                return f"{number} of '{phrase}' is not in: {wanted}"
        if not any(same(wanted, each, quotation.options, whole=False) for each in printed):
            return f"quoted:  {wanted}\n  printed: nothing like this, but:\n" + "\n".join(printed[:30])
    return None


def started(command):
    """The program's command for one of demos/run.sh, which builds it first."""
    demo = re.fullmatch(r"(?:bash )?demos/run\.sh(?: (.*))?", command)
    if not demo:
        return command
    arguments = demo.group(1) or "piano --profile 4"
    return f"piano {arguments}" if arguments.startswith("-") else arguments


def run(command, programs, folder, seconds):
    environment = dict(os.environ, PATH=f"{programs}:{os.environ['PATH']}", TANDEM=str(ROOT))
    done = subprocess.run(["bash", "-c", started(command)], cwd=folder, env=environment, text=True, timeout=seconds,
                          stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    return done.returncode, [line.rstrip() for line in done.stdout.splitlines()]


def check(text, programs, nightly=False):
    """(number of commands run, faults, each a line and a text)."""
    faults, count = [], 0
    with tempfile.TemporaryDirectory() as folder:
        for quotation in quotations(text):
            if quotation.options.nightly != nightly:
                continue
            count += 1
            status, printed = run(quotation.command, programs, folder, SECONDS[nightly])
            if (status != 0) != quotation.options.fails:
                fault = f"ends with {status}:\n" + "\n".join(printed[-20:])
            elif quotation.hidden:
                fault = hidden_fault(text, quotation, printed)
            else:
                fault = differs([line.rstrip() for line in quotation.lines], printed, quotation.options)
            if fault:
                faults.append((quotation.line, f"$ {quotation.command}\n  {fault}"))
    return count, faults


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("programs", type=lambda name: pathlib.Path(name).resolve())
    parser.add_argument("pages", nargs="*", help="below the root; all without")
    parser.add_argument("--nightly", action="store_true")
    args = parser.parse_args()
    pages = args.pages or ["README.md", *sorted(f"docs/{p.name}" for p in (ROOT / "docs").glob("*.md"))]
    total, failed = 0, 0
    for page in pages:
        count, faults = check((ROOT / page).read_text(), args.programs, args.nightly)
        total += count
        failed += len(faults)
        for line, fault in faults:
            print(f"{page}:{line}: {fault}")
    print(f"quoted: {total} commands, {failed} print something else")
    return 1 if failed or not total else 0


if __name__ == "__main__":
    sys.exit(main())
