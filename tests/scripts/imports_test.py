# SPDX-License-Identifier: Apache-2.0
"""The keys of [import] that a site may have."""

import contextlib
import unittest
from pathlib import Path

from nightmap_make.imports import check_import_keys
from nightmap_site.declaration import PipelineError, import_keys

REPOSITORY = Path(__file__).resolve().parents[2]


class ImportKeysTest(unittest.TestCase):
    def check(self, key, profile, is_asked=False):
        with contextlib.chdir(REPOSITORY):
            check_import_keys("s.toml", {key: "a"}, profile, is_asked)

    def test_a_profile_takes_the_files_that_its_jobs_read(self):
        self.assertEqual(import_keys(str(REPOSITORY / "configs"), "default"), set())
        for key in ("trajectory", "objects"):
            self.check(key, "laser")
        self.check("map", "imported")

    def test_a_key_of_another_profile_may_stay_where_make_names_the_profile(self):
        self.check("map", "laser", is_asked=True)
        for profile in ("laser", "default"):
            with self.assertRaisesRegex(PipelineError, rf"s.toml: \[import\] map: the profile '{profile}' takes no map: .*\"imported\""):
                self.check("map", profile)

    def test_a_key_of_no_profile_is_refused_with_the_nearest(self):
        for is_asked in (False, True):
            with self.assertRaisesRegex(PipelineError, "no such key: write trajectory"):
                self.check("trajectry", "laser", is_asked)
            with self.assertRaisesRegex(PipelineError, "the keys are objects, trajectory"):
                self.check("xyz", "laser", is_asked)


if __name__ == "__main__":
    unittest.main()
