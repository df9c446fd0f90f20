# SPDX-License-Identifier: Apache-2.0
"""evaluate.py and report.py on site folders of which one file is damaged: each is named in one line."""

import json

import h5py
import numpy as np

import fake_site
from folder_case import SiteFolderTest
from nightmap_eval.colmap.colmap_run import read_receipt
from nightmap_eval.sealed_hdf5 import sealed
from nightmap_site.script_errors import DataError

# Damage that any JSON file may have.
JSON = (b"", b"{", b"[]", b"5", b"\xff\xfe", b"[" * 100000, b'{"a": Infinity}', b"9" * 5000)


class DamagedFilesTest(SiteFolderTest):
    def setUp(self):
        estimate = fake_site.write_site(self.site_dir)
        fake_site.write_queries(self.site_dir, estimate.select(range(3)), 2)
        fake_site.write_receipt(self.site_dir, "features", "receipt_0000.json")
        fake_site.write_map(self.site_dir / "grid", "map", fake_site.room_pixels())
        (self.site_dir / "pose_graph" / "loops.csv").write_text("frame_a,frame_b,status,reason\n0,39,accepted,\n")

    def check(self, script, name, contents, *words):
        """With each content the script fails, and says of which file in one line."""
        path = self.site_dir / name
        path.parent.mkdir(parents=True, exist_ok=True)
        before = path.read_bytes() if path.exists() else None
        for content in contents:
            with self.subTest(name, content=content[:60]):
                path.write_bytes(content if isinstance(content, bytes) else content.encode())
                for said in (f"^error: .*{name}[^\n]*\n$", *words):
                    self.check_refused(script, said)
        path.unlink() if before is None else path.write_bytes(before)
        self.written(script, "made")

    def test_trajectories_and_truth(self):
        pose = "1000000000 {} 0 0 0 0 0 1\n"
        poses = [pose.format(value) for value in ("1e308", "-1e300", "nan", "inf", "x")]
        times = [pose.replace("1000000000", time).format(0) for time in ("1e300", "-1e10", "9" * 5000, "\u00b2")]
        for name in ("frames/ground_truth.tum", "map_frame/trajectory.tum"):
            self.check("evaluate.py", name, [*poses, *times, b"\xff\xfe\n", b"\0\n", "1 2\n", pose.format(0) * 2])

    def test_lists_of_frames_and_queries(self):
        shard = (self.site_dir / "frames" / "shard_0001.csv").read_text()
        damaged = ["", b"\xff", shard[:-5], shard + "a\0b\n", "x" * 200000]
        self.check("evaluate.py", "frames/shard_0001.csv", damaged, "delete the file")
        queries = (self.site_dir / "localize" / "queries.csv").read_text()
        damaged = [queries.replace("located", "lost", 1), queries.replace("\n0,", "\nx,", 1),
                   queries.replace("\n0,1", f"\n0,{'9' * 30}", 1), queries.replace("not_in_map", "located", 1)]
        header, first, rest = queries.split("\n", 2)
        for value in ("1e308", "nan"):
            cells = first.split(",")
            damaged.append("\n".join([header, ",".join([*cells[:8], value, *cells[9:]]), rest]))
        self.check("evaluate.py", "localize/queries.csv", [*damaged, b"\xff"], "delete the file")

    def test_reports_that_evaluate_reads(self):
        wrong = [b'{"parts": 5}', b'{"parts": [5]}', b'{"parts": [{}]}', b'{"parts": [{"runs": []}, {"runs": [[1]]}]}']
        self.check("evaluate.py", "pose_graph/report.json", [*JSON, *wrong], "delete the file")
        self.check("evaluate.py", "frames/report.json", [*JSON, b'{"num_frames_unusable": "5"}'], "delete the file")
        self.check("evaluate.py", "config/site/office.toml", [b"root = 5", b"root = ", b"\xff", b"a = " + b"[" * 5000])

    def test_arrays(self):
        path = self.site_dir / "odometry" / "shard_0000.h5"
        path.parent.mkdir()
        contents = [b"", b"no HDF5"]
        for arrays in ({}, {"frame_idx": [1, 2]}, {"frame_idx": [1, 2], "state": [1, 2, 3]}):
            with sealed(path) as file:
                file.update(arrays)
            contents.append(path.read_bytes())
        with sealed(path) as file:
            file.update({"frame_idx": [[1], [2]], "state": np.array([[0], [1]], np.uint8)})
        whole = path.read_bytes()
        self.metrics()
        for name, row in (("frame_idx", 1), ("state", 0)):
            with h5py.File(path, "r+") as file:
                file[name][row] = 7
            contents.append(path.read_bytes())
            path.write_bytes(whole)
        path.unlink()
        self.check("evaluate.py", "odometry/shard_0000.h5", contents, "delete the file and run make again")

    def test_reports_and_receipts(self):
        wrong = [b'{"wall_time_s": "5"}', b'{"parts": [{"name": "a"}]}', b'{"peak_memory_bytes": [1]}', b'{"build_type": 1}',
                 b'{"wall_time_s": 1e999}']
        self.check("report.py", "features/receipt_0000.json", [*JSON, *wrong], "delete the file and run make again")
        self.check("report.py", "features/report_0000.json", [*JSON, b'{"skipped": 5}', b'{"skipped": [5]}'], "delete the file")
        self.check("report.py", "plan/path.json", [*JSON, b'{"floor": "top"}'])
        path = "x_m,y_m\n{},0\n"
        self.check("report.py", "plan/path.csv", [path.format(value) for value in ("nan", "1e300", "x")], "delete the file")

    def test_metrics(self):
        truth = fake_site.walk().select(range(3))
        fake_site.write_tum(self.site_dir / "queries" / "query_ground_truth.tum", truth)
        whole = self.metrics()
        damaged = [json.dumps(whole | {name: 5}) for name in ("coverage", "trajectory", "queries", "loops", "map")]
        for name in ("se3", "rpe_per_metre", "truth_from_map_m_q"):
            damaged.append(json.dumps(whole | {"trajectory": whole["trajectory"] | {name: {"num_pairs": 3}}}))
        damaged.append(json.dumps(whole | {"queries": whole["queries"] | {"rows": [{}]}}))
        damaged.append(json.dumps(whole | {"queries": whole["queries"] | {"local": {}}}))
        damaged.append(json.dumps(whole)[:-20])
        self.check("report.py", "evaluate/metrics.json", [*JSON, *damaged], "delete the file and run make again")

    def test_receipts_of_colmap(self):
        path = self.site_dir / "receipt.json"
        wrong = [b"{}", b'{"colmap": "COLMAP 3.8", "threads": "2", "failed": null, "parts": []}',
                 b'{"colmap": "COLMAP 3.8", "threads": 2, "failed": null, "parts": [{"name": "mapper"}]}']
        for content in [*JSON, *wrong]:
            with self.subTest(content[:60]):
                path.write_bytes(content)
                with self.assertRaisesRegex(DataError, f"{path}.*run make evaluate-colmap again"):
                    read_receipt(self.site_dir)
        path.write_bytes(b'{"colmap": "COLMAP 3.8", "threads": 2, "failed": null, "parts": []}')
        self.assertIsNone(read_receipt(self.site_dir)["failed"])

    def test_configs_and_comparison(self):
        self.check("report.py", "config/grid.toml", [b"\xff"], "delete the file")
        self.check("report.py", "evaluate_colmap/results.json", [*JSON, b"{}", b'{"colmap": 5}'], "make evaluate-colmap")
