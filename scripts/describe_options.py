#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""describe_options: prints all options of all programs as tables in Markdown; --write puts them into docs/options.md.

They go between the page's markers. Their source is configs/<wing>/default, which tests/e2e/programs_test.py compares with the programs,
and the first words of each main.cc; a test compares the page with both.
Exit codes: 0 done; 1 the page has no markers, or a config has an option without its comment; 2 wrong command line.
"""

import re
from pathlib import Path

from describe_pipeline import CHECKOUT, print_or_write
from nightmap_site.checked_reading import read_text
from nightmap_site.script_errors import DataError, run_main

PAGE = CHECKOUT / "docs/options.md"
BEGIN, END = "<!-- options:begin -->", "<!-- options:end -->"
HEAD = ("| option | default | values | meaning |", "|---|---|---|---|")
OPTION = re.compile(r"(?:^# .*\n)*^(?P<name>\w+) = (?P<default>.*)$", re.MULTILINE)
MEANING = re.compile(r"(?P<meaning>.*?)(?:; (?P<values>one of [\w, ]+|[-+.\de]+ \.\. [-+.\de]+))?", re.DOTALL)
REMEDY = "write the config anew: PROGRAM --print-config --config FILE"


def options_in(path):
    """(name, default, values, meaning) of each option of a default config, as the program printed them: the comment above an option
    holds its meaning, and after it the values that it takes; empty where it takes any of its kind."""
    text = read_text(path, REMEDY)
    for found in OPTION.finditer(text):
        comment = " ".join(line.removeprefix("# ") for line in found[0].splitlines()[:-1])
        if not comment:
            raise DataError(f"{path}: {found['name']} has no comment; {REMEDY}")
        parts = MEANING.fullmatch(comment)
        yield found["name"], found["default"], parts["values"] or kind_of(found["default"]), parts["meaning"]


def kind_of(default):
    return {"t": "true or false", "f": "true or false", '"': "text", "[": "list"}.get(default[0], "number")


def purpose_of(program):
    """The first comment of the program's main.cc, without its name."""
    [path] = CHECKOUT.glob(f"stages/*/{program}/main.cc")
    lines = re.match(r"// SPDX.*\n((?://.*\n)*)", read_text(path, "restore it"))[1].splitlines()
    return " ".join(line.removeprefix("// ") for line in lines).removeprefix(f"{program}: ")


def cell(text):
    return text.replace("|", r"\|").replace("<", "&lt;").replace("*", r"\*")


def table(path):
    rows = [f"| `{name}` | `{default}` | {cell(values)} | {cell(meaning)} |" for name, default, values, meaning in options_in(path)]
    said = "\n".join([*HEAD, *rows]) if rows else "It has no options."
    return f"### {path.stem}\n\n`{path.stem}` {purpose_of(path.stem)}\n\n{said}\n"


def describe(configs):
    """A section per wing that brings programs, and in it one per program."""
    wings = sorted({path.parent.parent.name for path in configs.glob("*/default/*.toml")})
    parts = ["\n".join([f"## {wing}\n", *(table(path) for path in sorted((configs / wing / "default").glob("*.toml")))]) for wing in wings]
    return "\n" + "\n".join(parts)


if __name__ == "__main__":
    run_main(lambda: print_or_write(__doc__, PAGE, (BEGIN, END), lambda: describe(Path(CHECKOUT / "configs"))))
