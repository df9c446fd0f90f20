#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Pictures that the scripts open: no files of other kinds."""
import os
import sys
import tempfile
import unittest
from pathlib import Path

from PIL import Image

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "scripts"))

from nightmap_eval.pictures import open_picture  # noqa: E402


class PicturesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = Path(folder.name) / "a.png"

    def test_pictures_of_the_stages_are_opened(self):
        for name in ("PNG", "JPEG", "TIFF", "BMP", "PPM", "WEBP"):
            Image.new("RGB", (8, 6), (9, 9, 9)).save(self.path, name)
            with self.subTest(name), open_picture(self.path) as picture:
                self.assertEqual(picture.convert("RGB").size, (8, 6))

    def test_files_of_other_kinds_are_not(self):
        for name in ("GIF", "EPS", "TGA", "PCX"):
            Image.new("RGB", (8, 6)).save(self.path, name)
            with self.subTest(name), self.assertRaises(OSError):
                open_picture(self.path)
        self.path.unlink()
        os.mkfifo(self.path)
        with self.assertRaises(OSError):
            open_picture(self.path)


if __name__ == "__main__":
    unittest.main()
