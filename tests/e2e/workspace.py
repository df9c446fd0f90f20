# SPDX-License-Identifier: Apache-2.0
"""A checkout in a temporary folder with a small synthetic building, for the end-to-end tests.

Sources, scripts and programs are links to the repository's, configs are a copy, and data and maps
are its own; so every path is relative and two workspaces must give the same bytes. The programs are
those of NIGHTMAP_BUILD (default: build/), which must be up to date: run `make build` first.
"""
import csv
import fcntl
import hashlib
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest
import zlib

import matplotlib.image
import numpy as np

REPOSITORY = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(REPOSITORY / "scripts"))

from nightmap_site.pipeline import read_pipeline  # noqa: E402
from nightmap_site.receipts import hash_bytes  # noqa: E402

BUILD = pathlib.Path(os.environ.get("NIGHTMAP_BUILD", REPOSITORY / "build")).resolve()
if not (BUILD / "programs.mk").exists():
    raise SystemExit(f"no programs in {BUILD}: run `make build`, or set NIGHTMAP_BUILD")
LINKS = ("Makefile", "CMakeLists.txt", "cmake", "pipeline", "stages", "scripts")
GOALS = ("map", "localize", "plan", "drive")
PIPELINE = read_pipeline(str(REPOSITORY / "configs"))
SITE = "small"
RECORDING = f"data/{SITE}/synthesize.json"
NO_ARTIFACTS = ("config/", "logs/", "lists/", ".preview/", "check/", "verdict/", "evaluate/", "report/")

# The camera of the small building: the demo's at a fraction of its size, so that a run takes seconds.
CAMERA = {"width": 320, "height": 240, "fx": 262.5, "fy": 262.5, "cx": 159.5, "cy": 119.5}
SYNTHESIZE = """\
num_rooms = 1
num_identical_rooms = 0
image_width_px = 320
image_height_px = 240
focal_length_px = 262.5
num_frames = 160
max_step_m = 0.2
max_turn_rad = 0.2
num_light_samples = 8
num_queries = 1
"""


