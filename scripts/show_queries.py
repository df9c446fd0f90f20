#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Prints where the pictures, or the laser scans, of a site were taken: a table of those in QUERY, a count of the site's own and the
first dozen of them.

Place and heading are those of the camera in the map frame, or of the robot that scanned; heading is the viewing direction, or where the
robot points, counter-clockwise from x.
Exit codes: 0 printed; 1 missing or damaged data.
"""

import os
import sys
from collections import Counter

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from nightmap_site.query_results import Floors, asked_names, read_queries  # noqa: E402
from nightmap_site.script_errors import printable, run_main  # noqa: E402
from nightmap_site.site import Site  # noqa: E402

NUM_OWN = 12


def table(queries, floors, asks):
    titles = [asks.removesuffix("s"), "verdict", "x (m)", "y (m)", "z (m)", "heading (deg)",
              *(["floor"] if floors.are_several else []), "sigma (cm)", "sigma (deg)", "reason"]  # fmt: skip
    rows = [titles, *(_cells(query, floors) for query in queries)]
    widths = [max(map(len, column)) for column in zip(*rows)]
    is_text = [i < 2 or title == "reason" for i, title in enumerate(titles)]
    return ["  ".join(cell.ljust(width) if text else cell.rjust(width)
                      for cell, width, text in zip(row, widths, is_text)).rstrip() for row in rows]  # fmt: skip


def _cells(query, floors):
    numbers = [""] * (7 if floors.are_several else 6)
    if query.place_m:
        numbers = [f"{value:.2f}" for value in query.place_m] + [f"{query.heading_deg:.0f}"]
        numbers += [str(floors.number_at(query.place_m[2]))] if floors.are_several else []
        numbers += [f"{100 * query.sigma_m:.1f}", f"{query.sigma_deg:.2f}"]
    return [printable(query.name), query.verdict, *numbers, query.reason]


def counted(queries):
    verdicts = Counter(query.verdict for query in queries)
    return f"{len(queries)} queries of the site: " + ", ".join(f"{n} {verdict}" for verdict, n in verdicts.items())


def lines(site_dir):
    site = Site(site_dir)
    queries, asked, floors, asks = read_queries(site), asked_names(site), Floors(site), site.pipeline.asks
    of_query = [query for query in queries if query.name in asked]
    own = [query for query in queries if query.name not in asked]
    result = table(of_query, floors, asks) if of_query else []
    if own:
        result.append(counted(own))
    if own and not of_query:
        result += table(own[:NUM_OWN], floors, asks)
        result += ["..."] if len(own) > NUM_OWN else []
    return result


def main():
    [site_dir] = sys.argv[1:]
    print(printable("\n".join(lines(site_dir))))


if __name__ == "__main__":
    run_main(main)
