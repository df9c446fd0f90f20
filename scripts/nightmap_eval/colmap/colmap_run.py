# SPDX-License-Identifier: Apache-2.0
"""Runs COLMAP for one step of the comparison: progress, log, time, and an atomic result.

A step writes into its own folder, which is renamed when it is complete and on the disk; receipt.json, for
Make, is written last. Between the two renames the folder of the previous run is <folder>.old; a step killed
there finds it again. A step whose COLMAP failed also gets a receipt, with the reason, so that the other steps
continue; its modification time is in the past, so that the next make tries again.
"""

import contextlib
import fcntl
import json
import os
import re
import resource
import shutil
import subprocess
import time
import weakref
from dataclasses import dataclass

from nightmap_eval.artifacts import WritingFolder
from nightmap_site.checked_reading import NUMBER, read_object
from nightmap_site.script_errors import DataError

# COLMAP's progress lines.
PROGRESS = re.compile(r"\[\d+/\d+|Registering image|Triangulating image|Bundle adjustment|Retriangulation")
SHOW_EVERY_S = 5.0
RECEIPT = {
    "colmap": str, "threads": int, "failed": (str, type(None)), "?skipped": str, "?matching": str,
    "parts": [{"name": str, "wall_time_s": NUMBER, "?cpu_time_s": NUMBER}],
}  # fmt: skip
LONG_AGO_S = 10**6
# COLMAP's mapper draws random samples, so its maps differ: the median run counts.
MAPPER_RUNS = ("mapper_1", "mapper_2", "mapper_3")
# Images that the vocabulary tree retrieves per query. `queries`: as many as per mapping frame (COLMAP's count
# includes the frame itself); `queries_default`: COLMAP's default number.
MATCHED_WITH = {"queries": 30, "queries_default": 100}


class ColmapFailed(Exception):
    """COLMAP ran and gave no result: the variant fails, the others continue."""


class ColmapSkipped(Exception):
    """The step would repeat another, and so would the variant: it is left out."""


def require_colmap():
    """COLMAP's version. Raises DataError with the remedy when COLMAP is not installed."""
    if not shutil.which("colmap"):
        raise DataError("colmap is not installed; run `make deps` (Debian package colmap)")
    text = subprocess.run(["colmap", "help"], capture_output=True, text=True, check=False).stdout
    found = re.search(r"COLMAP [\w.]+", text)
    if not found:
        raise DataError("`colmap help` prints no version; is another program of that name installed?")
    return found.group(0)


def _children_cpu_s():
    """CPU seconds of all commands that ended so far, on all cores."""
    usage = resource.getrusage(resource.RUSAGE_CHILDREN)
    return usage.ru_utime + usage.ru_stime


@contextlib.contextmanager
def _alone_in(folder):
    """Keeps two runs of a step from renaming at the same time."""
    descriptor = os.open(folder, os.O_RDONLY | os.O_CLOEXEC)
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX)
        yield
    finally:
        os.close(descriptor)


