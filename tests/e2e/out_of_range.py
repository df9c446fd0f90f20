# SPDX-License-Identifier: Apache-2.0
"""Values that the options of a program must refuse."""
import re
import subprocess
import tomllib

from workspace import BUILD, REPOSITORY

NO_CHOICE = "no_such_choice"
OPTION = re.compile(r"^  (\w+) +.*\[default .*; (.*)\]$", re.MULTILINE)


def options(program):
    """(name, a value out of range, as the program prints it) of each option whose values have a range: one below it and one above."""
    page = subprocess.run([BUILD / "run" / program, "--help"], capture_output=True, text=True, check=True).stdout
    defaults = tomllib.loads(next(REPOSITORY.glob(f"configs/*/default/{program}.toml")).read_text())
    for name, values in OPTION.findall(page.partition("options in the config file")[2]):
        default = defaults[name]
        if values.startswith("one of "):
            yield name, NO_CHOICE
            continue
        low, high = (float(end) for end in values.split(" .. "))
        for wrong in (low - 1, high + 1):
            whole = isinstance(default, int) or (isinstance(default, list) and program != "plan")
            text = f"{wrong:.0f}" if whole else f"{wrong}"
            yield name, f"[{text}]" if isinstance(default, list) else text


def said_of(wrong):
    return [NO_CHOICE] if wrong == NO_CHOICE else [" = ", "out of range"]
