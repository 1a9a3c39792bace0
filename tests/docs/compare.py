# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Compares quoted lines with printed ones: words exactly but for spaces, numbers within a tolerance."""
import re

NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d{1,3})?(?![\w]|\.\d)")
ANYTHING = "[..]"


def equal(quoted, printed, tolerance):
    if quoted == printed:
        return True
    if re.fullmatch(r"[-+]?\d+", quoted) and re.fullmatch(r"[-+]?\d+", printed):
        return int(quoted) == int(printed)
    mantissa, _, exponent = quoted.partition("e")
    last_digit = 10.0 ** (int(exponent or 0) - len(mantissa.partition(".")[2]))
    is_integer = re.fullmatch(r"[-+]?\d+", quoted)
    slack = max(0.5000001 * last_digit, 0.0 if is_integer else tolerance * abs(float(printed)))
    return abs(float(quoted) - float(printed)) <= slack


def same(quoted, printed, options, whole=True):
    """Whether a line has what a page quotes, or, where not whole, contains it."""
    pattern, numbers, at = "", [], 0
    quoted = " ".join(quoted.split())
    parts = re.compile(f"{re.escape(ANYTHING)}|{NUMBER.pattern}")
    for match in parts.finditer(quoted):
        pattern += re.escape(quoted[at:match.start()])
        at = match.end()
        if match.group() == ANYTHING:
            pattern += ".*?"
        elif (quoted[at:].split() or [""])[0].rstrip(",.;:)") in options.units:
            pattern += NUMBER.pattern
        else:
            numbers.append(match.group())
            pattern += f"({NUMBER.pattern})"
    pattern += re.escape(quoted[at:])
    text = " ".join(printed.split())
    starts = [0] if whole else range(len(text) + 1)
    for start in starts:
        match = (re.compile(pattern).fullmatch if whole else re.compile(pattern).match)(text, start)
        if match and all(map(equal, numbers, match.groups(), [options.tolerance] * len(numbers))):
            return True
    return False


def differs(quoted, printed, options):
    """The first quoted line that is not what was printed, or None. Lines may be left out by [..]."""
    if not quoted:
        return None if not printed else f"nothing is quoted, and it prints: {printed[0]}"
    if quoted[0].strip() == ANYTHING:
        rest = [differs(quoted[1:], printed[i:], options) for i in range(len(printed) + 1)]
        return None if len(quoted) == 1 or None in rest else rest[0]
    if not printed:
        return f"quoted: {quoted[0]}\n  printed: nothing more"
    if not same(quoted[0], printed[0], options):
        return f"quoted:  {quoted[0]}\n  printed: {printed[0]}"
    return differs(quoted[1:], printed[1:], options)