def read_csv(path):
    with open(path, newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def said_by(command, folder=REPOSITORY, code=0, **variables):
    """The output, errors included, of a command that must end with this code; raises AssertionError when it ends with another."""
    command = [str(word) for word in command]
    result = subprocess.run(command, cwd=folder, env=environment() | variables, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
    if result.returncode != code:
        raise AssertionError(f"{' '.join(command)} ended with {result.returncode}:\n{result.stdout[-8000:]}")
    return result.stdout


class Checkout:
    """A workspace or a site of stubs (stub_site.py): a `folder`, and make in it."""

    def remove(self):
        shutil.rmtree(self.folder, ignore_errors=True)

    def removed_after(self, test):
        """Removes it after the test, or after all of a class; returns it."""
        (test.addClassCleanup if isinstance(test, type) else test.addCleanup)(self.remove)
        return self

    def command(self, *arguments):
        return ["make", "--no-print-directory", f"SITE={self.site}", *arguments]

    def output(self, *arguments, code=0, **more):
        """The output of a make that must end with this code; raises AssertionError when it ends with another."""
        result = self.make(*arguments, **more)
        if result.returncode != code:
            raise AssertionError(f"make {' '.join(map(str, arguments))} ended with {result.returncode}:\n{result.stdout}")
        return result.stdout


class Workspace(Checkout):
    site = SITE

    def __init__(self, folder=None):
        self.folder = pathlib.Path(folder or tempfile.mkdtemp(prefix="nightmap-e2e-"))
        if (self.folder / "Makefile").exists():
            return
        for name in LINKS:
            (self.folder / name).symlink_to(REPOSITORY / name)
        (self.folder / "build").symlink_to(BUILD)
        shutil.copytree(REPOSITORY / "configs", self.folder / "configs")
        write_small_site(self.folder)

    @classmethod
    def made(cls, *goals):
        """A workspace in which `goals` have been made: a copy of the one in <build>/small that all tests share."""
        folder = BUILD / "small" / "_".join(goal.replace("/", "-") for goal in goals)
        folder.mkdir(parents=True, exist_ok=True)
        with open(folder / "lock", "w", encoding="utf-8") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            made_of, shared = folder / "made_of", folder / "workspace"
            now = sources()
            if not made_of.exists() or made_of.read_text() != now:
                made_of.unlink(missing_ok=True)
                shutil.rmtree(shared, ignore_errors=True)
                before = ("map",) if len(goals) > 1 else (RECORDING,)  # what follows takes little time
                if goals == (RECORDING,):
                    shared.mkdir()
                else:
                    shutil.move(cls.made(*before).folder, shared)
                cls(shared).output(*goals)
                made_of.write_text(now)
            return cls(shared).copy()

    def as_recorded(self, name=SITE):
        """From now on the recording is one that synthesize does not make."""
        site = self.folder / f"configs/sites/{name}.toml"
        site.write_text(site.read_text().replace("synthetic = true", "synthetic = false"))

    def copy(self):
        """Another workspace in the same state, times included."""
        folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-e2e-"))
        shutil.copytree(self.folder, folder, symlinks=True, dirs_exist_ok=True)
        return Workspace(folder)

    def make(self, *arguments):
        """Runs make; `arguments` are goals, flags and VARIABLE=VALUE."""
        return subprocess.run(self.command(*arguments), cwd=self.folder, env=environment(), text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def run(self, stage, *arguments):
        """Runs a stage program by hand."""
        return subprocess.run([BUILD / "bin" / stage, *map(str, arguments)], cwd=self.folder, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)

    def path(self, name):
        return self.folder / "maps" / SITE / name

    def data(self):
        return self.folder / "data" / SITE

    def runs(self):
        """Stage (shards joined) -> times of its receipts; a stage that reran has others."""
        times = {"synthesize": (self.data() / "synthesize_receipt.json").stat().st_mtime_ns}
        for receipt in sorted((self.folder / "maps" / SITE).glob("*/receipt*.json")):
            times[receipt.parent.name] = times.get(receipt.parent.name, 0) + receipt.stat().st_mtime_ns
        return times

    def hashes(self, site=SITE):
        return artifact_hashes(self.folder / "maps" / site)


def artifact_hashes(root):
    """Relative path -> hash of every artifact of a site; receipts, logs, configs and the cache of hashes are none."""
    files = [path for path in sorted(root.rglob("*")) if path.is_file()]
    names = {str(path.relative_to(root)): path for path in files}
    return {name: hashlib.sha256(path.read_bytes()).hexdigest() for name, path in names.items()
            if "/" in name and not name.startswith(NO_ARTIFACTS) and "receipt" not in name
            and not name.endswith("/hashes.csv")}


def sources():
    """Changes with what the small building's results depend on: programs, scripts, configs and this file."""
    folders = (BUILD / "run", REPOSITORY / "scripts", REPOSITORY / "configs")
    files = [REPOSITORY / "Makefile", pathlib.Path(__file__), *(path for folder in folders for path in folder.rglob("*"))]
    kept = sorted(path for path in files if path.is_file() and path.suffix != ".pyc")
    return "".join(f"{path} {path.stat().st_size} {path.stat().st_mtime_ns}\n" for path in kept)


def write_small_site(folder):
    """The config of the small building, from the demo's, below configs/sites of a checkout."""
    sites = folder / "configs/sites"
    text = (sites / "demo.toml").read_text(encoding="utf-8")
    text = re.sub(r'(?m)^root *=.*', f'root = "{SITE}"', text)
    # Queries are frames held out, so that they lie in the part of the building that is mapped.
    text = re.sub(r"(?m)^hold_out_every *=.*", "hold_out_every = 7", text).split("[[query]]")[0]
    for key, value in CAMERA.items():
        text = re.sub(rf"(?m)^{key} *=.*", f"{key} = {value}", text)
    (sites / f"{SITE}.toml").write_text(text, encoding="utf-8")
    shutil.rmtree(sites / SITE, ignore_errors=True)  # of a user's site of that name
    (sites / SITE).mkdir()
    (sites / SITE / "synthesize.toml").write_text(SYNTHESIZE, encoding="utf-8")
    # So few frames leave unseen strips between what they see of the floor.
    (sites / SITE / "plan.toml").write_text("unknown = \"allowed\"\n", encoding="utf-8")
    (sites / SITE / "frames.toml").write_text("shard_size = 25\nmax_frames = 60\n", encoding="utf-8")


LASER_SITE = "lab"
LASER_SYNTHESIZE = """\
num_rooms = 1
num_identical_rooms = 0
num_frames = 300
render = false
scan_rate_hz = 4
scan_field_of_view_deg = 360
scan_num_beams = 90
"""


def write_laser_site(folder):
    """The config of the small building as a robot with a laser and wheels records it, from demo_laser's."""
    sites = folder / "configs/sites"
    text = (sites / "demo_laser.toml").read_text(encoding="utf-8")
    text = re.sub(r'(?m)^root *=.*', f'root = "{LASER_SITE}"', text)
    text = re.sub(r"(?m)^angle_step_deg *=.*", "angle_step_deg = 4", text)
    (sites / f"{LASER_SITE}.toml").write_text(text, encoding="utf-8")
    (sites / LASER_SITE).mkdir()
    (sites / LASER_SITE / "synthesize.toml").write_text(LASER_SYNTHESIZE, encoding="utf-8")


def told_by_why(said):
    """The rules that `make why` says will run, and those that may."""
    lines = [line.partition(": ")[::2] for line in said.splitlines() if ": " in line]
    may = {rule for rule, reason in lines if " may change" in reason}
    return {rule for rule, _ in lines} - may, may


def as_its_job_wrote(path):
    """From now on the receipts beside a file have the hash of its present bytes; their times stay."""
    for receipt in path.parent.glob("receipt*.json"):
        content, status = json.loads(receipt.read_text()), receipt.stat()
        for entry in content["outputs"]:
            if pathlib.Path(entry["path"]).name == path.name:
                entry["xxh3"] = hash_bytes(path.read_bytes())
        receipt.write_text(json.dumps(content, indent=1) + "\n")
        os.utime(receipt, ns=(status.st_atime_ns, status.st_mtime_ns))


def environment():
    """The caller's, without what make hands down to a make it starts."""
    return {key: value for key, value in os.environ.items()
            if key not in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "MAKEOVERRIDES")}


class SiteTest(unittest.TestCase):
    """A test with the workspace `work`; `given` are arguments of every make."""

    given = ()

    def make(self, *arguments, code=0, **more):
        return self.work.output(*self.given, *arguments, code=code, **more)


class CopiedSiteTest(SiteTest):
    """Each test has a copy of the workspace `base`, in which these goals are `made`; `hashes` are of its results."""

    made = ("map",)

    @classmethod
    def setUpClass(cls):
        cls.base = Workspace.made(*cls.made).removed_after(cls)
        cls.hashes = cls.base.hashes()

    def setUp(self):
        self.work = self.base.copy().removed_after(self)


def write_black(path, width, height):
    """A color picture without any feature, in the format the name says."""
    matplotlib.image.imsave(path, np.zeros((height, width, 3), np.uint8))


def write_gray16(path, width, height, value=0):
    """A 16-bit gray PNG of one value."""
    def chunk(kind, body):
        return (struct.pack(">I", len(body)) + kind + body
                + struct.pack(">I", zlib.crc32(kind + body)))

    row = b"\0" + struct.pack(">H", value) * width
    pathlib.Path(path).write_bytes(
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", width, height, 16, 0, 0, 0, 0))
        + chunk(b"IDAT", zlib.compress(row * height)) + chunk(b"IEND", b""))
