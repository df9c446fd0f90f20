#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Passes the output of ctest on, and puts before its summary what it does not say of its programs: how many tests they had,
which were skipped and why, and the slowest ten programs with their times. The argument is ctest's log."""
import pathlib
import re
import sys

from when_changed import UNCHANGED

SHOWN = 10
ENDED = re.compile(r"\s*\d+/\d+ Test +#\d+: (\S+) .*?([\d.]+) sec")
COUNTED = re.compile(r"(?m)^\[=+\] (\d+) tests? from .* ran|^Ran (\d+) tests? in ")  # by GoogleTest, by unittest
SKIPPED = re.compile(r"(?m)^\S+:\d+: Skipped\n(.+)$|^(?:.* \.\.\. )?skipped ['\"](.+)['\"]$")


def of_the_programs(log):
    counts = [int(by_gtest or by_unittest) for by_gtest, by_unittest in COUNTED.findall(log)]
    reasons = sorted({by_gtest or by_unittest for by_gtest, by_unittest in SKIPPED.findall(log)})
    yield f"{sum(counts)} tests in {len(counts)} programs\n"
    if num_before := log.count(UNCHANGED):
        yield f"{num_before} programs passed before, and nothing changed\n"
    yield from (f"skipped: {reason}\n" for reason in reasons)


def slowest(times):
    yield "Slowest:\n"
    yield from (f"{seconds:8.1f} s  {name}\n" for seconds, name in sorted(times, reverse=True)[:SHOWN])
    yield "\n"


def with_summary(lines, read_log):
    """The log is whole when ctest has ended, so its summary waits for the end of the lines."""
    times, summary = [], []
    for line in lines:
        if summary or re.match(r"\d+% tests passed", line):
            summary.append(line)
            continue
        if ended := ENDED.match(line):
            times.append((float(ended[2]), ended[1]))
        yield line
    if times:
        yield from of_the_programs(read_log())
        yield from slowest(times)
    yield from summary


if __name__ == "__main__":
    for text in with_summary(sys.stdin, lambda: pathlib.Path(sys.argv[1]).read_text(encoding="utf-8", errors="replace")):
        print(text, end="", flush=True)
