# SPDX-License-Identifier: Apache-2.0
"""bench_tiles.py: the repeated keyframes are those of a larger building."""

import csv


from folder_case import FolderTest  # first: it makes scripts and benchmarks importable

import bench_tiles


HEADER = "frame_idx,time_ns,camera_idx,sequence_idx,color_path,color_hash,depth_path,depth_hash"
POSES = ((1.5, 0.0, 0.0), (2.0, 3.0, 1.0), (2.25, 1.0, 5.0))


class RepeatTest(FolderTest):
    def setUp(self):
        for name in ("frames", "map_frame"):
            (self.folder / name).mkdir()
        rows = [f'{i},{round(1e9 * time_s)},0,0,"a,{i}.jpg",ab,d{i}.png,cd' for i, (time_s, _, _) in enumerate(POSES)]
        (self.folder / "frames" / "shard_0000.csv").write_text("\n".join([HEADER, *rows]) + "\n")
        lines = [f"{time_s:.6f} {x} {y} 1.0 0 0 0 1\n" for time_s, x, y in POSES]
        (self.folder / "map_frame" / "keyframes.tum").write_text("# comment\n" + "".join(lines))
        recordings = self.folder / "recordings"
        recordings.mkdir()
        (recordings / "a,1.jpg").write_text("picture 1")
        bench_tiles.Original(self.folder).repeat(8, self.folder, recordings)

    def test_copies_lie_side_by_side(self):
        lines = (self.folder / "keyframes.tum").read_text().splitlines()[1:]
        positions = [tuple(map(float, line.split()[1:3])) for line in lines]
        # Two columns; a copy is 3 m x 5 m and 4 m of view larger.
        for copy, (shift_x_m, shift_y_m) in enumerate([(0, 0), (7, 0), (0, 9)]):
            for idx, (_, x_m, y_m) in enumerate(POSES[: 8 - 3 * copy]):
                self.assertEqual(positions[3 * copy + idx], (x_m + shift_x_m, y_m + shift_y_m))
        self.assertEqual(len(positions), 8)

    def test_every_keyframe_has_a_frame_of_its_own_time_and_of_its_own_pictures_which_are_those_of_the_original(self):
        with open(self.folder / "frames.csv", encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        lines = (self.folder / "keyframes.tum").read_text().splitlines()[1:]
        self.assertEqual([row["frame_idx"] for row in rows], [str(idx) for idx in range(8)])
        times_ns = [int(row["time_ns"]) for row in rows]
        self.assertEqual(times_ns, sorted(set(times_ns)))
        self.assertEqual(times_ns, [int(line.split()[0].replace(".", "")) for line in lines])
        self.assertEqual([row["color_path"] for row in rows], [f"{idx // 3}/a,{idx % 3}.jpg" for idx in range(8)])
        self.assertEqual([row["depth_path"] for row in rows], [f"{idx // 3}/d{idx % 3}.png" for idx in range(8)])
        self.assertEqual((self.folder / "data" / rows[7]["color_path"]).read_text(), "picture 1")
