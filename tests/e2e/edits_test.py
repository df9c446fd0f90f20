# SPDX-License-Identifier: Apache-2.0
"""Maps made again after edits equal maps made from nothing, byte for byte, in every profile; `make why` and `make -q` tell before
what runs. Edits are of options, of the site's config, of recordings, of imported files, and of what make itself wrote."""
import pathlib
import random
import re
import shutil
import sys
import tomllib
import unittest

from nightly import IS_NIGHT
from workspace import NO_ARTIFACTS, Workspace, told_by_why

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "fuzz"))

from attacked_sites import GOALS, make_sites  # noqa: E402
from nightmap_site.pipeline import read_pipeline  # noqa: E402

NUM_EDITS = 20 if IS_NIGHT else 2
EDITS_PER_CLEAN = 4 if IS_NIGHT else 2
NUMBER = re.compile(r"(?m)^(\w+ = )(-?\d+\.?\d*)( *(?:#.*)?)$")
LISTS = (".txt", ".csv", ".log", ".tum")


def changed_number(draw, text):
    """Another number, near enough that most are in range; -> None where there is none."""
    found = list(NUMBER.finditer(text))
    if not found:
        return None
    number = draw.choice(found)
    value = number[2]
    other = f"{float(value) * draw.choice((0.9, 0.97, 1.03, 1.1)):.6g}" if "." in value else str(int(value) + draw.choice((1, 2)))
    return text[: number.start(2)] + other + text[number.end(2) :], f"{number[1]}{value} -> {other}"


class Edits:
    """One edit of a site: -> what it was, and how to take it back."""

    def __init__(self, work, site, draw):
        self.work, self.site, self.draw = work, site, draw
        self.config = work.folder / f"configs/sites/{site}.toml"
        self.root = work.folder / "data" / re.search(r'(?m)^root = "(\w+)"', self.config.read_text())[1]

    def one(self):
        while True:
            edit = self.draw.choice((self.option, self.option, self.option, self.site_config, self.recording, self.recording, self.artifact))()
            if edit:
                return edit

    def write(self, path, content):
        """Puts content into a file, which other copies of the workspace do not share."""
        before = path.read_bytes() if path.exists() else None
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content)
        return lambda: path.write_bytes(before) if before is not None else path.unlink()

    def option(self):
        """In the site's file of a stage's options."""
        effective = self.draw.choice(sorted((self.work.folder / f"maps/{self.site}/config").glob("*.toml")))
        changed = changed_number(self.draw, effective.read_text())
        own = self.work.folder / f"configs/sites/{self.site}/{effective.name}"
        return changed and (f"{effective.stem}: {changed[1]}", self.write(own, changed[0].encode()))

    def site_config(self):
        changed = changed_number(self.draw, self.config.read_text())
        return changed and (f"site config: {changed[1]}", self.write(self.config, changed[0].encode()))

    def recording(self):
        """A line of a list or log that is gone, or a picture that is as another."""
        files = sorted(path for path in self.root.rglob("*") if path.is_file())
        lists = [path for path in files if path.suffix in LISTS]
        path = self.draw.choice(lists if lists and self.draw.random() < 0.6 else files)
        if path.suffix in LISTS:
            lines = path.read_bytes().split(b"\n")
            del lines[self.draw.randrange(len(lines) // 2, len(lines))]
            return f"a line of {path.name} less", self.write(path, b"\n".join(lines))
        if path.suffix not in (".png", ".jpg"):
            return None
        other = self.draw.choice([other for other in files if other.parent == path.parent])
        return f"{path.name} is {other.name}", self.write(path, other.read_bytes())

    def artifact(self):
        """One that is gone."""
        folder = self.work.folder / "maps" / self.site
        path = self.draw.choice([path for path in sorted(folder.glob("*/*")) if path.is_file() and path.parent.name not in ("config", "logs")])
        return f"{path.relative_to(folder)} is gone", (path.unlink(), lambda: None)[1]


class EditsTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace().removed_after(cls)
        for _ in make_sites(cls.work):
            pass

    def make(self, site, *arguments):
        return self.work.make(f"SITE={site}", *arguments)

    def ran(self, site):
        lines = [line.split() for line in (self.work.folder / f"maps/{site}/logs/journal.txt").read_text().splitlines()]
        return {words[1] for words in lines if words[2] == "begin" and words[1] != "make"}

    def others(self, site):
        """The jobs of other goals than the site's."""
        tables = tomllib.loads((self.work.folder / f"configs/sites/{site}.toml").read_text())
        pipeline = read_pipeline(str(self.work.folder / "configs"), tables.get("profile", "default"), tuple(tables.get("import", ())))
        listed = set() if "localize" in GOALS[site] else {"queries"}  # of goals, but no goal here needs it
        return listed | {job.name for job in pipeline.jobs.values() if job.goal not in ("map", *GOALS[site])}

    def artifacts(self, maps, site):
        root = self.work.folder / maps / site
        return {str(path.relative_to(root)): path.read_bytes() for path in sorted(root.glob("*/**/*"))
                if path.is_file() and not str(path.relative_to(root)).startswith(NO_ARTIFACTS) and "receipt" not in path.name
                and path.name != "hashes.csv"}  # fmt: skip

    def edit(self, edits, site):
        """Makes the site again after an edit, or as before where make refuses it; returns what was edited."""
        what, take_back = edits.one()
        told = self.make(site, "why", *GOALS[site]).stdout
        is_stale = self.make(site, "-q", *GOALS[site]).returncode
        made = self.make(site, *GOALS[site])
        if made.returncode != 0:
            self.assertIn(made.returncode, (1, 2), f"{what}\n{made.stdout}")
            take_back()
            again = self.make(site, *GOALS[site])
            self.assertEqual(again.returncode, 0, f"{what}, taken back\n{again.stdout}")
            return f"{what} (refused)"
        will, may = (rules - self.others(site) for rules in told_by_why(told))
        ran = self.ran(site) - self.others(site) if "\n== " in f"\n{made.stdout}" else set()
        self.assertEqual(will - ran, set(), f"{what}\n{told}\n{made.stdout}")
        self.assertEqual(ran - will - may - {"verdict"}, set(), f"{what}\n{told}\n{made.stdout}")
        self.assertEqual(is_stale, int(bool(ran)), f"{what}\n{told}\n{made.stdout}")
        self.assertEqual(self.make(site, "-q", *GOALS[site]).returncode, 0, what)
        return what

    def test_edits_end_in_the_bytes_of_a_clean_make(self):
        for site in GOALS:
            draw, done = random.Random(f"edits of {site}"), []
            edits = Edits(self.work, site, draw)
            for number in range(1, NUM_EDITS + 1):
                with self.subTest(f"{site}, edit {number}"):
                    done.append(self.edit(edits, site))
                    if number % EDITS_PER_CLEAN == 0:
                        shutil.rmtree(self.work.folder / "clean", ignore_errors=True)
                        clean = self.make(site, "MAPS=clean", *GOALS[site])
                        self.assertEqual(clean.returncode, 0, f"{done}\n{clean.stdout}")
                        self.assert_same(self.artifacts("maps", site), self.artifacts("clean", site), done)

    def assert_same(self, found, expected, done):
        self.assertEqual(found.keys() ^ expected.keys(), set(), done)
        self.assertEqual([name for name in found if found[name] != expected[name]], [], done)
