#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""paste_people: pastes photographed people into a recording; who pauses stands still in the room, not in the picture.

RECORDING has rgb.txt, depth.txt (registered to color) and groundtruth.txt in TUM layout; PEOPLE has photographs NAME.jpg with
label images NAME_label.png in the colors of PASCAL VOC. Every 1.2 s each person either pauses or walks to a place that the
camera sees then. Writes rgb/, depth/, label/ (15 = a person, 0 = not pasted), moving/ (255 = a person that is
faster than 2 cm/s since the frame before and until the next),
their lists and the truth to OUT, the same bytes for the same --seed.
Exit codes: 0 done; 1 the input cannot be read or used; 2 wrong command line.
"""

import argparse
import shutil
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import checkout  # noqa: E402, F401  first: it makes the packages of scripts/ importable
import numpy as np  # noqa: E402
from nightmap_eval.trajectory import parse_time_ns, read_tum  # noqa: E402
from nightmap_site.script_errors import DataError, run_main  # noqa: E402
from PIL import Image  # noqa: E402

from boards import Board, cut_outs, rays_of  # noqa: E402
from walks import KNOT_S, View, leave, poses_at, sit, wander  # noqa: E402

LENGTH_M = (1.0, 1.25)  # of a cut-out, which often ends at the waist
FOLDERS = ("rgb", "depth", "label", "moving")


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    for name in ("recording", "people", "out"):
        parser.add_argument(name, type=Path, metavar=name.upper())
    parser.add_argument("--people", dest="num_people", type=int, default=4, help="how many (default 4)")
    parser.add_argument("--seed", type=int, default=0, help="of their ways (default 0)")
    for name in ("fx", "fy", "cx", "cy"):
        parser.add_argument(f"--{name}", type=float, required=True)
    parser.add_argument("--distortion", type=float, nargs=5, default=[0] * 5, metavar=("K1", "K2", "P1", "P2", "K3"))
    parser.add_argument("--depth-units", type=float, default=5000, help="per metre (default 5000)")
    parser.add_argument("--fps", type=float, help="frames a second, where the times of rgb.txt are nominal")
    parser.add_argument("--nearest", type=float, default=1.0, help="depth of who is nearest (m): lower, they cover more (default 1)")
    parser.add_argument("--leaver", action="store_true", help="the first person stands still for a third of the time, and leaves for good")
    parser.add_argument("--sitter", action="store_true", help="the last person never moves")
    arguments = parser.parse_args()
    above_0 = (arguments.fx, arguments.fy, arguments.depth_units, arguments.nearest)
    if arguments.num_people < arguments.leaver + arguments.sitter or min(above_0) <= 0:
        parser.error("--people must be enough for --leaver and --sitter, and --fx, --fy, --depth-units and --nearest above 0")
    if arguments.fps is not None and arguments.fps <= 0:
        parser.error("--fps must be above 0")
    return arguments


def read_list(path):
    """(time as written, time in ns, file) of each line."""
    try:
        lines = [line.split() for line in path.read_text().splitlines() if line.strip() and not line.startswith("#")]
        rows = [(words[0], parse_time_ns(words[0]), path.parent / words[1]) for words in lines]
    except (IndexError, ValueError):
        raise DataError(f"{path}: not a list of times and files; give a recording in TUM layout") from None
    if not rows:
        raise DataError(f"{path}: lists no file; give a recording with pictures")
    return rows


def opened(path):
    try:
        with Image.open(path) as picture:
            picture.load()
            return picture
    except OSError as error:
        raise DataError(f"{path}: {error}; give a picture that can be read") from None


def read_people(folder):
    labels = sorted(folder.glob("*_label.png"))
    found = [cut for path in labels for cut in cut_outs(opened(path.with_name(path.name.replace("_label.png", ".jpg"))), opened(path))]
    if not found:
        raise DataError(f"{folder}: shows no large person; give NAME.jpg with NAME_label.png in the colors of PASCAL VOC")
    return found


def view_of(arguments, colors):
    """The camera and its poses, and the seconds from the start at which knots are."""
    times_ns = np.array([time_ns for _, time_ns, _ in colors])
    frame_s = (times_ns - times_ns[0]) / 1e9 if arguments.fps is None else np.arange(len(colors)) / arguments.fps
    knot_s = KNOT_S * np.arange(int(frame_s[-1] / KNOT_S) + 2)
    truth = read_tum(arguments.recording / "groundtruth.txt", "give the recording with its ground truth")
    if len(truth) == 0:
        raise DataError(f"{arguments.recording / 'groundtruth.txt'}: has no pose; give the recording with its ground truth")
    knots_ns = times_ns[0] + np.interp(knot_s, frame_s, times_ns - times_ns[0]).astype(np.int64)
    width, height = opened(colors[0][2]).size
    lens = (arguments.fx, arguments.fy, arguments.cx, arguments.cy)
    return View(*lens, width, height, arguments.nearest, frame_s, poses_at(truth, times_ns), poses_at(truth, knots_ns))


def people_of(arguments, view):
    """(board, way) of each person, of a random stream of its own."""
    pictures, people = read_people(arguments.people), []
    for i in range(arguments.num_people):
        random = np.random.default_rng((arguments.seed, i))
        picture = pictures[i % len(pictures)][:, :: random.choice([-1, 1])]
        board = Board(picture, random.uniform(*LENGTH_M))
        leaves, sits = arguments.leaver and i == 0, arguments.sitter and i == arguments.num_people - 1
        people.append((board, (leave if leaves else sit if sits else wander)(view, random)))
    return people


def paste(frame, people, rays, view, k, random):
    """The people in frame k; the farthest first, so that edges of nearer ones are soft before them."""
    camera_m, rotation = view.frames.positions_m[k], view.frames.rotations()[k]
    around_s = view.frame_s[max(0, k - 1):k + 2]
    there = [(board, pose, way.moves(around_s)) for board, way in people if (pose := way.at(view.frame_s[k])) is not None]
    for board, pose, moves in sorted(there, key=lambda person: -((person[1][0] - camera_m) @ rotation)[2]):
        board.paste(rays, camera_m, rotation, pose, moves, frame, random)


def read_frame(color_path, depth_path, depth_units):
    color = np.array(opened(color_path).convert("RGB"))
    depth_m = np.array(opened(depth_path)) / depth_units
    if depth_m.shape != color.shape[:2]:
        raise DataError(f"{depth_path}: its size is not that of {color_path}; give depth that is registered to color")
    return {"color": color, "depth_m": depth_m, "label": np.zeros(depth_m.shape, np.uint8), "moving": np.zeros(depth_m.shape, np.uint8)}


def write_frame(out, name, frame, depth_units):
    Image.fromarray(frame["color"]).save(out / "rgb" / f"{name}.jpg", quality=95)
    Image.fromarray(np.clip(np.rint(frame["depth_m"] * depth_units), 0, 65535).astype(np.uint16)).save(out / "depth" / f"{name}.png")
    for kind in ("label", "moving"):
        Image.fromarray(frame[kind]).save(out / kind / f"{name}.png")


def main():
    arguments = parse_arguments()
    colors, depths = (read_list(arguments.recording / name) for name in ("rgb.txt", "depth.txt"))
    view = view_of(arguments, colors)
    people = people_of(arguments, view)
    if arguments.out.exists():
        raise DataError(f"{arguments.out}: exists; remove it, or name another folder")
    for folder in FOLDERS:
        (arguments.out / folder).mkdir(parents=True)
    rays = rays_of(view.width, view.height, view.fx, view.fy, view.cx, view.cy, arguments.distortion)
    depth_ns, num_px = np.array([time_ns for _, time_ns, _ in depths]), []
    for k, (_, time_ns, path) in enumerate(colors):
        frame = read_frame(path, depths[np.argmin(np.abs(depth_ns - time_ns))][2], arguments.depth_units)
        paste(frame, people, rays, view, k, np.random.default_rng((arguments.seed, arguments.num_people, k)))
        write_frame(arguments.out, path.stem, frame, arguments.depth_units)
        num_px.append((np.count_nonzero(frame["label"]), np.count_nonzero(frame["moving"])))
    for name, ending in (("rgb", "jpg"), ("depth", "png")):
        # Depth has the time of the picture that it was pasted for.
        lines = (f"{time} {name}/{path.stem}.{ending}\n" for time, _, path in colors)
        (arguments.out / f"{name}.txt").write_text("".join(lines))
    shutil.copyfile(arguments.recording / "groundtruth.txt", arguments.out / "groundtruth.txt")
    shown, moving = np.array(num_px, float).T
    shares, pausing = 100 * shown / (view.width * view.height), 100 * (1 - moving.sum() / max(1, shown.sum()))
    print(f"{len(colors)} frames; people cover {shares.mean():.1f} % on average and {shares.max():.1f} % at most; "
          f"{pausing:.1f} % of their pixels pause")  # fmt: skip


if __name__ == "__main__":
    run_main(main)