class Step:
    """One step: a folder and the COLMAP commands that fill it."""

    def __init__(self, folder, threads):
        self.version = require_colmap()
        self.final, self.threads, self.parts = folder, threads, []
        self.old = folder.with_name(folder.name + ".old")
        folder.parent.mkdir(parents=True, exist_ok=True)
        with _alone_in(folder.parent):
            if self.old.exists() and not self.final.exists():
                os.rename(self.old, self.final)  # killed between the two renames of finish
            shutil.rmtree(self.old, ignore_errors=True)
        writing = WritingFolder(folder.parent)
        self._remove_writing = weakref.finalize(self, writing.remove)  # runs also when the program ends
        self.folder = writing.path / folder.name
        self.folder.mkdir()

    def colmap(self, command, **options):
        """Runs `colmap <command>`; an option a__b is --a.b. Returns the lines it printed. Raises
        ColmapFailed with the reason."""
        line = ["colmap", command, "--log_to_stderr", "1"]
        for name, value in options.items():
            line += ["--" + name.replace("__", "."), str(value)]
        print(f"colmap {command}", flush=True)
        start_s, start_cpu_s = time.monotonic(), _children_cpu_s()
        with open(self.folder / "colmap.log", "a", encoding="utf-8") as log:
            log.write(" ".join(line) + "\n")
            status, printed = self._run(line, log)
        seconds = time.monotonic() - start_s
        cpu_s = _children_cpu_s() - start_cpu_s
        self.parts.append({"name": command, "wall_time_s": seconds, "cpu_time_s": cpu_s})
        if status != 0:
            how = f"ended by signal {-status}" if status < 0 else f"exit code {status}"
            last = next((text.strip() for text in reversed(printed) if text.strip()), "")
            raise ColmapFailed(f"colmap {command}: {how}: {last}")
        print(f"colmap {command}: {seconds:.1f} s", flush=True)
        return printed

    def _run(self, line, log):
        """Exit status and the lines that were printed."""
        printed, shown_s = [], time.monotonic()
        environment = os.environ | {"OMP_NUM_THREADS": str(self.threads)}
        with subprocess.Popen(
            line, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, errors="replace", env=environment
        ) as process:
            try:
                for text in process.stdout:
                    log.write(text)
                    printed.append(text)
                    if PROGRESS.search(text) and time.monotonic() - shown_s > SHOW_EVERY_S:
                        print(f"  {text.strip()}", flush=True)
                        shown_s = time.monotonic()
                return process.wait(), printed
            finally:
                process.kill()  # when this script is terminated, COLMAP must end too; otherwise it has ended already

    def finish(self, failed=None, **figures):
        receipt = {"format": "nightmap colmap receipt", "version": 1, "step": self.final.name,
                   "colmap": self.version, "threads": self.threads, "failed": failed,
                   "parts": self.parts, **figures}  # fmt: skip
        path = self.folder / "receipt.json"
        path.write_text(json.dumps(receipt, indent=1) + "\n", encoding="utf-8")
        if failed:
            print(f"{self.final.name}: failed: {failed}", flush=True)
            long_ago_ns = LONG_AGO_S * 10**9 + time.time_ns() % 10**9  # differs from the time of the last failure
            os.utime(path, ns=(long_ago_ns, long_ago_ns))
        for made in self.folder.rglob("*"):
            if made.is_file():
                with open(made, "rb") as file:
                    os.fsync(file.fileno())
        with _alone_in(self.final.parent):
            if self.final.exists():
                os.rename(self.final, self.old)
            os.rename(self.folder, self.final)
            shutil.rmtree(self.old, ignore_errors=True)
        self._remove_writing()


def read_receipt(folder):
    return read_object(folder / "receipt.json", RECEIPT, "delete its folder and run make evaluate-colmap again")


def require(folder):
    """The receipt of an earlier step. Raises ColmapFailed or ColmapSkipped with its reason when there is no result."""
    receipt = read_receipt(folder)
    if "skipped" in receipt:
        raise ColmapSkipped(receipt["skipped"])
    if receipt["failed"]:
        raise ColmapFailed(receipt["failed"])
    return receipt


@dataclass(frozen=True)
class Run:
    """One map and the queries in it, named by the steps that make them."""

    method: str
    map_step: str
    queries_step: str
    register_step: str


def _runs(suffix):
    maps = [("mapper", step, step) for step in MAPPER_RUNS]
    maps += [("triangulate", "triangulate", "triangulate"), ("held", "triangulate", "held")]
    return [
        Run(f"colmap_{method}{suffix}", map_step, f"queries{suffix}", f"register_{name}{suffix}")
        for method, map_step, name in maps
    ]


RUNS = (*_runs(""), *_runs("_default"))
METHODS = tuple(dict.fromkeys(run.method for run in RUNS))
