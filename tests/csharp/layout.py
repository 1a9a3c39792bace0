#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""A program in C that says what a header declares, nothing left out: layout.py HEADER OUTPUT

Its lines are "struct NAME SIZE", "field STRUCT NAME OFFSET SIZE", "enum TYPE NAME VALUE" and
"function NAME PARAMETERS".
"""
import re
import sys

text = open(sys.argv[1], encoding="utf-8").read()
text = re.sub(r"/\*.*?\*/", "", text, flags=re.S)
text = re.sub(r"//[^\n]*|#[^\n]*", "", text)

lines = []


def say(words, *values):
    formats = "".join(" %lld" for _ in values)
    numbers = "".join(f", (long long)({value})" for value in values)
    lines.append(f'  printf("{words}{formats}\\n"{numbers});')


def field_names(body):
    for declaration in filter(None, (part.strip() for part in body.split(";"))):
        function = re.search(r"\(\*(\w+)\)", declaration)
        if function:
            yield function[1]
            continue
        for name in declaration.split(","):
            yield re.search(r"(\w+)\s*(\[\w+\])?$", name.strip())[1]


for name, body in re.findall(r"typedef struct (\w+) \{(.*?)\} \1;", text, flags=re.S):
    say(f"struct {name}", f"sizeof({name})")
    for field in field_names(body):
        say(f"field {name} {field}", f"offsetof({name}, {field})", f"sizeof((({name}*)0)->{field})")
for name, body in re.findall(r"typedef enum (\w+) \w+ \{(.*?)\}", text, flags=re.S):
    for value in re.findall(r"(\w+) = ", body):
        say(f"enum {name} {value}", value)
for name, parameters in re.findall(r"_API [^;(]*?(tandem_\w+)\(([^;]*)\);", text):
    count = 0 if parameters.strip() == "void" else parameters.count(",") + 1
    say(f"function {name}", count)

if len(lines) < 100:
    sys.exit(f"layout.py: {sys.argv[1]} was not understood")
with open(sys.argv[2], "w", encoding="utf-8") as out:
    out.write("/* Made by layout.py. */\n#include <stddef.h>\n#include <stdio.h>\n\n")
    out.write('#include "reference.h"\n#include "tandem/c/tandem.h"\n\n')
    out.write("void print_layout(void) {\n" + "\n".join(lines) + "\n}\n")
