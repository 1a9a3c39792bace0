# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Writes pages of measurements: long tables go beside the page as CSV."""
import csv
import re
import textwrap
from pathlib import Path

MOST_ROWS = 24  # per table within a page
WIDTH = 120     # columns of prose


def _slug(heading):
    return re.sub(r"[^a-z0-9]+", "_", heading.lower()).strip("_")


def _cells(line):
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def table(head, lines):
    return ["| " + " | ".join(head) + " |", "|" + "---|" * len(head)] + [
        "| " + " | ".join(line) + " |" for line in lines]


def aside(page, name, lines):
    """Writes a Markdown table as CSV into the page's folder. Returns the target of a link to it."""
    page = Path(page)
    file = page.with_suffix("") / f"{name}.csv"
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w", newline="") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerows(_cells(line) for line in [lines[0], *lines[2:]])
    return f"{file.parent.name}/{file.name}"


def wrapped(text):
    """Wraps prose at WIDTH columns; headings, tables and pictures are kept."""
    out = []
    for line in text.split("\n"):
        if len(line) <= WIDTH or line.startswith(("|", "#", "![")):
            out.append(line)
        else:
            out += textwrap.wrap(line, WIDTH, subsequent_indent="  " if line.startswith("- ") else "",
                                 break_long_words=False, break_on_hyphens=False)
    return "\n".join(out)


def sections(path):
    """Text of each section of a page, by its first line; the text before the first has the key ""."""
    path = Path(path)
    parts = re.split(r"^(?=## )", path.read_text() if path.exists() else "", flags=re.MULTILINE)
    return {"": parts[0]} | {part.split("\n", 1)[0]: part for part in parts[1:]}


def write(path, text):
    """Writes a page. Tables of more than MOST_ROWS rows become files in a folder of the page's name, named after their
    heading and linked. So does every table under a line "@csv NAME TITLE", by that name and as a list item. Files
    linked by `text` from a kept section stay."""
    path = Path(path)
    folder = path.with_suffix("")
    kept = set(re.findall(rf"\({re.escape(folder.name)}/([^)]*\.csv)\)", text))
    for old in folder.glob("*.csv") if folder.is_dir() else ():
        if old.name not in kept:
            old.unlink()
    out, table, names, heading, aside = [], [], {}, "table", None

    def next_file():
        while True:
            names[heading] = names.get(heading, 0) + 1
            number = f"_{names[heading]}" if names[heading] > 1 else ""
            file = folder / f"{heading}{number}.csv"
            if file.name not in kept:
                return file

    def end_table():
        rows = table[2:]
        if len(rows) <= MOST_ROWS and not aside:
            out.extend(table)
        else:
            file = folder / f"{aside[0]}.csv" if aside else next_file()
            folder.mkdir(parents=True, exist_ok=True)
            with file.open("w", newline="") as stream:
                writer = csv.writer(stream, lineterminator="\n")
                writer.writerows(_cells(line) for line in [table[0], *rows])
            out.append(f"- [{aside[1]}]({folder.name}/{file.name})" if aside else
                       f"[Table of {len(rows)} rows]({folder.name}/{file.name}): "
                       + ", ".join(_cells(table[0])) + ".")
        table.clear()

    for line in text.split("\n"):
        if line.startswith("|"):
            table.append(line)
            continue
        if table:
            end_table()
            aside = None
        if line.startswith("@csv "):
            aside = line.split(maxsplit=2)[1:]
            continue
        if line.startswith("#"):
            heading = _slug(line.lstrip("#"))
        out.append(line)
    if table:
        end_table()
    path.write_text("\n".join(out).rstrip("\n") + "\n")
