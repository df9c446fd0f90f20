#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Times a whole map against a yardstick of the same run and prints total / yardstick.

The yardstick is what no map can do without doing something cleverer: decode every frame and
describe 1,000 SIFT features on each, all cores busy. It is the features stage at that setting; the
map is made from nothing, without building programs or making the recording.
"""
import argparse
import json
import pathlib
import re
import shutil
import subprocess
import sys
import time


def make(arguments, maps, *goals):
    command = ["make", "--no-print-directory", f"SITE={arguments.site}", f"DATA={arguments.data}",
               f"BUILD={arguments.build}", f"THREADS={arguments.threads}", f"MAPS={maps}", *goals]
    start = time.monotonic()
    result = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if result.returncode != 0:
        sys.exit(f"{' '.join(command)}\n{result.stdout}\nbench: the run failed, see above")
    return time.monotonic() - start


def seconds_by_stage(folder):
    total = {}
    for path in sorted(folder.glob("*/receipt*.json")):
        receipt = json.loads(path.read_text(encoding="utf-8"))
        total[receipt["stage"]] = total.get(receipt["stage"], 0) + receipt["wall_time_s"]
    return total


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    for name in ("site", "data", "build", "threads"):
        parser.add_argument(f"--{name}", required=True)
    arguments = parser.parse_args()
    folder = pathlib.Path(arguments.build) / "bench"
    shutil.rmtree(folder, ignore_errors=True)
    lists = f"{folder}/yardstick/{arguments.site}/frames/shards.mk"
    make(arguments, folder / "yardstick", lists)
    shards = re.findall(r"\d{4,}", pathlib.Path(lists).read_text(encoding="utf-8"))
    features = [f"{folder}/yardstick/{arguments.site}/features/shard_{shard}.h5" for shard in shards]
    yardstick_s = make(arguments, folder / "yardstick", "SET=features.num_features=1000", *features)
    total_s = make(arguments, folder / "map", "map")
    for stage, seconds in seconds_by_stage(folder / "map" / arguments.site).items():
        print(f"{stage:12} {seconds:8.1f} s")
    print(f"{'total':12} {total_s:8.1f} s\n{'yardstick':12} {yardstick_s:8.1f} s   decode + 1000 SIFT a frame")
    print(f"total / yardstick = {total_s / yardstick_s:.2f}   ({arguments.site}, {arguments.threads} threads)")
    return 0


if __name__ == "__main__":
    sys.exit(main())
