# SPDX-License-Identifier: Apache-2.0
"""The build of the programs that a site runs. The rule of <build>/programs.mk (scripts/development.mk) builds them, and all that
were built before; so a program that is older than its sources is never run."""

import glob
import os

from nightmap_make.child import Child
from nightmap_make.rules_file import Times

SOURCES = ("CMakeLists.txt", "cmake/*.cmake", "pipeline/*/links.cmake", "stages/*/links.cmake", "pipeline/*/*.h", "pipeline/*/*.cc",
           "stages/*/*/*.h", "stages/*/*/*.cc")  # fmt: skip


def reason_to_build(build, programs):
    """None when the programs are up to date."""
    made = Times().of(f"{build}/programs.mk")
    missing = [program for program in programs if not os.path.exists(f"{build}/run/{program}")]
    if made is None or len(missing) == len(programs):
        return "they are not built yet"
    if missing:
        return f"{missing[0]} is not built yet"
    newer = [path for pattern in SOURCES for path in glob.glob(pattern) if os.stat(path).st_mtime_ns > made]
    return f"{newer[0]} is newer than they are" if newer else None


def build_programs(env, programs):
    """Returns whether it succeeded; what failed has been printed."""
    command = ["make", "--no-print-directory", f"{env['BUILD']}/programs.mk"]
    return Child().run(command, env | {"NIGHTMAP_PROGRAMS": " ".join(programs)}) == 0
