#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""Runs a test program, unless it has passed and since then neither it, which its sources and our libraries are linked into,
nor the configs, which are all that it reads of the repository, have changed. `PROGRAM.passed` holds the state that passed.
One that lacked a recording runs again; at night all run."""
import os
import pathlib
import subprocess
import sys

READ = "configs"
UNCHANGED = "passed before, and nothing changed"
WITHOUT_DATA = b"is missing: set NIGHTMAP_DATA"  # of a test that was skipped


def state_of(program):
    """A line for each file, with the variables that tests obey."""
    files = [path for path in pathlib.Path(READ).rglob("*") if path.is_file()]
    variables = [f"{name}={os.environ.get(name, '')}\n" for name in ("CI", "GTEST_FILTER", "NIGHTMAP_DATA")]
    stats = [(path, path.stat()) for path in (pathlib.Path(program), *sorted(files))]
    return "".join(variables + [f"{path} {stat.st_size} {stat.st_mtime_ns}\n" for path, stat in stats])


def main(program):
    passed = pathlib.Path(f"{program}.passed")
    state = state_of(program)
    if os.environ.get("NIGHTMAP_NIGHTLY") != "1" and passed.exists() and passed.read_text(encoding="utf-8") == state:
        print(UNCHANGED)
        return 0
    passed.unlink(missing_ok=True)
    is_whole = True
    with subprocess.Popen([program], stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        for line in process.stdout:  # each at once, so that one that hangs has said where
            sys.stdout.buffer.write(line)
            sys.stdout.buffer.flush()
            is_whole = is_whole and WITHOUT_DATA not in line
    if process.returncode < 0:
        print(f"{program}: ended by signal {-process.returncode}")
    if process.returncode == 0 and is_whole:
        passed.write_text(state, encoding="utf-8")
    return process.returncode


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
