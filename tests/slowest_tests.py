#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Passes the output of ctest on, and puts the slowest ten tests and their times before its summary."""
import re
import sys

SHOWN = 10
TEST = re.compile(r"\s*\d+/\d+ Test +#\d+: (\S+) .*?([\d.]+) sec")


def with_slowest(lines):
    times = []
    for line in lines:
        test = TEST.match(line)
        if test:
            times.append((float(test[2]), test[1]))
        if re.match(r"\d+% tests passed", line) and times:
            yield "Slowest tests:\n"
            yield from (f"{seconds:8.1f} s  {name}\n" for seconds, name in sorted(times, reverse=True)[:SHOWN])
            yield "\n"
        yield line


if __name__ == "__main__":
    for text in with_slowest(sys.stdin):
        print(text, end="", flush=True)
