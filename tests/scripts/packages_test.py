# SPDX-License-Identifier: Apache-2.0
"""docs/packages.md: it names every file that includes a package, and where the package runs follows from sources and configs."""

import re
import tomllib
import unittest

from fake_site import CHECKOUT  # finds the scripts, so first

import describe_packages
from folder_case import FolderTest
from nightmap_site.script_errors import DataError

PAGE = (CHECKOUT / "docs/packages.md").read_text(encoding="utf-8")


class PageTest(unittest.TestCase):
    def test_it_names_every_file_that_includes_a_package_and_no_other(self):
        self.assertEqual(set(describe_packages.files_of_page(PAGE)), describe_packages.users_of(CHECKOUT))

    def test_its_table_of_stages_is_that_of_sources_and_configs(self):
        table = PAGE.split(describe_packages.BEGIN)[1].split(describe_packages.END)[0]
        self.assertEqual(table.strip(), describe_packages.describe(CHECKOUT, PAGE).strip(), "run scripts/describe_packages.py --write")

    def test_options_that_bring_a_package_in_are_not_the_defaults(self):
        options = set(re.findall(r'`(\w+)\.(\w+) = "(\w+)"`', "".join(describe_packages.files_of_page(PAGE).values())))
        self.assertGreaterEqual(len(options), 4)
        for stage, option, value in options:
            with self.subTest(f"{stage}.{option}"):
                (defaults,) = CHECKOUT.glob(f"configs/*/default/{stage}.toml")
                self.assertNotEqual(tomllib.loads(defaults.read_text(encoding="utf-8"))[option], value)

    def test_one_script_runs_colmap(self):
        command = re.compile(r'\["colmap", [\w"]')
        users = [path.name for path in CHECKOUT.glob("scripts/**/*.py") if command.search(path.read_text(encoding="utf-8"))]
        self.assertEqual(users, ["colmap_run.py"])
        self.assertFalse(any("colmap" in name for name in describe_packages.programs_of(CHECKOUT)))


class MadeUpCheckoutTest(FolderTest):
    """A pipeline of two jobs: `wash` reads the recordings, `cook` what `wash` wrote; the profile `raw` leaves `cook` out."""

    PAGE = """\
| PCL | `stages/food/cook/heat.cc` | heats | |
| OctoMap | `pipeline/dense/cut.cc` | cuts | `cook.knife = "long"` |
| OpenImageIO | `pipeline/media/see.cc` | sees | |
| OpenCV | `pipeline/io/look.cc` | looks | never: it has no eyes |
"""
    FILES = {
        "configs/pipeline.toml": '[goals]\nmap = { purpose = "p", made = "m" }\n[wash]\npurpose = "p"\nin.data = "data"\nout.a = "a"\n'
                                 '[cook]\npurpose = "p"\nin.a = "wash.a"\nout.b = "b"\n',
        "configs/raw/pipeline.toml": "[cook]\nleave_out = true\n",
        "stages/food/wash/main.cc": '#include "pipeline/io/look.h"\n', "stages/food/cook/main.cc": '#include "pipeline/dense/cut.h"\n',
        "stages/food/cook/heat.cc": "#include <pcl/heat.h>\n", "pipeline/dense/cut.h": '#include "pipeline/io/look.h"\n',
        "pipeline/dense/cut.cc": "#include <octomap/cut.h>\n", "pipeline/io/look.h": "",
        "pipeline/io/look.cc": "#include <opencv2/core.hpp>\n",
        "pipeline/media/see.cc": "#include <OpenImageIO/see.h>\n",
    }  # fmt: skip

    def setUp(self):
        for name, text in self.FILES.items():
            self.write(name, text)

    def rows(self, page):
        return describe_packages.describe(self.folder, page).splitlines()[2:]

    def test_stages_are_those_that_reach_a_file_and_profiles_those_that_run_them(self):
        self.assertEqual(set(describe_packages.files_of_page(self.PAGE)), describe_packages.users_of(self.folder))
        self.assertEqual(self.rows(self.PAGE), [
            "| PCL | `cook` | default | - |  |",
            '| OctoMap | `cook` | default | - | `cook.knife = "long"` |',
            "| OpenImageIO | `wash` | default, raw | - |  |",
        ])  # fmt: skip

    def test_pixels_count_where_recordings_are_read(self):
        self.assertEqual(self.rows("| OpenCV | `pipeline/io/look.cc` | looks | |\n"), ["| OpenCV | `wash` | default, raw | - |  |"])

    def test_a_page_without_files_is_refused(self):
        with self.assertRaises(DataError):
            self.rows("text")
