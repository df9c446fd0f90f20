#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Removes what nightmap made, and names it: `make clean` and `make distclean`.

    remove_results.py site MAPS/SITE
    remove_results.py all MAPS DATA BUILD...

Removes only folders that hold nightmap's mark: the rules or configs of a site, the mark of a recording that synthesize
made, the cache of a build. Leaves everything else in MAPS, and says so. Exit codes: 0 nothing of nightmap is left there;
1 something could not be removed; 2 wrong command line.
"""

import os
import shutil
import sys

from nightmap_site.script_errors import printable

SITE_MARKS = ("graph.mk", ".preview/graph.mk", "config/frames.toml")
RECORDING_MARK = ".made_by_synthesize"
BUILD_MARKS = ("programs.mk", "CMakeCache.txt")


class Removal:
    def __init__(self):
        self.has_failed = False

    def remove(self, folder):
        """Removes a folder; a link goes, and what it leads to stays."""
        try:
            os.remove(folder) if os.path.islink(folder) else shutil.rmtree(folder)
            print(f"removed {printable(folder)}")
        except OSError as error:
            self.has_failed = True
            where = error.filename if isinstance(error.filename, str) else folder
            print(f"nightmap: {printable(where)}: {error.strerror}: correct its permissions", file=sys.stderr)

    def remove_if(self, is_ours, folder, otherwise):
        if is_ours:
            self.remove(folder)
        elif os.path.lexists(folder):
            print(f"left {printable(folder)}: {otherwise}")

    def site(self, folder):
        self.remove_if(_has(folder, SITE_MARKS) or _names(folder) == [".lock"], folder, "no results of a site")

    def everything(self, maps, data, builds):
        for folder in _entries(maps):
            self.site(folder)
        if os.path.isdir(maps) and not os.path.islink(maps) and not _names(maps):
            self.remove(maps)
        for folder in _entries(data):
            if _has(folder, (RECORDING_MARK,)):
                self.remove(folder)
        for folder in builds:
            self.remove_if(_has(folder, BUILD_MARKS), folder, "no build of nightmap")


def _names(folder):
    return sorted(os.listdir(folder)) if os.path.isdir(folder) else []


def _entries(folder):
    return [os.path.join(folder, name) for name in _names(folder)]


def _has(folder, marks):
    return os.path.isdir(folder) and any(os.path.lexists(os.path.join(folder, mark)) for mark in marks)


def main(arguments):
    removal = Removal()
    match arguments:
        case ["site", folder]:
            removal.site(folder)
        case ["all", maps, data, *builds]:
            removal.everything(maps, data, builds)
        case _:
            print(__doc__, file=sys.stderr)
            return 2
    return 1 if removal.has_failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
