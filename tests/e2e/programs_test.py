# SPDX-License-Identifier: Apache-2.0
"""Every program's answers without inputs; configs/*/default are what the programs say."""
import os
import pathlib
import re
import subprocess
import tempfile
import tomllib
import unittest

from nightly import nightly
from out_of_range import NO_CHOICE, options, said_of
from nightmap_site.pipeline import read_pipeline
from workspace import BUILD, PIPELINE, REPOSITORY

# Program -> its default config, those of profiles included.
DEFAULTS = {path.stem: path for path in REPOSITORY.glob("configs/*/default/*.toml")}
# Name of a config -> the program that takes it, where a job has `options` of its own.
PROGRAM_OF = {name: program for path in REPOSITORY.glob("configs/*/pipeline.toml")
              for name, program in read_pipeline(str(REPOSITORY / "configs"), path.parent.name).options.items()}  # fmt: skip
NUM_KEYS = 2  # of each stage tried with a wrong value; tests/base tries every kind of option


def run(stage, *arguments):
    return subprocess.run([BUILD / "bin" / stage, *map(str, arguments)], capture_output=True, text=True)


class ProgramsTest(unittest.TestCase):
    def check_each(self, check):
        for stage in DEFAULTS:
            if PROGRAM_OF.get(stage, stage) == stage:
                with self.subTest(stage):
                    check(stage)

    def check_config(self, stage, text):
        with tempfile.NamedTemporaryFile("w", suffix=".toml") as file:
            file.write(text)
            file.flush()
            return run(stage, "--check-config", "--config", file.name)

    def test_recorded_sites_need_no_library_of_made_up_ones(self):
        stages = {path.parent.name for path in REPOSITORY.glob("stages/*/*/main.cc")}
        recorded = sorted(stage for stage in stages if not stage.startswith("synthesize"))
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run(["cmake", "-S", REPOSITORY, "-B", folder, "-G", "Ninja", f"-DNIGHTMAP_PROGRAMS={' '.join(recorded)}",
                            "--log-level=ERROR"], check=True, stdout=subprocess.DEVNULL)  # fmt: skip
            rules = pathlib.Path(folder, "build.ninja").read_text()
        self.assertIn("build bin/pose_graph", rules)
        self.assertNotRegex(rules, "-lnightmap_|embree")

    def test_help_and_version(self):
        def check(stage):
            help_page = run(stage, "--help")
            self.assertEqual(help_page.returncode, 0)
            self.assertIn("inputs:", help_page.stdout)
            version = run(stage, "--version")
            self.assertEqual((version.returncode, version.stdout.split()[0]), (0, stage))

        self.check_each(check)

    def test_no_program_loads_the_libraries_of_rare_formats(self):
        """They take half a second of every start: a module brings them when they are needed."""
        def libraries(path):
            return subprocess.run(["readelf", "-d", path], capture_output=True, text=True, check=True).stdout

        rare = ("OpenImageIO", "opencv_videoio", "opencv_imgcodecs")
        self.assertIn(rare[0], libraries(BUILD / "bin/nightmap_media.so"))
        self.check_each(lambda stage: self.assertFalse([name for name in rare if name in libraries(BUILD / "bin" / stage)]))

    def test_default_config_is_what_the_program_prints(self):
        """With the meaning of each option as a comment, so that who edits a copy need not look it up."""
        for name in DEFAULTS:
            program = PROGRAM_OF.get(name, name)
            with self.subTest(name):
                default = DEFAULTS[name].read_text(encoding="utf-8")
                printed = run(program, "--print-config", "--config", DEFAULTS[name])
                self.assertEqual(printed.returncode, 0, printed.stderr)
                self.assertTrue(default.endswith(printed.stdout), "write it anew: --print-config --config")
                self.assertEqual(printed.stdout.count("\n\n#") + printed.stdout.startswith("\n#"), len(tomllib.loads(default)))
                self.assertEqual(run(program, "--check-config", "--config", DEFAULTS[name]).returncode, 0)

    def test_site_configs_of_the_pages_are_accepted(self):
        pages = ("datasets.md", "docs/first_hour.md")
        blocks = [block for page in pages for block in re.findall(r"```toml\n(root .*?)```", (REPOSITORY / page).read_text(), re.DOTALL)]
        self.assertGreater(len(blocks), 6)
        for block in blocks:
            with tempfile.NamedTemporaryFile("w", suffix=".toml") as site:
                site.write(block)
                site.flush()
                checked = run("frames", "--check-config", "--config", DEFAULTS["frames"], "--in", f"site={site.name}")
                self.assertEqual(checked.returncode, 0, block + checked.stderr)

    def test_options_of_a_program_are_its_defaults(self):
        def check(stage):
            printed = run(stage, "--print-config").stdout
            self.assertEqual(tomllib.loads(DEFAULTS[stage].read_text(encoding="utf-8")), tomllib.loads(printed))
            self.assertEqual(self.check_config(stage, printed).returncode, 0)

        self.check_each(check)

    def test_config_mistakes_exit_with_2_and_name_the_line(self):
        def check(stage):
            unknown = self.check_config(stage, "\nno_such_key = 1\n")
            self.assertEqual(unknown.returncode, 2)
            self.assertRegex(unknown.stderr, r"toml:2: unknown key 'no_such_key'")
            config = tomllib.loads(run(stage, "--print-config").stdout)
            numbers = [key for key, value in config.items() if type(value) in (int, float)]
            for key in numbers[:NUM_KEYS]:
                low = "-1e30" if isinstance(config[key], float) else "-2000000000"
                for value in (low, "1979-05-27"):
                    mistake = self.check_config(stage, f"{key} = {value}\n")
                    self.assertEqual(mistake.returncode, 2, (key, value))
                    self.assertIn(key, mistake.stderr)
            self.assertEqual(self.check_config(stage, "not toml").returncode, 2)

        self.check_each(check)

    def check_value(self, stage, printed, name, wrong):
        """Shows the program its own config with another value of one option; it says so and writes nothing."""
        lines = printed.splitlines()
        [row] = [row for row, line in enumerate(lines) if line.startswith(f"{name} = ")]
        lines[row] = f"{name} = " + (f'"{wrong}"' if wrong == NO_CHOICE else wrong)
        with tempfile.TemporaryDirectory() as folder:
            config = pathlib.Path(folder) / "wrong.toml"
            config.write_text("\n".join(lines))
            result = subprocess.run([BUILD / "run" / stage, "--check-config", "--config", config], cwd=folder,
                                    capture_output=True, text=True)  # fmt: skip
            self.assertEqual(os.listdir(folder), [config.name])
        self.assertEqual(result.returncode, 2, result.stderr)
        for text in (f"{config}:{row + 1}: {name}", *said_of(wrong)):
            self.assertIn(text, result.stderr)

    @nightly  # half a thousand starts of programs; preflight_test asks one value of each
    def test_every_option_out_of_range(self):
        num_checked = 0
        for stage in PIPELINE.programs():
            printed = run(stage, "--print-config").stdout
            for name, wrong in options(stage):
                with self.subTest(f"{stage}.{name}={wrong}"):
                    self.check_value(stage, printed, name, wrong)
                    num_checked += 1
        self.assertGreater(num_checked, 240)

    def test_command_line_mistakes_exit_with_2(self):
        def check(stage):
            for arguments in (["--no-such-flag"], ["--out", "report"], ["--config", "/nonexistent.toml"], []):
                self.assertEqual(run(stage, *arguments).returncode, 2, arguments)

        self.check_each(check)
