# SPDX-License-Identifier: Apache-2.0
"""nightmap_make.imports: the keys of [import] that a site may have, and the file that an imported file names."""

import contextlib
import unittest
from pathlib import Path

from folder_case import FolderTest
from nightmap_make.imports import check_import_keys, files_of
from nightmap_site.declaration import import_keys
from nightmap_site.toml_file import PipelineError

REPOSITORY = Path(__file__).resolve().parents[2]


class ImportKeysTest(unittest.TestCase):
    def check(self, key, profile, is_asked=False):
        with contextlib.chdir(REPOSITORY):
            check_import_keys("s.toml", {key: "a"}, profile, is_asked)

    def test_a_profile_takes_the_files_that_its_jobs_read(self):
        self.assertEqual(import_keys(str(REPOSITORY / "configs"), "default"), set())
        for key in ("trajectory", "objects", "map"):
            self.check(key, "laser")
        self.check("map", "imported")

    def test_a_key_of_another_profile_may_stay_where_make_names_the_profile(self):
        self.check("map", "default", is_asked=True)
        with self.assertRaisesRegex(PipelineError, r"s.toml: \[import\] map: the profile 'default' takes no map: .*\"imported\" or .*\"laser\""):
            self.check("map", "default")

    def test_a_key_of_no_profile_is_refused_with_the_nearest(self):
        for is_asked in (False, True):
            with self.assertRaisesRegex(PipelineError, "no such key: write trajectory"):
                self.check("trajectry", "laser", is_asked)
            with self.assertRaisesRegex(PipelineError, "the keys are map, objects, trajectory"):
                self.check("xyz", "laser", is_asked)


class ImportsTest(FolderTest):
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
