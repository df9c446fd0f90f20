# SPDX-License-Identifier: Apache-2.0
"""Commands, options and messages that pages name exist."""

import re
import shlex
import subprocess
import tempfile
import unittest
from pathlib import Path

import doc_sources
from doc_sources import GAP, OPTIONS, text_of
from fake_site import CHECKOUT  # finds the scripts, so first

import describe_options

PAGES = ["README.md", "ARCHITECTURE.md", "datasets.md", *sorted(str(page.relative_to(CHECKOUT)) for page in (CHECKOUT / "docs").rglob("*.md"))]
END_OF_COMMAND = {"|", "||", "&&", ";", "&", ">", ">>", "2>", "2>&1", "do", "done"}
FILES = {"toml", "h5", "csv", "json", "tum", "txt", "py", "cc", "h", "html", "yaml", "png", "ply", "log", "gif", "mk", "pgm", "hdf5", "md", "g2o", "geojson", "dxf", "glb"}
MADE_UP = {"rooms"}  # a goal that a page adds as its example
OF_OTHERS = re.compile(r"\b(?:salloc|srun|cmake|ctest|ros2|reader\.py|colmap|gtest_filter)\b")  # programs that are not nightmap's
NAMED_OPTION = re.compile(r"(?<![\w./-])([a-z_]+)\.([a-z]\w*)(?![\w./])")
SCRIPT = re.compile(r"(?:scripts|tests)/[\w/]+\.(?:py|sh)")


