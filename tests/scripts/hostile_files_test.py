# SPDX-License-Identifier: Apache-2.0
"""Files that declare more than they hold, or nest without end: refused by name, without the memory they ask for."""

import resource
import tempfile
import unittest
from pathlib import Path

import h5py
import numpy as np

import fake_site  # finds the scripts
from nightmap_eval.artifacts import bridged_frames
from nightmap_eval.grid import read_grid
from nightmap_eval.ply import read_ply
from nightmap_eval.sealed_hdf5 import seal, sealed
from nightmap_site.checked_reading import read_json, read_toml
from nightmap_site.script_errors import DataError
from nightmap_site.site import Site

MAX_BYTES = 4 << 30  # of address space: libraries alone reserve one

PLY = b"ply\nformat %s 1.0\nelement vertex %s\nproperty float x\nproperty float y\nproperty float z\nend_header\n"
YAML = "image: map.pgm\nresolution: %s\norigin: [%s, 0, 0]\n"


class HostileFilesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        before = resource.getrlimit(resource.RLIMIT_AS)
        self.addCleanup(resource.setrlimit, resource.RLIMIT_AS, before)
        resource.setrlimit(resource.RLIMIT_AS, (MAX_BYTES, before[1]))

    def write(self, name, content):
        path = self.folder / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        return path

    def assert_refused(self, read, path, argument=None):
        with self.assertRaisesRegex(DataError, str(path)):
            read(argument or path)

    def test_a_cloud_that_declares_more_points_than_it_holds(self):
        for file_format in (b"ascii", b"binary_little_endian"):
            for count in (b"1000000000000", b"-1", b"1e3", b"9" * 5000, b""):
                path = self.write("a.ply", PLY % (file_format, count) + bytes(12))
                self.assert_refused(read_ply, path)

    def test_a_header_of_a_cloud_that_is_none(self):
        good = PLY % (b"binary_little_endian", b"1")
        for before, after in (
            (b"property float x", b"property float y"),
            (b"property float x", b"property float"),
            (b"property float x", b"property list what uint x"),
            (b"property float x\nproperty float y\nproperty float z\n", b""),
            (b"element vertex 1\n", b""),
            (b"element vertex 1", b"element edge 1"),
            (b"property float x", b"property float u"),
        ):
            self.assert_refused(read_ply, self.write("a.ply", good.replace(before, after) + bytes(12)))
        vertices, _ = read_ply(self.write("a.ply", good + bytes(12)))
        self.assertEqual(vertices.shape, (1, 3))
        self.assert_refused(read_ply, self.write("a.ply", PLY % (b"ascii", b"1") + b"1 2 3\n"))
        face = good.replace(b"end_header", b"element face 1\nproperty uchar a\nend_header")
        self.assert_refused(read_ply, self.write("a.ply", face + bytes(13)))

    def test_a_grid_of_no_size(self):
        pgm = self.write("map.pgm", b"P5\n2 1\n255\n\x00\xfe")
        yaml = self.write("map.yaml", YAML % ("0.1", "0"))
        self.assertEqual(read_grid(yaml).cells.shape, (1, 2))
        for resolution, x in (("0", "0"), ("-1", "0"), ("nan", "0"), ("inf", "0"), ("0.1", "nan")):
            self.assert_refused(read_grid, self.write("map.yaml", YAML % (resolution, x)))
        self.write("map.yaml", YAML % ("0.1", "0"))
        for width in (b"100000", b"9" * 5000):
            self.write("map.pgm", b"P5\n" + width + b" 100000\n255\n\x00\xfe")
            self.assert_refused(read_grid, pgm, yaml)

    def test_nesting_without_end(self):
        path = self.write("deep.json", "[" * 100000)
        self.assert_refused(read_json, path)
        path = self.write("deep.toml", "a = " + "[" * 100000)
        self.assert_refused(read_toml, path)

    def test_odometry_that_declares_more_frames_than_it_holds(self):
        (self.folder / "frames").mkdir()
        (self.folder / "odometry").mkdir()
        self.write("frames/shards.txt", "nightmap shards, version 1, 1 names\n0000\n")
        path = self.folder / "odometry" / "shard_0000.h5"

        def huge(file):
            file.create_dataset("state", (10**12, 1), "u1")

        def chunked(file):
            file.create_dataset("state", (10**12, 1), "u1", chunks=(1024, 1), compression="gzip")

        def external(file):
            file["state"] = h5py.ExternalLink("other.h5", "state")

        def shorter(file):
            file["state"] = np.zeros((1, 1), np.uint8)

        def text(file):
            file["state"] = ["a", "b"]

        for write_state in (huge, chunked, external, shorter, text, lambda file: file.create_group("state")):
            with h5py.File(path, "w") as file:
                file["frame_idx"] = np.arange(2).reshape(2, 1)
                seal(file)
                write_state(file)
            self.assert_refused(bridged_frames, path, Site(self.folder))
        with sealed(path) as file:
            file["frame_idx"], file["state"] = np.arange(2).reshape(2, 1), np.array([[0], [1]], np.uint8)
        self.assertEqual(bridged_frames(Site(self.folder)), [1])


if __name__ == "__main__":
    unittest.main()
