# SPDX-License-Identifier: Apache-2.0
"""verify.py on whole, altered and damaged site folders."""

import json
import os

import fake_site
from folder_case import SiteFolderTest
from nightmap_site.receipts import Hashes

DAMAGED = (b"", b"{", b"[]", b"5", b"{}", b'{"inputs": [], "outputs": []}', b'{"inputs": [5], "outputs": []}', b"\xff\xfe",
           b'{"inputs": [], "outputs": [{"path": 5, "name": "a"}]}', b"[" * 100000, b'{"a": NaN}', b"1" * 5000,
           b'{"inputs": [], "outputs": [{"path": "report.json", "name": "report.json"}]}')


class VerifyTest(SiteFolderTest):
    def setUp(self):
        self.frames = self.write("frames/shard_0000.csv", "frames")
        self.write("frames/shards.txt", "nightmap shards, version 1, 1 names\n0000\n")
        for shard in ("0000", "0001"):
            self.run_of_features(shard)

    def run_of_features(self, shard):
        """Files of a run in a folder that was moved since."""
        outputs = [self.write(f"features/{name}", name) for name in (f"shard_{shard}.h5", f"report_{shard}.json")]
        content = {kind: [{"name": path.name, "path": f"was/office/{path.relative_to(self.site_dir)}", "xxh3": Hashes().of(path)}
                          for path in paths] for kind, paths in (("inputs", [self.frames]), ("outputs", outputs))}  # fmt: skip
        self.write(f"features/receipt_{shard}.json", json.dumps(content))

    def verify(self, code):
        result = fake_site.run("verify.py", self.site_dir)
        self.assertEqual(result.returncode, code, result.stderr)
        return result

    def test_a_whole_site(self):
        self.assertIn("1 receipts, 3 files: all as written", self.verify(0).stdout)

    def test_altered_and_missing_files_are_named(self):
        self.write("features/shard_0000.h5", "altered")
        self.assertIn("shard_0000.h5: altered since it was written", self.verify(1).stderr)
        self.frames.unlink()
        self.frames.mkdir()
        self.assertIn("shard_0000.csv: missing or not readable", self.verify(1).stderr)

    def test_shards_that_are_no_more_do_not_count(self):
        self.write("features/shard_0001.h5", "altered")
        self.verify(0)
        self.write("frames/shards.txt", "nightmap shards, version 1, 2 names\n0000\n0001\n")
        self.assertIn("shard_0001.h5: altered", self.verify(1).stderr)

    def test_damaged_receipts_are_named(self):
        path = self.site_dir / "features" / "receipt_0000.json"
        for content in DAMAGED:
            with self.subTest(content[:60]):
                path.write_bytes(content)
                result = self.verify(1)
                self.assertRegex(result.stderr, f"^{path}.*delete the file and run make again\n$")
        path.unlink()
        os.mkfifo(path)
        self.assertIn(f"{path}: not a file", self.verify(1).stderr)

    def test_no_receipts(self):
        self.check_failed(fake_site.run("verify.py", self.site_dir / "elsewhere"), "run make map first")
