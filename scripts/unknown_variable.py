# SPDX-License-Identifier: Apache-2.0
"""unknown_variable.py "UNKNOWN..." KNOWN...: prints why make refuses variables of its command line, with the nearest known
names. scripts/variables.mk calls it."""

import difflib
import sys


def complaint(unknown, known):
    nearest = difflib.get_close_matches(unknown.upper(), known, 1)
    return f"{unknown}: no such variable" + (f"; did you mean {nearest[0]}?" if nearest else "")


print("; ".join(complaint(name, sys.argv[2:]) for name in sys.argv[1].split()) + " (`make help` lists the variables)")
