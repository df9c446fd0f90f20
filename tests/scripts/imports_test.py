# SPDX-License-Identifier: Apache-2.0
"""nightmap_make.imports: the file that an imported file names, which make watches too."""

import tempfile
import unittest
from pathlib import Path

import fake_site  # noqa: F401  (finds the scripts)
from nightmap_make.imports import files_of


class ImportsTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def named(self, text, name="map.yaml"):
        """The file that one of this text names, or None."""
        path = self.folder / name
        path.write_bytes(text.encode(errors="surrogateescape"))
        files = files_of(str(path))
        self.assertEqual(files[0], str(path))
        return str(Path(files[1]).relative_to(self.folder)) if len(files) > 1 else None

    def test_the_picture_of_a_map_in_all_spellings_of_yaml(self):
        for text in ("image: a.pgm  # beside\nnegate: 0\n", "%YAML 1.1\n---\nnegate: false\n'image': \"a.pgm\"\n...\n",
                     "{resolution: 0.05, image: a.pgm}", "\ufeffimage: a.pgm\r\nnegate: 0\r\n", "image:\n  a.pgm\n", "image: !!str a.pgm",
                     "a: &a [*a]\nimage: a.pgm\n"):  # fmt: skip
            self.assertEqual(self.named(text), "a.pgm", text)
        self.assertEqual(self.named("image: a.pgm\n", "map.yml"), "a.pgm")

    def test_what_names_no_picture_names_none(self):
        for text in ("", "negate: 0\n", "# image: a.pgm\n", "map:\n  image: a.pgm\n", "image: [a.pgm]\n", "image:\n", "- image\n", "image: 'a",
                     "image: *a\n", 'image: "a\\0b"\n', "image: \udcff.pgm\n", "image: " + 50_000 * "[", 10_000 * "[{image: "):  # fmt: skip
            self.assertIsNone(self.named(text), text[:40])

    def test_the_network_of_a_model(self):
        self.assertEqual(self.named('network = "a.onnx"\n', "model.toml"), "a.onnx")
        self.assertIsNone(self.named("", "model.toml"))
        self.assertIsNone(self.named("image: a.pgm\n", "poses.tum"))
        self.assertEqual(files_of(str(self.folder / "none.yaml")), [str(self.folder / "none.yaml")])


if __name__ == "__main__":
    unittest.main()
