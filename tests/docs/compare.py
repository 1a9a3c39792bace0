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


def _tokens(quoted, units):
    """(kind, text) of each part: a word, a number, a number that is not compared, or anything."""
    at = 0
    for match in re.finditer(f"{re.escape(ANYTHING)}|{NUMBER.pattern}", quoted):
        yield "word", quoted[at:match.start()]
        at = match.end()
        unit = (quoted[at:].split() or [""])[0].rstrip(",.;:)")
        kind = "anything" if match.group() == ANYTHING else "time" if unit in units else "number"
        yield kind, match.group()
    yield "word", quoted[at:]


def _matches(tokens, text, at, tolerance, whole):
    if not tokens:
        return at == len(text) or not whole
    (kind, quoted), rest = tokens[0], tokens[1:]
    if kind == "anything":
        return any(_matches(rest, text, i, tolerance, whole) for i in range(at, len(text) + 1))
    if kind == "word":
        return text.startswith(quoted, at) and _matches(rest, text, at + len(quoted), tolerance, whole)
    number = NUMBER.match(text, at)
    return (number is not None and (kind == "time" or equal(quoted, number.group(), tolerance))
            and _matches(rest, text, number.end(), tolerance, whole))


def same(quoted, printed, options, whole=True):
    """Whether a line has what a page quotes, or, where not whole, contains it."""
    tokens = list(_tokens(" ".join(quoted.split()), options.units))
    text = " ".join(printed.split())
    starts = [0] if whole else range(len(text) + 1)
    return any(_matches(tokens, text, start, options.tolerance, whole) for start in starts)


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
