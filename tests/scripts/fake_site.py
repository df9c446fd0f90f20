# SPDX-License-Identifier: Apache-2.0
"""A small site folder with known truth, for the tests of evaluate.py and report.py."""

import importlib
import io
import json
import sys
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import dataclass
from pathlib import Path
from unittest import mock

import numpy as np

CHECKOUT = Path(__file__).resolve().parent.parent.parent
SCRIPTS = CHECKOUT / "scripts"
BENCH = CHECKOUT / "tests" / "bench"
for folder in (SCRIPTS, BENCH, *(BENCH / name for name in ("faults", "laser", "people"))):
    if str(folder) not in sys.path:
        sys.path.insert(0, str(folder))

from nightmap_eval.trajectory import Trajectory, quaternion  # noqa: E402
from nightmap_site.script_errors import run_main  # noqa: E402

NUM_FRAMES = 40
POSE_HEADER = "tx_m,ty_m,tz_m,qx,qy,qz,qw"


def rotation_about(axis, angle_rad):
    """Rodrigues' formula."""
    x, y, z = np.asarray(axis, dtype=float) / np.linalg.norm(axis)
    k = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle_rad) * k + (1 - np.cos(angle_rad)) * k @ k


def walk(num_poses=NUM_FRAMES):
    """A closed walk of 2 m x 1 m that also rises and falls, looking around."""
    phase = np.linspace(0, 2 * np.pi, num_poses)
    positions = np.column_stack([2 * np.cos(phase), np.sin(phase), 1.2 + 0.1 * np.sin(3 * phase)])
    rotations = [rotation_about([0.2, 0.1, 1], angle) for angle in phase]
    times_ns = 10**18 + np.arange(num_poses) * 100_000_000
    return Trajectory(times_ns, positions, np.array([quaternion(r) for r in rotations]))


def moved(trajectory, rotation, translation_m):
    """The trajectory seen from another frame of reference."""
    return Trajectory(
        trajectory.times_ns,
        trajectory.positions_m @ rotation.T + translation_m,
        np.array([quaternion(rotation @ r) for r in trajectory.rotations()]),
    )


def write_tum(path, trajectory):
    lines = ["# a pose a line"]
    for time_ns, p, q in zip(trajectory.times_ns, trajectory.positions_m, trajectory.quaternions):
        seconds = f"{time_ns // 10**9}.{time_ns % 10**9:09d}"
        lines.append(" ".join([seconds] + [f"{float(v):.9f}" for v in (*p, *q)]))
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text("\n".join(lines) + "\n")


def write_frames(site_dir, trajectory):
    """Two shards; the second holds the last fifteen frames."""
    folder = site_dir / "frames"
    folder.mkdir(parents=True)
    header = "frame_idx,time_ns,camera_idx,sequence_idx,color_path,color_hash,depth_path,depth_hash"
    split = len(trajectory) - 15
    for name, indices in (("0000", range(split)), ("0001", range(split, len(trajectory)))):
        rows = [f"{i},{trajectory.times_ns[i]},0,0,rgb/{i}.png,00,depth/{i}.png,00" for i in indices]
        (folder / f"shard_{name}.csv").write_text("\n".join([header, *rows]) + "\n")
    (folder / "shards.txt").write_text("nightmap shards, version 1, 2 names\n0000\n0001\n")


def write_queries(site_dir, located, num_failed):
    """queries.csv: the located poses, then the failures."""
    header = "query_idx,time_ns,color_path,status,reason,num_matches,num_inliers,"
    rows = [header + "reprojection_error_px," + POSE_HEADER]
    for i, time_ns in enumerate(located.times_ns):
        pose = ",".join(f"{v:.9f}" for v in (*located.positions_m[i], *located.quaternions[i]))
        rows.append(f"{i},{time_ns},queries/{i}.png,located,,50,40,0.8,{pose}")
    for i in range(len(located), len(located) + num_failed):
        time_ns = 2 * 10**18 + i
        rows.append(f"{i},{time_ns},queries/{i}.png,not_in_map,too few inliers,9,3,,,,,,,,")
    (site_dir / "localize").mkdir(exist_ok=True)
    (site_dir / "localize" / "queries.csv").write_text("\n".join(rows) + "\n")


def write_pgm(path, pixels):
    """pixels[row, column], bottom row first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    height, width = pixels.shape
    path.write_bytes(b"P5\n%d %d\n255\n" % (width, height) + pixels[::-1].tobytes())


def write_map(folder, name, pixels, origin_m=(-3.0, -2.0), resolution_m=0.1):
    write_pgm(folder / f"{name}.pgm", pixels)
    (folder / f"{name}.yaml").write_text(
        f"image: {name}.pgm\nresolution: {resolution_m}\n"
        f"origin: [{origin_m[0]}, {origin_m[1]}, 0]\n"
        "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    )


def room_pixels():
    """6 m x 4 m of free space, a wall all around, a cabinet in the lower left corner."""
    pixels = np.full((40, 60), 254, dtype=np.uint8)
    pixels[[0, -1], :] = 0
    pixels[:, [0, -1]] = 0
    pixels[1:4, 1:9] = 0
    return pixels


def write_receipt(site_dir, stage, name="receipt.json"):
    receipt = {
        "stage": stage, "version": "0.1.0", "build_type": "Release", "seed": 0, "threads": 2,
        "start_time": "2000-01-01T00:00:00Z", "wall_time_s": 12.5,
        "parts": [{"name": "read", "wall_time_s": 2.5}], "peak_memory_bytes": 512 * 2**20,
        "inputs": [], "outputs": [], "program": {}, "config": "",
    }  # fmt: skip
    (site_dir / stage).mkdir(exist_ok=True)
    (site_dir / stage / name).write_text(json.dumps(receipt))


def write_site(site_dir, truth=True):
    """A site whose map frame is the building turned by 0.5 rad and moved. Returns the estimate."""
    true_walk = walk()
    estimate = moved(true_walk, rotation_about([0, 0, 1], 0.5), np.array([1.0, -2.0, 0.0]))
    write_frames(site_dir, true_walk)
    for stage in ("pose_graph", "adjust"):
        (site_dir / stage).mkdir(parents=True)
    write_tum(site_dir / "map_frame" / "trajectory.tum", estimate)
    write_tum(site_dir / "map_frame" / "keyframes.tum", estimate.select(range(0, NUM_FRAMES, 5)))
    if truth:
        write_tum(site_dir / "frames" / "ground_truth.tum", true_walk)
    return estimate


@dataclass
class Result:
    returncode: int
    stdout: str
    stderr: str


def run(script, *arguments):
    """Runs a script's main as a command would, but in this process: importing matplotlib for every
    test takes longer than the tests."""
    module = importlib.import_module(script.removesuffix(".py"))
    stdout, stderr, code = io.StringIO(), io.StringIO(), 0
    command_line = [script, *map(str, arguments)]
    with redirect_stdout(stdout), redirect_stderr(stderr), mock.patch("sys.argv", command_line):
        try:
            run_main(module.main)
        except SystemExit as stop:
            code = stop.code or 0
    return Result(code, stdout.getvalue(), stderr.getvalue())
