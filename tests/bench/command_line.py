# SPDX-License-Identifier: Apache-2.0
"""Options of command lines, runs of commands, and tables of figures pages, for all benchmarks."""

import argparse
import subprocess
from pathlib import Path

import checkout  # noqa: F401  first: it makes the packages of scripts/ importable
from nightmap_eval.figure_page import put_figure
from nightmap_site.script_errors import DataError

OPTIONS = {
    "data": {"type": Path, "required": True, "help": "recordings"},
    "build": {"type": Path, "required": True, "help": "programs; results go to a folder of the benchmark's name in it"},
    "threads": {"type": int, "default": 2, "help": "threads per program"},
    "page": {"type": Path, "help": "page that receives the table"},
}


def parser_of(script, *options):
    """A parser for the script of this docstring, with some of OPTIONS."""
    parser = argparse.ArgumentParser(description=script.splitlines()[0])
    for name in options:
        parser.add_argument(f"--{name}", **OPTIONS[name])
    return parser


def output_of(command):
    """The output of a command; raises DataError with it when the command fails."""
    command = [str(word) for word in command]
    run = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    if run.returncode != 0:
        raise DataError(f"{' '.join(command)}\n{run.stdout}\nthe run failed, see above")
    return run.stdout


def markdown(titles, rows, num_words=1):
    """A table whose first columns are words, and the others numbers."""
    lines = [titles, ["---"] * num_words + ["---:"] * (len(titles) - num_words), *rows]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def put_into_page(arguments, name, text):
    if arguments.page:
        put_figure(arguments.page, name, text)
