# SPDX-License-Identifier: Apache-2.0
"""Comments and pages say their subject first: no comment, and no sentence of a page, begins with a fragment."""

import re
import subprocess
import tempfile
import unittest
from pathlib import Path

from fake_site import CHECKOUT  # finds the scripts, so first

BEGINNING = r"[(*\"'“]*(?:Of|What|That|Which|Whose)\b"
SLASHES, HASHES = r"//+", r"#+"
MARKS = {".cc": SLASHES, ".h": SLASHES, ".js": SLASHES, ".py": HASHES, ".toml": HASHES, ".mk": HASHES, ".cmake": HASHES, ".sh": HASHES,
         "Makefile": HASHES, "CMakeLists.txt": HASHES}


def comments_of(text, mark, doc=r'"""'):
    """(line, words) of each comment: lines that hold nothing else and follow each other are one, and so is a docstring."""
    start, words = 0, []
    for number, line in enumerate([*re.sub(r"(?m)^.*SPDX-.*$", "", text).splitlines(), ""], 1):  # the license's line is none
        alone = re.match(rf"\s*{mark}(?!!)\s?(.*)", line)
        if words and not (alone and alone[1].strip()):
            yield start, " ".join(words)
            words = []
        if alone and alone[1].strip():
            start, words = (start if words else number), [*words, alone[1].strip()]
        elif beside := re.search(rf"\s{mark} (.*)", line):
            yield number, beside[1]
    for found in re.finditer(rf"^\s*{doc}(.*?){doc}", text, re.MULTILINE | re.DOTALL):
        yield text.count("\n", 0, found.start(1)) + 1, " ".join(found[1].split())


def paragraphs_of(text):
    """(line, words) of each paragraph, item and cell of a page; headings and blocks of code are none."""
    text = re.sub(r"^```.*?^```", lambda found: re.sub(r"[^\n]", "", found[0]), text, flags=re.MULTILINE | re.DOTALL)
    for found in re.finditer(r"(?:^|(?<=\|))[ >]*(?:[-*] |\d+\. )?(?![#\s])((?:[^\n|]|\n(?!\s*(?:[-*#|]|\d+\.|\n)))+)", text, re.MULTILINE):
        yield text.count("\n", 0, found.start(1)) + 1, " ".join(found[1].split())


def fragments_in(path):
    """(line, sentence) of each beginning with a fragment in a file. Questions are none."""
    text, mark = path.read_text(encoding="utf-8"), MARKS.get(path.suffix) or MARKS.get(path.name)
    for line, words in comments_of(text, mark) if mark else paragraphs_of(text):
        for sentence in re.split(r"(?<=[.!?])[)*\"'”]*\s+", words):
            if re.match(BEGINNING, sentence) and not sentence.endswith("?"):
                yield line, sentence


PLANTED = {  # \x28 is "(", so that this file has no such comment
    "a.cc": ('// SPDX-x: y\n// What moves.\nint a = 1;  // Of b.\nf("# What");\n\n// Sets c.\n// Of d.\n',
             [(2, "What moves."), (3, "Of b."), (6, "Of d.")]),
    "a.py": ('"""Which is\ntrue."""\n# A\n# That.\nx = "What"  # which\n', [(1, "Which is true.")]),
    "a.toml": ('# Whose\n# it is.\na = 1  # \x28Of b.)\n', [(1, "Whose it is."), (3, "(Of b.)")]),
    "a.md": ("# What it is\nIt is. What\nelse?\n\n- **That\n  is.** It is.\n- a\n1. Of b.\n\n| a | What |\n\n```\nWhat\n```\n",
             [(5, "**That is."), (8, "Of b."), (10, "What")]),
}  # fmt: skip


class ProseTest(unittest.TestCase):
    def test_the_subject_comes_first(self):
        tracked = subprocess.run(["git", "-C", str(CHECKOUT), "ls-files", "-z"], capture_output=True, text=True, check=True).stdout
        files = [CHECKOUT / name for name in tracked.split("\0")[:-1]]
        of_text = [file for file in files if file.is_file() and {file.name, file.suffix} & {*MARKS, ".md"}]
        self.assertEqual([f"{file.relative_to(CHECKOUT)}:{line}: {found}" for file in of_text for line, found in fragments_in(file)], [])

    def test_what_is_planted_is_found(self):
        folder = Path(self.enterContext(tempfile.TemporaryDirectory()))
        for name, (text, found) in PLANTED.items():
            (folder / name).write_text(text, encoding="utf-8")
            with self.subTest(name):
                self.assertEqual(sorted(fragments_in(folder / name)), found)
