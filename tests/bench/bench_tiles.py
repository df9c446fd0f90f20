#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_tiles: time and memory of the dense stages as a function of the number of keyframes.

Repeats the keyframes of a mapped site side by side, like more rooms of one building: the same pictures at
other poses, decoded again for each copy. Then runs tiles, point_cloud and octree per tile and for the whole,
and grid, one program after the other, with their default configs.
Prints a Markdown table of CPU seconds, summed over all programs, and peak memory per stage; with --page
it goes between `<!-- bench_tiles:begin -->` and `<!-- bench_tiles:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import csv
import math
import shutil
from pathlib import Path

from command_line import markdown, output_of, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
from nightmap_site.checked_reading import read_text, using
from nightmap_site.job_results import StageResult
from nightmap_site.script_errors import DataError, run_main
from nightmap_site.unit_lists import near, read_tiles

STAGES = ("tiles", "point_cloud", "octree", "grid")
VIEW_M = 4.0  # a copy extends this far beyond its cameras


def pose(line, frames):
    """A line of keyframes.tum (time, x, y, rest) and the row of its frame."""
    time_s, x_m, y_m, *rest = line.split()
    seconds, _, fraction = time_s.partition(".")
    time_ns = int(seconds) * 10**9 + int(fraction.ljust(9, "0"))
    return time_ns, float(x_m), float(y_m), rest, frames[time_ns]


class Original:
    """Keyframes of a site: poses (time, position, rest of the line) and the rows of their frames."""

    def __init__(self, site_dir):
        frames = {}
        for path in sorted((site_dir / "frames").glob("shard_*.csv")):
            with using(path):
                self.header, *rows = csv.reader(read_text(path).splitlines())
                frames |= {int(row[1]): row for row in rows}
        keyframes = site_dir / "map_frame" / "keyframes.tum"
        with using(keyframes):
            self.poses = [pose(line, frames) for line in read_text(keyframes).splitlines() if not line.startswith("#")]
        if not self.poses:
            raise DataError(f"{keyframes}: no keyframe to repeat")
        self.duration_ns = self.poses[-1][0] - self.poses[0][0] + 10**9
        self.width_m = self.extent_m(1)
        self.height_m = self.extent_m(2)

    def extent_m(self, axis):
        values = [pose[axis] for pose in self.poses]
        return max(values) - min(values) + VIEW_M

    def in_copy(self, copy, cells):
        """The cells after time_ns with paths that lead to the copy: no picture may be in two frames."""
        columns = zip(self.header[2:], cells, strict=True)
        return [f"{copy}/{cell}" if name.endswith("_path") and cell else cell for name, cell in columns]

    def repeat(self, count, folder, data):
        """Writes frames.csv and keyframes.tum of `count` keyframes, and a link to the recordings for each copy."""
        (folder / "data").mkdir()
        for copy in range(math.ceil(count / len(self.poses))):
            (folder / "data" / str(copy)).symlink_to(data.resolve())
        num_columns = math.ceil(math.sqrt(count / len(self.poses)))
        rows, lines = [self.header], ["# map_from_camera\n"]
        for idx in range(count):
            copy = idx // len(self.poses)
            time_ns, x_m, y_m, rest, frame = self.poses[idx % len(self.poses)]
            time_ns += copy * self.duration_ns
            x_m += copy % num_columns * self.width_m
            y_m += copy // num_columns * self.height_m
            rows.append([idx, time_ns, *self.in_copy(copy, frame[2:])])
            lines.append(f"{time_ns // 10**9}.{time_ns % 10**9:09} {x_m:.9f} {y_m:.9f} {' '.join(rest)}\n")
        with open(folder / "frames.csv", "w", encoding="utf-8", newline="") as file:
            csv.writer(file, lineterminator="\n").writerows(rows)
        (folder / "keyframes.tum").write_text("".join(lines), encoding="utf-8")


class Bench:
    def __init__(self, folder, arguments):
        self.folder, self.arguments = folder, arguments
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)

    def run(self, stage, suffix, inputs, outputs, program=None):
        """Runs the program of a stage, or another one for it. inputs and outputs are PORT=FILE; inputs lie below the folder,
        outputs below the stage's."""
        (self.folder / stage).mkdir(exist_ok=True)
        ports = [item for port in inputs for item in ("--in", self.absolute(port, self.folder))]
        outputs = [*outputs, f"report=report{suffix}.json", f"receipt=receipt{suffix}.json"]
        ports += [item for port in outputs for item in ("--out", self.absolute(port, self.folder / stage))]
        command = [self.arguments.build / "bin" / (program or stage), *ports, "--threads", str(self.arguments.threads),
                   "--log-level", "warn"]  # fmt: skip
        output_of(command)

    @staticmethod
    def absolute(port, folder):
        name, _, path = port.partition("=")
        return f"{name}={folder / path}"

    def tiles(self):
        return read_tiles(self.folder)

    def run_stage(self, stage):
        data = f"data={self.folder.resolve() / 'data'}"
        if stage == "tiles":
            inputs = ["frames=frames.csv", f"cameras={self.cameras()}", "keyframes=keyframes.tum"]
            self.run("tiles", "", inputs, ["tiles=tiles.txt"])
        elif stage == "point_cloud":
            for tile in self.tiles():
                inputs = [f"tile=tiles/tile_{tile}.json", "cameras=tiles/cameras.json", data]
                self.run(stage, f"_{tile}", inputs, [f"tile_cloud=tile_{tile}.ply", f"places=places_{tile}.csv"])
            inputs = [port for tile in self.tiles() for port in (
                f"tile=tiles/tile_{tile}.json", f"tile_cloud=point_cloud/tile_{tile}.ply",
                f"tile_report=point_cloud/report_{tile}.json")]  # fmt: skip
            self.run(stage, "", inputs, ["cloud=cloud.ply"], "join_clouds")
        elif stage == "octree":
            for tile in self.tiles():
                clouds = [f"cloud=point_cloud/tile_{other}.ply" for other in near(tile, set(self.tiles()))]
                inputs = [f"tile=tiles/tile_{tile}.json", "cameras=tiles/cameras.json", data, *clouds]
                self.run(stage, f"_{tile}", inputs, [f"tile_ot=tile_{tile}.ot"])
            inputs = [port for tile in self.tiles() for port in (
                f"tile=tiles/tile_{tile}.json", f"tile_ot=octree/tile_{tile}.ot",
                f"tile_report=octree/report_{tile}.json")]  # fmt: skip
            self.run(stage, "", inputs, ["ot=map.ot", "bt=map.bt"], "join_octrees")
        else:
            self.run(stage, "", ["octree=octree/map.ot", "keyframes=keyframes.tum"],
                     ["floors=floors.json", "pgm=map.pgm", "yaml=map.yaml", "png=map.png", "distances=distances.h5"])

    def cameras(self):
        return (self.arguments.site_dir / "adjust" / "cameras.json").resolve()

    def row(self, count):
        cells = [f"{count:,}", str(len(self.tiles()))]
        total_s = 0
        for stage in self.arguments.stages:
            result = StageResult(self.folder / stage)
            total_s += result.cpu_time_s()
            cells += [f"{result.cpu_time_s():.1f}", f"{result.peak_memory_bytes() / 2**20:.0f}"]
        return cells + [f"{1e3 * total_s / count:.1f}"]


def table(stages, rows):
    header = ["keyframes", "tiles", *(f"{stage} ({unit})" for stage in stages for unit in ("CPU s", "MiB")),
              "CPU ms per keyframe"]  # fmt: skip
    return markdown(header, rows, 0)


def main():
    parser = parser_of(__doc__, "data", "build", "threads", "page")
    parser.add_argument("site_dir", type=Path, help="maps/SITE with frames and adjust")
    parser.add_argument("--keyframes", type=int, nargs="+", default=[500, 1000, 2000, 5000, 10000])
    parser.add_argument("--stages", nargs="+", choices=STAGES, default=STAGES, help="the rest is left out")
    arguments = parser.parse_args()
    original = Original(arguments.site_dir)
    rows = []
    for count in arguments.keyframes:
        bench = Bench(arguments.build / "bench_tiles" / str(count), arguments)
        original.repeat(count, bench.folder, arguments.data)
        for stage in arguments.stages:
            bench.run_stage(stage)
        rows.append(bench.row(count))
        print(table(arguments.stages, rows), end="", flush=True)
    put_into_page(arguments, "bench_tiles", table(arguments.stages, rows))


if __name__ == "__main__":
    run_main(main)
