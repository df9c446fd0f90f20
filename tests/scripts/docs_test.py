# SPDX-License-Identifier: Apache-2.0
"""The documentation: its examples parse, its links lead somewhere, its tables name what exists."""

import re
import subprocess
import tomllib
import unittest

from fake_site import CHECKOUT  # finds the scripts, so first

import describe_pipeline
from nightmap_site.declaration import profiles
from nightmap_site.pipeline import read_pipeline

DOCS = sorted(str(page.relative_to(CHECKOUT)) for page in (CHECKOUT / "docs").rglob("*.md"))
PAGES = ["README.md", "ARCHITECTURE.md", "datasets.md", *DOCS]
FOLDERS = r"\.ci|cmake|configs|docs|pipeline|scripts|stages|tests"
SITE_KEYS = {"root", "hold_out_every", "camera", "sequence", "query", "sensor", "signal", "robot_truth", "profile", "synthetic", "import"}


def text_of(name):
    return (CHECKOUT / name).read_text(encoding="utf-8")


def anchors_of(text):
    """Anchors of the headings outside of blocks of code, as GitHub makes them."""
    text = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


class ListSearch:
    """Finds lists of jobs: so many names in a line, or in lines that follow each other and of which each has a name in
    quotes or nothing but names; in a page, items of a list or a table that begin with one. Parts of pages that programs
    write are none, nor are comments of code and words of a page that are in no quotes."""

    SO_MANY = 6
    WRITTEN = re.compile(r"<!-- (\w+):begin -->.*?<!-- \1:end -->", re.DOTALL)

    def __init__(self, jobs):
        name = "|".join(jobs)
        self._word = re.compile(rf"(?<![\w./-])(?:{name})(?![\w/-]|\.\w)")
        self._quoted = re.compile(rf"(?<=[\"'`])(?:{name})(?=[\"'`])")
        self._item = re.compile(rf"^\s*(?:[-*|]|\d+\.)\s*`?({name})(?![\w/.])")  # of a page
        self._only_names = re.compile(rf"(?:(?:{name})|\W)+")

    def lists_in(self, path, text):
        """(line, names) of each."""
        text = self.WRITTEN.sub(lambda found: re.sub(r"[^\n]", "", found[0]), text)
        together, is_page, in_block = set(), path.endswith(".md"), False
        for number, line in enumerate(text.splitlines(), 1):
            code = line if is_page else re.split(r"##|# |// ", line)[0]
            in_block ^= is_page and line.startswith("```")
            words = set((self._quoted if is_page and not in_block else self._word).findall(code))
            beside_text = self._item if is_page else self._quoted
            names = words if self._only_names.fullmatch(code) else set(beside_text.findall(code))
            together = together | names if names else set()
            if max(len(words), len(together)) >= self.SO_MANY:
                yield number, words | together


