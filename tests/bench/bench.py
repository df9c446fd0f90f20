#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench: measures the time from raw frames to the optimized trajectory, relative to a yardstick.

The yardstick of a site is measured in the same run: the features stage decodes every frame
and describes 1,000 SIFT features on it, with all cores busy. In a recording of more than 1,000 frames the first 1,000
represent all, since the cost per frame is constant.
Both times include every process and Make itself; programs and recordings are made beforehand.
Prints a Markdown table; with --page it goes between `<!-- bench:begin -->` and `<!-- bench:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import shutil
import time

from command_line import markdown, output_of, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
from nightmap_site.checked_reading import read_object
from nightmap_site.job_results import StageResult, folders_up_to
from nightmap_site.script_errors import run_main
from nightmap_site.unit_lists import read_shards

STAGES = folders_up_to("map_frame")
YARDSTICK = "features.max_gap_frames=0 features.num_features=1000"
YARDSTICK_FRAMES = 1000


class Case:
    """One recording with its own results folder."""

    def __init__(self, site, arguments):
        self.site, self.arguments = site, arguments
        self.folder = arguments.build / "bench" / site
        shutil.rmtree(self.folder, ignore_errors=True)

    def make(self, maps, settings, num_frames, *goals):
        """Seconds that `make` takes; num_frames 0 means all frames."""
        limit = f" frames.max_frames={num_frames}" if num_frames else ""
        command = [
            "make", "--no-print-directory", f"SITE={self.site}", f"DATA={self.arguments.data}",
            f"BUILD={self.arguments.build}", f"THREADS={self.arguments.threads}",
            f"MAPS={self.folder / maps}", f"SET={settings}{limit}", *goals,
        ]  # fmt: skip
        start_s = time.monotonic()
        output_of(command)
        return time.monotonic() - start_s

    def yardstick_s_per_frame(self):
        """Lists the frames before the clock starts: the list is not part of the yardstick."""
        listed = self.folder / "yardstick" / self.site / "frames" / "shards.txt"
        self.make("yardstick", YARDSTICK, YARDSTICK_FRAMES, str(listed))
        features = listed.parent.parent / "features"
        goals = (f"{features}/shard_{shard}.h5" for shard in read_shards(listed.parent.parent))
        wall_time_s = self.make("yardstick", YARDSTICK, YARDSTICK_FRAMES, *goals)
        return wall_time_s / read_object(listed.parent / "report.json", {"num_frames": int})["num_frames"]

    def row(self):
        site = self.folder / "map" / self.site
        s_per_frame = self.yardstick_s_per_frame()
        total_s = self.make("map", "", 0, str(site / "map_frame" / "trajectory.tum"))
        stages = [StageResult(site / name) for name in STAGES]
        num_frames = read_object(site / "pose_graph" / "report.json", {"num_frames": int})["num_frames"]
        yardstick_s = s_per_frame * num_frames
        peak = max(stages, key=lambda stage: stage.peak_memory_bytes())
        return [
            self.site, f"{num_frames}", f"{total_s:.1f}", f"{num_frames / total_s:.1f}",
            f"{1e3 * total_s / num_frames:.1f}", f"{yardstick_s:.1f}", f"{total_s / yardstick_s:.2f}",
            *(f"{stage.wall_time_s():.1f}" for stage in stages),
            f"{peak.peak_memory_bytes() / 2**20:.0f} ({peak.name})",
        ]  # fmt: skip


def table(rows):
    titles = [
        "site", "frames", "total (s)", "frames/s", "ms/frame", "yardstick (s)", "total / yardstick",
        *(f"{name} (s)" for name in STAGES), "peak memory (MiB)",
    ]  # fmt: skip
    return markdown(titles, rows)


def main():
    parser = parser_of(__doc__, "data", "build", "threads", "page")
    parser.add_argument("sites", nargs="+")
    arguments = parser.parse_args()
    rows = []
    for site in arguments.sites:
        rows.append(Case(site, arguments).row())
        print(table(rows[-1:]), flush=True)
    print(table(rows))
    put_into_page(arguments, "bench", table(rows))


if __name__ == "__main__":
    run_main(main)