def code_of(text):
    """Pieces of code of a page: lines of its blocks, and what stands in quotes of its text."""
    for block in re.findall(r"^```(?:\w*)\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        yield from re.sub(r"\\\n\s*", "", block).splitlines()
    text = re.sub(r"^```.*?^```", "", text, flags=re.MULTILINE | re.DOTALL)
    yield from (" ".join(span.split()) for _, span in re.findall(r"(`+)(.+?)(?<!`)\1(?!`)", text, re.DOTALL))


def quoted_messages(page):
    """The messages in the first column of a page's tables."""
    return [message.strip() for _, message in re.findall(r"^\| (`+)(.+?)\1 \|", page, re.MULTILINE)]


MESSAGES = quoted_messages(text_of("docs/troubleshooting.md"))
CODE = [(page, code) for page in PAGES for code in code_of(text_of(page)) if code not in MESSAGES]


def words_of(code):
    lexer = shlex.shlex(re.sub(r"<([\w ]+)>", r"\1", code), posix=True, punctuation_chars=";&|")
    lexer.whitespace_split, lexer.commenters = True, "#"
    try:
        return list(lexer)
    except ValueError:  # an open quote: no command
        return []


def makes_in(code):
    """Arguments of each call of make in a piece of code."""
    words = words_of(code)
    for start in (index + 1 for index, word in enumerate(words) if word == "make"):
        end = next((index for index in range(start, len(words)) if words[index] in END_OF_COMMAND), len(words))
        yield words[start:end]


def mistakes_in_make(arguments, goals, variables):
    """Goals, variables and options that a call of make names and that do not exist."""
    takes_value = False
    for word in arguments:
        name, equals, value = word.partition("=")
        if takes_value or word.startswith("-"):
            takes_value = word in ("-j", "-f", "-C")
        elif equals:
            if name not in variables:
                yield f"variable {name}"
            elif name == "SET":
                yield from mistakes_in_set(value)
        elif "/" not in word and word not in goals:
            yield f"goal {word}"


def mistakes_in_set(value):
    for setting in shlex.split(value):
        program, _, key = setting.partition("=")[0].partition(".")
        if key.isupper() or program == "stage":  # in the place of a name
            continue
        if key not in OPTIONS.get(program, ()):
            yield f"option {program}.{key}"


def is_printed(message, texts):
    """Whether a text of the sources has all fixed parts of a message, in this order. `...` stands for what is put in."""
    parts = [re.escape(part) for part in message.split("...")]
    return any(re.search(".*?".join(parts), text, re.DOTALL) for text in texts)


class DocsNamesTest(unittest.TestCase):
    def test_options_page_is_current(self):
        page = text_of("docs/options.md").split(describe_options.BEGIN)[1].split(describe_options.END)[0]
        self.assertEqual(page.strip(), describe_options.describe(CHECKOUT / "configs").strip(), "scripts/describe_options.py --write")

    def test_options_page_has_every_option(self):
        page = text_of("docs/options.md")
        for program, keys in OPTIONS.items():
            rows = re.findall(r"^\| `(\w+)` \|", page.split(f"\n### {program}\n")[1].partition("\n##")[0], re.MULTILINE)
            self.assertEqual(sorted(rows), sorted(keys), program)

    def test_goals_and_variables_exist(self):
        goals, variables = doc_sources.goals() | MADE_UP, doc_sources.variables()
        calls = [(page, code, arguments) for page, code in CODE for arguments in makes_in(code)]
        self.assertGreater(len(calls), 200)
        self.assertEqual([(page, code, mistake) for page, code, arguments in calls for mistake in mistakes_in_make(arguments, goals, variables)], [])

    def test_options_of_programs_exist(self):
        ports = doc_sources.ports()
        named = [(page, code, program, key) for page, code in CODE for program, key in NAMED_OPTION.findall(code) if program in OPTIONS and key not in FILES]
        self.assertGreater(sum(key in OPTIONS[program] for _, _, program, key in named), 40)
        self.assertEqual([item for item in named if item[3] not in OPTIONS[item[2]] | ports.get(item[2], set())], [])

    def test_settings_outside_of_calls_exist(self):
        settings = [(page, code, words_of(code)[0].partition("=")[2]) for page, code in CODE if re.match("SET=.", code)]
        self.assertGreater(len(settings), 10)
        self.assertEqual([(page, code, mistake) for page, code, value in settings for mistake in mistakes_in_set(value)], [])

    def test_options_of_command_lines_exist(self):
        known = doc_sources.flags()
        flags = [(page, code, flag) for page, code in CODE if not OF_OTHERS.search(code) for flag in re.findall(r"(?<![\w-])--([a-z][\w-]+)", code)]
        self.assertGreater(len(flags), 40)
        wrong = []
        for page, code, flag in flags:
            script = SCRIPT.search(code)
            if flag not in (doc_sources.flags_of(script[0]) if script else known):
                wrong.append((page, code, flag))
        self.assertEqual(wrong, [])

    def test_commands_parse(self):
        num_blocks = 0
        for page in PAGES:
            for block in re.findall(r"^```\n(.*?)^```", text_of(page), re.MULTILINE | re.DOTALL):
                if re.match(r"(?:make|for|nohup|scripts/|build/|salloc|ls|awk) ?\b", block):
                    num_blocks += 1
                    text = re.sub(r"<([\w ]+)>", r"\1", block)
                    parsed = subprocess.run(["bash", "-n"], input=text, capture_output=True, text=True)
                    self.assertEqual(parsed.returncode, 0, f"{page}: {block}{parsed.stderr}")
        self.assertGreater(num_blocks, 20)

    def test_quoted_messages_are_printed(self):
        texts = list(doc_sources.messages())
        self.assertGreaterEqual(len(MESSAGES), 40)
        self.assertEqual([message for message in MESSAGES if not is_printed(message, texts)], [])

    def test_parts_of_the_report_page_are_there(self):
        """Pages for users quote their titles."""
        texts = set(doc_sources.messages())
        for page in ("docs/first_hour.md", "docs/overnight.md", "docs/configs.md"):
            text = re.sub(r"^```.*?^```|`[^`]*`", "", text_of(page), flags=re.MULTILINE | re.DOTALL)
            titles = re.findall(r"\"([A-Z][^\"]+)\"", text)
            self.assertTrue(titles, page)
            self.assertEqual([title for title in titles if not any(" ".join(title.split()) in known for known in texts)], [], page)

    def test_mistakes_are_found(self):
        goals, variables = {"map"}, {"SITE", "SET"}
        for call, wrong in (("make map SITE=<site>", []), ("V=1 make -j 4 map # mop", []), ("make mop", ["goal mop"]), ("make map SIET=a", ["variable SIET"]),
                            ('make map SET="octree.max_range_m=6 plan.hurry=1"', ["option plan.hurry"]), ("make map | tail", [])):  # fmt: skip
            with self.subTest(call):
                found = [mistake for arguments in makes_in(call) for mistake in mistakes_in_make(arguments, goals, variables)]
                self.assertEqual(found, wrong)

    def test_words_that_nothing_prints_are_found(self):
        texts = [*doc_sources.texts_of_cpp('f("{}: no such\\n"\n "folder: \\"{:.2f}\\"", x);'), *doc_sources.texts_of_python('f"{a} is {b!r}, so" f" {c}"')]
        self.assertEqual(texts[:1], [f"{GAP}: no suchnfolder: \"{GAP}\""])
        self.assertTrue(is_printed("... is ..., so", texts))
        self.assertFalse(is_printed("... was ..., so", texts))
        self.assertFalse(is_printed("so ... is", texts))

    def test_an_option_without_its_comment_is_found(self):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "a.toml"
            path.write_text("# a: head\n\n# meaning; 1: off; 0 .. 1e-3\nb = 0.5\n\n# one\n# text; or none\nc = \"\"\n")
            self.assertEqual(list(describe_options.options_in(path)),
                             [("b", "0.5", "0 .. 1e-3", "meaning; 1: off"), ("c", '""', "text", "one text; or none")])  # fmt: skip
            path.write_text("b = 0.5\n")
            self.assertRaisesRegex(describe_options.DataError, "b has no comment", list, describe_options.options_in(path))
