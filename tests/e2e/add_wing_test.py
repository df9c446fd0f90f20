# SPDX-License-Identifier: Apache-2.0
"""Adding a wing takes its own folders. A copy of the tree gets those of tests/e2e/census, a stage with its options, a job, a profile,
sections of evaluation and report, and a page, and no other file changes. Then everything that goes through the stages knows it."""
import json
import pathlib
import shutil
import subprocess
import tempfile

from workspace import BUILD, REPOSITORY, SITE, SiteTest, Workspace, environment, said_by, write_small_site

CENSUS = REPOSITORY / "tests/e2e/census"


def copy_of_the_tree():
    """All that git has of the tree, in a folder of its own. (The compiler's cache knows all but the new stage.)"""
    folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-e2e-"))
    listed = subprocess.run(["git", "ls-files", "-z"], cwd=REPOSITORY, check=True, capture_output=True, text=True)
    for name in filter(None, listed.stdout.split("\0")):
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(REPOSITORY / name, folder / name)
    return folder


def add_census(folder):
    """All that adding a wing takes: files that were not there."""
    for path in filter(pathlib.Path.is_file, CENSUS.rglob("*")):
        added = folder / path.relative_to(CENSUS)
        if added.exists():
            raise AssertionError(f"{added} is a file of the tree")
        added.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(path, added)


def programs_but(folder, *stages):
    """Programs of the same sources, as the copy would build them."""
    for name in ("bin", "run"):
        shutil.copytree(BUILD / name, folder / "build" / name, dirs_exist_ok=True, ignore=shutil.ignore_patterns(*stages))


def build_stage(folder, *stages):
    """Builds the programs of the new or changed stages, and these alone."""
    subprocess.run(["make", "build/programs.mk"], cwd=folder, env=environment() | {"NIGHTMAP_PROGRAMS": " ".join(stages)}, check=True,
                   stdout=subprocess.DEVNULL)  # fmt: skip
    programs_but(folder, *stages)


def map_before(folder):
    """The map as it was before the stage came."""
    made = Workspace.made("map")
    for name in ("data", "maps"):
        shutil.copytree(made.folder / name, folder / name)
    made.remove()
    build_stage(folder, "census")


class AddWingTest(SiteTest):
    @classmethod
    def setUpClass(cls):
        cls.folder = copy_of_the_tree()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        add_census(cls.folder)
        write_small_site(cls.folder)
        config = cls.folder / f"configs/sites/{SITE}.toml"
        config.write_text(f'profile = "census"\n{config.read_text()}')
        cls.work = Workspace(cls.folder)
        map_before(cls.folder)
        cls.output = cls.work.output("map", "evaluate", "report")

    def describe_pipeline(self, *arguments):
        command = ["/usr/bin/python3", "scripts/describe_pipeline.py", *arguments]
        return subprocess.run(command, cwd=self.folder, check=True, capture_output=True, text=True).stdout

    def test_it_runs_with_the_map_and_is_in_its_table(self):
        census, frames = (json.loads(self.work.path(name).read_text()) for name in ("census/census.json", "frames/report.json"))
        self.assertEqual(census["num_frames"], frames["num_frames"])
        self.assertRegex(self.output, rf"(?m)^census .* {census['num_frames']} frames, {census['num_keyframes']} keyframes$")

    def test_the_page_shows_it(self):
        page = self.work.path("report/index.html").read_text(encoding="utf-8")
        self.assertIn("<td>census</td>", page)
        self.assertIn("<summary>census</summary>", page)
        census = json.loads(self.work.path("census/census.json").read_text())
        self.assertIn(f"{census['num_keyframes']} keyframes of {census['num_frames']} frames", page)

    def test_the_evaluation_has_its_figure(self):
        census = json.loads(self.work.path("census/census.json").read_text())
        metrics = json.loads(self.work.path("evaluate/metrics.json").read_text())
        self.assertAlmostEqual(metrics["sections"]["census"]["keyframe_share"], census["num_keyframes"] / census["num_frames"], 8)

    def test_why_names_it_and_a_value_reruns_it_alone(self):
        change = "SET=census.min_keyframes=2"
        self.assertIn("census: options of census changed: min_keyframes 1 -> 2", self.make("why", change))
        before = self.work.runs()
        self.make("map", change)
        after = self.work.runs()
        self.assertEqual({job for job in after if after[job] != before.get(job)}, {"census"})

    def test_its_values_are_checked_before_a_run(self):
        self.assertIn("min_keyframes", self.make("map", "SET=census.min_keyframes=0", code=2))

    def test_verify_hashes_its_artifact(self):
        path = self.work.path("census/census.json")
        kept = shutil.copy2(path, self.folder / "kept.json")
        self.addCleanup(shutil.move, kept, path)  # with its time
        path.write_text("{}")
        self.assertIn("census/census.json: altered", self.make("verify", code=2))

    def test_lint_checks_its_sources(self):
        self.assertIn("clang-tidy stages/census/census", self.make("-n", "lint"))

    def test_the_docs_describe_it(self):
        row = "| `census` | `default`, `census` |"
        self.assertIn(row, self.describe_pipeline())
        self.describe_pipeline("--write")
        self.assertIn(row, (self.folder / "docs/pipeline.md").read_text(encoding="utf-8"))
        self.assertTrue((self.folder / "docs/methods/census.md").is_file())

    def test_a_test_of_all_programs_takes_it(self):
        test = ["-m", "unittest", "programs_test.ProgramsTest.test_default_config_is_what_the_program_prints"]
        said_by(["/usr/bin/python3", *test], self.folder / "tests/e2e", NIGHTMAP_BUILD=str(self.folder / "build"))