class DocsTest(unittest.TestCase):
    def test_site_configs_parse_and_hold_together(self):
        blocks = re.findall(r"```toml\n(.*?)```", text_of("datasets.md") + text_of("docs/first_hour.md"), re.DOTALL)
        self.assertGreaterEqual(len(blocks), 6)
        for block in blocks:
            site = tomllib.loads(block)
            with self.subTest(site.get("root")):
                self.assertLessEqual(set(site), SITE_KEYS)
                cameras = {camera["id"] for camera in site.get("camera", [])}
                for recording in site.get("sequence", []):
                    self.assertIn(recording["camera"], cameras)

    def test_keys_of_examples_are_known_to_the_parser(self):
        parser = "".join(text_of(f"pipeline/recording/site_{name}") for name in ("config.h", "config.cc", "tables.cc"))
        known = set(re.findall(r'(?:OPTION_AT|table\.get)\("(\w+)"|OPTION\([^,]+, (\w+),', parser))
        known = {name for names in known for name in names}
        for block in re.findall(r"```toml\n(.*?)```", text_of("datasets.md") + text_of("docs/first_hour.md"), re.DOTALL):
            for tables in tomllib.loads(block).values():
                for table in tables if isinstance(tables, list) else []:
                    self.assertLessEqual(set(table), known)

    def test_links_lead_somewhere(self):
        num_links = 0
        for page in PAGES:
            for link in re.findall(r"\]\(([^)]+)\)", text_of(page)):
                if link.startswith("http"):
                    continue
                num_links += 1
                with self.subTest(f"{page}: {link}"):
                    name, _, anchor = link.partition("#")
                    target = ((CHECKOUT / page).parent / name).resolve() if name else CHECKOUT / page
                    self.assertTrue(target.exists(), "no such file")
                    if anchor:
                        self.assertIn(anchor, anchors_of(target.read_text(encoding="utf-8")))
        self.assertGreater(num_links, 50)

    def test_every_page_is_in_the_index(self):
        index = text_of("docs/README.md")
        for page in set(DOCS) - {"docs/README.md"}:
            self.assertIn(f"]({page.removeprefix('docs/')})", index)

    def test_front_pages_are_short(self):
        self.assertLessEqual(len(text_of("README.md").splitlines()), 150)
        self.assertLessEqual(len(text_of("ARCHITECTURE.md").splitlines()), 250)

    def test_figures_stand_on_one_page(self):
        """Scripts put tables between markers; a second place would be forgotten. Three belong to a page's own text."""
        elsewhere = {"docs/pipeline.md": ["pipeline"], "docs/packages.md": ["packages"], "docs/options.md": ["options"]}
        for page in sorted(set(PAGES) - {"docs/figures.md"}):
            markers = re.findall(r"<!-- (.+?):begin -->", text_of(page))
            self.assertEqual(markers, elsewhere.get(page, []), page)

    def test_versions_of_formats_are_those_of_the_code(self):
        line = text_of("docs/formats.md").split("\nVersions: ")[1].split(". ")[0]
        code = "".join(path.read_text(encoding="utf-8") for path in (CHECKOUT / "pipeline").rglob("*.cc"))
        declared = re.findall(r"constexpr int k(\w+)Version = (\d+);", code)
        self.assertEqual(line.split(", "), sorted(f"{name} {version}" for name, version in declared))

    def test_the_table_of_the_pipeline_is_the_declaration(self):
        page = text_of("docs/pipeline.md").split(describe_pipeline.BEGIN)[1].split(describe_pipeline.END)[0]
        self.assertEqual(page.strip(), describe_pipeline.describe(str(CHECKOUT / "configs")).strip())

    def test_every_stage_is_described(self):
        for stage in (path.parent.name for path in CHECKOUT.glob("stages/*/*/main.cc")):
            self.assertIn(f"`{stage}`", text_of("ARCHITECTURE.md") + text_of("docs/pipeline.md"))

    def test_no_second_list_of_stages(self):
        """Only the declaration lists the jobs. (The goals of make, of which some have a job's name, are five.)"""
        listed = subprocess.run(["git", "ls-files"], cwd=CHECKOUT, capture_output=True, text=True)
        if listed.returncode != 0:
            self.skipTest("not a checkout of git")
        search = ListSearch(read_pipeline(str(CHECKOUT / "configs")).jobs)
        for name in set(listed.stdout.split()) - {str(path.relative_to(CHECKOUT)) for path in CHECKOUT.glob("configs/*/pipeline.toml")}:
            if not name.endswith((".png", ".jpg", ".gif")):
                for number, jobs in search.lists_in(name, text_of(name)):
                    self.fail(f"{name}:{number} lists the jobs {', '.join(sorted(jobs))}: derive them from configs/pipeline.toml")

    def test_the_search_finds_lists(self):
        names = ["wash", "peel", "chop", "boil", "season", "serve"]
        search = ListSearch(names)
        quoted = [f'"{name}"' for name in names]
        for text in (", ".join(quoted), " ".join(names), "STAGES = (\n" + ",\n".join(quoted) + ",\n)",
                     "STAGES := \\\n" + " \\\n".join(names), "\n".join(f"AFTER = AFTER | {{{word}}}" for word in quoted)):  # fmt: skip
            self.assertTrue(list(search.lists_in("x.py", text)), text)
            self.assertFalse(list(search.lists_in("x.md", f"<!-- x:begin -->\n{text}\n<!-- x:end -->\n")), text)
        self.assertTrue(list(search.lists_in("x.md", "```\n" + " -> ".join(names) + "\n```")))
        self.assertFalse(list(search.lists_in("x.md", "Words: " + ", ".join(names))))
        for text in (", ".join(quoted[:5]), "\n\n".join(quoted), "\n".join(f"read {name} now" for name in names),
                     "# " + " ".join(names), "a.wash b/peel chop_x boil.txt season/map.yaml serve"):
            self.assertFalse(list(search.lists_in("x.py", text)), text)

    def test_paths_that_are_named_exist(self):
        """In all pages, also within commands. <...>, {...} and * stand for something: the folder before them is looked for."""
        path = re.compile(rf"(?<![\w./<>-])((?:{FOLDERS})/[\w./-]*\w)(?![\w<{{*])")
        for page in PAGES:
            text = re.sub(r"\]\([^)]+\)", "]", text_of(page))
            quoted = " ".join(re.findall(r"```.*?```|`[^`\n]+`", text, re.DOTALL))
            for name in sorted(set(path.findall(quoted))):
                with self.subTest(f"{page}: {name}"):
                    self.assertTrue((CHECKOUT / name).exists(), "no such file")

    def test_headers_of_the_layers_exist(self):
        layers = re.findall(r"^\| `(pipeline/\w+)` \| (.*) \|$", text_of("ARCHITECTURE.md"), re.MULTILINE)
        folders = {str(path.parent.relative_to(CHECKOUT)) for path in CHECKOUT.glob("pipeline/*/*.h")}
        self.assertEqual({folder for folder, _ in layers}, folders)
        for folder, text in layers:
            for name in re.findall(r"`(\w+\.h)`", text):
                self.assertTrue((CHECKOUT / folder / name).exists(), f"{folder}/{name}")

    def test_every_artifact_is_described(self):
        named = set()  # formats.md has `folder/name`, then other names of the folder, and `.suffix` of the name before
        for row in re.findall(r"^\| (`[^|]*) \|", text_of("docs/formats.md"), re.MULTILINE):
            folder = stem = ""
            for name in re.findall(r"`([^`]+)`", row):
                folder, _, name = name.partition("/") if "/" in name else (folder, "", name)
                named.add(f"{folder}/{stem if name.startswith('.') else ''}{name}")
                stem = stem if name.startswith(".") else name.rpartition(".")[0]
        configs = str(CHECKOUT / "configs")
        for profile, job in {(profile, job) for profile in profiles(configs) for imports in describe_pipeline.variants(configs, profile)
                             for job in read_pipeline(configs, profile, imports).jobs.values()}:  # fmt: skip
            for file in [*job.outputs.values(), *job.beside.values()] if not job.script and job.folder != "RECORDING" else []:
                names = {f"{job.folder}/{file.format(unit=unit)}" for unit in ("NNNN", "X_Y", "floor_N")} | {f"{job.folder}/{file.partition('/')[0]}/"}
                self.assertTrue(names & named, f"{profile}: docs/formats.md does not describe {sorted(names)[0]}")

    def test_pictures_are_small(self):
        for picture in (CHECKOUT / "docs").glob("*.png"):
            self.assertLess(picture.stat().st_size, 300 * 1024, picture.name)

    def test_nothing_is_left_over_at_the_top(self):
        listing = subprocess.run(["git", "ls-files"], cwd=CHECKOUT, capture_output=True, text=True)
        if listing.returncode != 0:
            self.skipTest("not a git checkout")
        top = {name for name in listing.stdout.splitlines() if "/" not in name}
        self.assertEqual(top, {".clang-format", ".clang-tidy", ".gitignore", "ARCHITECTURE.md", "CMakeLists.txt",
                               "LICENSE", "Makefile", "README.md", "datasets.md"})  # fmt: skip

    def test_packages_are_for_what_uses_them(self):
        """A package that only tests include says so, and one that says so is included by tests alone."""
        claims = dict(re.findall(r"(?m)^  (lib[\w-]+-dev)(?: [\w-]+)* +# (.*)$", text_of("scripts/install_deps.sh")))
        headers = {"libpcl-dev": "pcl/", "libopencv-dev": "opencv2/", "libembree-dev": "embree3/", "libgif-dev": "gif_lib.h",
                   "liboctomap-dev": "octomap/", "libceres-dev": "ceres/", "libnanoflann-dev": "nanoflann.hpp"}  # fmt: skip
        for package, header in headers.items():
            with self.subTest(package):
                users = {path.relative_to(CHECKOUT).parts[0] for folder in ("pipeline", "stages", "tests")
                         for path in (CHECKOUT / folder).rglob("*") if path.suffix in (".cc", ".h")
                         and f"#include <{header}" in path.read_text(encoding="utf-8")}  # fmt: skip
                self.assertEqual(claims[package].startswith("tests"), users == {"tests"}, users)
                self.assertTrue(users)
