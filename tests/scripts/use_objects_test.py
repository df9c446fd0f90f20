# SPDX-License-Identifier: Apache-2.0
"""A file of objects becomes the one that a site's config names; what is wrong is refused before anything is written."""

import os

import fake_site
from folder_case import FolderTest

TEXT = ('format: nightmap objects\nversion: 1\nobjects:\n  - name: "column"\n    x_m: 1.000\n    y_m: -0.500\n    size_x_m: 1.000\n'
        "    size_y_m: 0.600\n    angle_deg: 0.000\n")  # fmt: skip
LASER = 'profile = "laser"\n'
NAMED = LASER + '[import]\nobjects = "own.yaml"\n'


class UseObjectsTest(FolderTest):
    def setUp(self):
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(fake_site.CHECKOUT)  # as make does
        self.data = self.folder / "data"
        self.data.mkdir()
        self.site = self.folder / "hall.toml"

    def run_it(self, config, text=TEXT, *arguments):
        drawn = self.write("drawn.yaml", text)
        if config is not None:
            self.site.write_text(config)
        return fake_site.run("use_objects.py", "--site", self.site, "--data", self.data, *arguments, drawn)

    def check_refused(self, code, said, config, text=TEXT, *arguments):
        result = self.run_it(config, text, *arguments)
        self.assertEqual((result.returncode, said in result.stderr), (code, True), result.stderr)
        self.assertEqual(sorted(path.name for path in self.folder.rglob("*.yaml*")), ["drawn.yaml"])
        self.assertEqual(self.site.read_text() if config is not None else None, config)

    def test_the_file_that_was_there_is_kept(self):
        own = self.data / "own.yaml"
        own.write_text("by hand\n")
        for _ in range(2):  # the same file again replaces nothing
            self.assertEqual(self.run_it(NAMED).returncode, 0)
            self.assertEqual((own.read_text(), (self.data / "own.yaml.old").read_text()), (TEXT, "by hand\n"))

    def test_a_wrong_config_is_a_usage_error(self):
        self.check_refused(2, "there is no such file", None)
        self.check_refused(2, "not valid TOML", "[import\n")
        self.check_refused(2, "by hand", LASER + "import = { wheels = \"a\" }\n")

    def test_a_name_outside_of_the_data_is_refused(self):
        for name in ("../own.yaml", str(self.folder / "own.yaml")):
            self.check_refused(2, "leads out of DATA", NAMED.replace("own.yaml", name))
        self.check_refused(2, "Make reads this path", NAMED.replace("own.yaml", "o$n.yaml"))

    def test_a_profile_that_takes_no_objects_is_refused_with_those_that_do(self):
        for config in ("", NAMED.replace("laser", "wheels")):
            self.check_refused(2, 'profile = "laser"', config)
        self.check_refused(2, "takes no objects", LASER, TEXT, "--profile", "wheels")
        self.assertEqual(self.run_it("", TEXT, "--profile", "laser").returncode, 0)

    def test_a_file_that_is_cut_off_or_no_file_of_objects_is_refused(self):
        head = TEXT[: TEXT.index("  - name")]
        for length in range(len(TEXT)):
            self.check_refused(1, "download it again", NAMED, TEXT[:length])
        for text, said in (("\t", "download it"), ("[" * 5000, "download it"), (head.replace("1", "2"), "version"), (head + "  - x\n", "object 1"),
                           (TEXT.replace("1.000", ".nan"), "download it"), (TEXT.replace("nightmap ", ""), "format")):  # fmt: skip
            self.check_refused(1, said, NAMED, text)
        self.assertEqual(self.run_it(NAMED, "format: nightmap objects\nversion: 1\nobjects: []\n").returncode, 0)
