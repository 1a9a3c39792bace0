# SPDX-License-Identifier: MIT
# Copyright (c) 2026 The Tandem authors
"""Numbers over seeds."""
import math
import statistics

# Student's t, two-sided 95 %, by degrees of freedom.
_T = {1: 12.706, 2: 4.303, 3: 3.182, 4: 2.776, 5: 2.571, 6: 2.447, 7: 2.365, 8: 2.306, 9: 2.262}


def get(result, path):
    """A nested number of a result, by a dotted name; None if it is missing."""
    for name in path.split("."):
        if not isinstance(result, dict) or result.get(name) is None:
            return None
        result = result[name]
    return result


def values(results, path, factor=1.0):
    found = [get(r, path) for r in results or []]
    return [factor * v for v in found if v is not None]


def interval(numbers):
    """Mean and half of its 95 % confidence interval; None if undefined."""
    if not numbers:
        return None, None
    if len(numbers) == 1:
        return numbers[0], None
    t = _T.get(len(numbers) - 1, 1.96)
    return statistics.fmean(numbers), t * statistics.stdev(numbers) / math.sqrt(len(numbers))


def short(number):
    if number is None:
        return "-"
    return f"{number:.3g}" if abs(number) < 1e4 else f"{number:.2e}"


def text(results, path, factor=1.0):
    mean, half = interval(values(results, path, factor))
    if mean is None:
        return "-"
    return short(mean) if half is None else f"{short(mean)} ± {short(half)}"


def over(number, other):
    """Their ratio; None if either is unknown or the divisor is 0."""
    return number / other if number is not None and other else None


def worst(results, path, factor=1.0):
    numbers = values(results, path, factor)
    return max(numbers) if numbers else None


def mean(results, path, factor=1.0):
    return interval(values(results, path, factor))[0]
