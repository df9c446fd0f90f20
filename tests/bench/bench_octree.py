#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""bench_octree: compares our octree builder with OctoMap's insertPointCloud (lazy evaluation).

Each CASE is SITE_DIR[:POSES[:STRIDE]]: a mapped site, its `keyframes` (default) or `trajectory`, and a
stride over them. Every fifth pose is held out. All builders get the same points: every measured pixel of
the other poses. Builders take turns, each in its own process; the shortest of --repeats times counts: from
points to the list of leaves for ours, the insertion alone for OctoMap's. IoU compares the voxels with those
of OctoMap's default. "Rays" is the share of held-out rays that end in an occupied voxel and cross no
occupied voxel up to two voxels before it.
Prints a Markdown table; with --page it goes between `<!-- bench_octree:begin -->` and
`<!-- bench_octree:end -->`.
Exit codes: 0 done; 1 a run failed; 2 wrong command line.
"""

import json
import tempfile
from pathlib import Path

from command_line import markdown, output_of, parser_of, put_into_page  # first: it makes the packages of scripts/ importable
from nightmap_site.script_errors import DataError, run_main

BUILDERS = {
    "OctoMap": ["--builder", "octomap"],
    "OctoMap, discretize": ["--builder", "octomap", "--discretize"],
    "batched, 1 thread": ["--discretize", "--threads", "1"],
    "batched, 2 threads": ["--discretize", "--threads", "2"],
}
TITLES = [
    "site", "voxel (cm)", "builder", "ms/frame", "CPU ms/frame", "times OctoMap", "times its discretize",
    "IoU occupied", "IoU free", "peak (MiB)", "rays (%)",
]  # fmt: skip


def parse_arguments():
    parser = parser_of(__doc__, "data", "page")
    parser.add_argument("cases", nargs="+", metavar="CASE", help="SITE_DIR[:POSES[:STRIDE]]")
    parser.add_argument("--build", type=Path, required=True, help="folder of the build, with bench_octree")
    parser.add_argument("--voxels_cm", type=float, nargs="+", default=(4, 2))
    parser.add_argument("--repeats", type=int, default=3)
    arguments = parser.parse_args()
    if arguments.repeats < 1 or min(arguments.voxels_cm) <= 0:
        parser.error("--repeats must be at least 1, --voxels_cm positive")
    return arguments


def run_once(arguments, case, voxel_cm, options):
    site, poses, stride = (case.split(":") + ["keyframes", "1"][case.count(":") :])[:3]
    command = [
        str(arguments.build / "bench_octree"), "--site", site, "--data", str(arguments.data),
        "--poses", poses, "--stride", stride, "--resolution_m", str(voxel_cm / 100), *options,
    ]  # fmt: skip
    printed = output_of(command)
    try:
        return json.loads(printed)
    except ValueError:
        raise DataError(f"{' '.join(command)}\n{printed}\nthe benchmark printed no figures; build it again") from None


def measure(arguments, case, voxel_cm, folder):
    """Builder -> its fastest result."""
    reference = Path(folder) / "reference.ot"
    best = {}
    for _ in range(arguments.repeats):
        for name, options in BUILDERS.items():
            output = "--out" if name == "OctoMap" else "--reference"
            result = run_once(arguments, case, voxel_cm, [*options, output, str(reference)])
            if name not in best or result["wall_ms"] < best[name]["wall_ms"]:
                best[name] = result
    return best


def rows(case, voxel_cm, results):
    site = Path(case.split(":")[0]).name
    for name, result in results.items():
        yield [
            f"{site} ({result['num_frames']} x {result['points_per_frame']:,} points)", f"{voxel_cm:g}", name,
            f"{result['wall_ms']:.1f}", f"{result['cpu_ms']:.1f}",
            f"{results['OctoMap']['wall_ms'] / result['wall_ms']:.1f}",
            f"{results['OctoMap, discretize']['wall_ms'] / result['wall_ms']:.1f}",
            f"{result.get('iou_occupied', 1):.3f}", f"{result.get('iou_free', 1):.3f}",
            f"{result['peak_mib']:.0f}", f"{100 * result['ray_agreement']:.2f}",
        ]  # fmt: skip


def main():
    arguments = parse_arguments()
    lines = []
    with tempfile.TemporaryDirectory() as folder:
        for case in arguments.cases:
            for voxel_cm in arguments.voxels_cm:
                lines += rows(case, voxel_cm, measure(arguments, case, voxel_cm, folder))
    table = markdown(TITLES, lines, 3)
    print(table, end="")
    put_into_page(arguments, "bench_octree", table)


if __name__ == "__main__":
    run_main(main)
