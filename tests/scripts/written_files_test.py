# SPDX-License-Identifier: Apache-2.0
"""Artifacts that are not what their receipts say: the scripts refuse them by name."""

import json

import fake_site
from folder_case import FolderTest
from nightmap_site.job_results import StageResult
from nightmap_site.receipts import WrittenFiles, hash_bytes
from nightmap_site.script_errors import DataError


def write_receipt(path, *files, then="/then/site"):
    """The receipt of a run below another folder, which wrote the present bytes of these files."""
    outputs = [{"name": file.name, "path": f"{then}/{path.parent.name}/{file.name}", "xxh3": hash_bytes(file.read_bytes())} for file in files]
    path.write_text(json.dumps({"format": "nightmap receipt", "inputs": [], "outputs": outputs}))


class WrittenFilesTest(FolderTest):
    def setUp(self):
        self.job = self.folder / "site" / "tiles"
        self.job.mkdir(parents=True)

    def write(self, name, content="as written"):
        (self.job / name).write_text(content)
        return self.job / name

    def assert_refused(self, path):
        with self.assertRaisesRegex(DataError, f"^{path}: is not the file that the job wrote .*; delete it and run make again"):
            WrittenFiles().require(path)

    def test_other_bytes_are_refused(self):
        for name, receipt in (("tiles.txt", "receipt.json"), ("tile_-1_2.ply", "receipt_-1_2.json"), ("shard_0001.csv", "receipt.json")):
            with self.subTest(name):
                path = self.write(name)
                write_receipt(self.job / receipt, path)
                WrittenFiles().require(path)
                self.write(name, "as_written")
                self.assert_refused(path)
                (self.job / receipt).unlink()
                WrittenFiles().require(path)

    def test_a_file_that_no_receipt_lists_is_taken(self):
        path = self.write("tiles.txt")
        write_receipt(self.job / "receipt.json", path, then="/then/site/tiles")
        for listed in ("", "{", "[]", "5", '{"format": "nightmap receipt", "outputs": 5}', "[" * 100000, "\xff"):
            (self.job / "receipt.json").write_text(listed, encoding="latin-1")
            WrittenFiles().require(path)
        WrittenFiles().require(self.job / "missing.txt")

    def test_one_of_the_receipts_is_enough(self):
        path = self.write("tile_0_0.ply", "of the tile")
        write_receipt(self.job / "receipt_0_0.json", path)
        self.write("tile_0_0.ply", "of all")
        write_receipt(self.job / "receipt.json", path)
        WrittenFiles().require(path)

    def test_a_report_is_compared(self):
        report = self.write("report.json", '{"num_tiles": 3}')
        write_receipt(self.job / "receipt.json", report)
        self.assertEqual(StageResult(self.job).figures(), {"num_tiles": 3})
        self.write("report.json", '{"num_tiles": 4}')
        with self.assertRaisesRegex(DataError, "report.json: is not the file"):
            StageResult(self.job)


class ScriptsTest(FolderTest):
    """evaluate.py and report.py on a site with receipts, one of whose files changed."""

    def test_each_file_is_named(self):
        site = self.folder / "maps" / "office"
        estimate = fake_site.write_site(site)
        fake_site.write_queries(site, estimate.select(range(3)), 2)
        fake_site.write_map(site / "grid", "map", fake_site.room_pixels())
        (site / "pose_graph" / "loops.csv").write_text("frame_a,frame_b,status,reason\n0,39,accepted,\n")
        changes = {"map_frame/trajectory.tum": "evaluate.py", "frames/shard_0001.csv": "evaluate.py", "localize/queries.csv": "evaluate.py",
                   "pose_graph/loops.csv": "evaluate.py", "frames/shards.txt": "evaluate.py", "grid/map.pgm": "report.py"}  # fmt: skip
        for name, script in changes.items():
            path = site / name
            write_receipt(path.parent / "receipt.json", path)
            self.assertEqual(self.run_script(site, script).returncode, 0)
            before = path.read_bytes()
            path.write_bytes(before[:-2] + bytes([before[-2] ^ 1]) + before[-1:])
            result = self.run_script(site, script)
            path.write_bytes(before)
            self.assertEqual(result.returncode, 1, name)
            self.assertRegex(result.stderr, f"^error: \\S+{name}: is not the file that the job wrote[^\n]*\n$")

    def run_script(self, site, script):
        return fake_site.run(script, "--site-dir", site, "--data", site.parent, "--out", site / "out")
