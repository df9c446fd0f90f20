# SPDX-License-Identifier: Apache-2.0
"""Quantiles of the chi-square distribution, which say how large normalized squared errors may be."""

import math
from functools import lru_cache

import numpy as np

NUM_BISECTIONS = 60


def distribution(value, degrees):
    """Probability that a chi-square variable is at most `value`: the series of the lower incomplete gamma function."""
    if value <= 0:
        return 0.0
    a, x = degrees / 2, value / 2
    if x > a + 12 * math.sqrt(a) + 40:  # the series would be long, and the rest is below 1e-12
        return 1.0
    term = total = 1 / a
    while term > 1e-16 * total:
        a += 1
        term *= x / a
        total += term
    return total * math.exp(degrees / 2 * math.log(x) - x - math.lgamma(degrees / 2))


@lru_cache(maxsize=None)
def quantile(probability, degrees):
    """The value that a chi-square variable stays below with this probability."""
    low, high = 0.0, 2 * degrees + 100.0
    for _ in range(NUM_BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if distribution(middle, degrees) < probability else (low, middle)
    return (low + high) / 2


def bounds(degrees):
    """(lower, upper) ends of the interval that holds 95 % of the values, as many below as above; arrays for an array."""
    ends = [[quantile(p, int(n)) for n in np.ravel(degrees)] for p in (0.025, 0.975)]
    return np.reshape(ends, (2, *np.shape(degrees)))


def shares(values, degrees):
    """Share of the values within their 95 % bounds, below them and above them (%)."""
    lower, upper = bounds(degrees)
    below, above = np.mean(values < lower), np.mean(values > upper)
    return {"within_percent": 100 * float(1 - below - above), "below_percent": 100 * float(below),
            "above_percent": 100 * float(above)}  # fmt: skip
