# SPDX-License-Identifier: Apache-2.0
"""A site whose programs are stubs (stub_program.sh): for tests of the rules, of which none needs pixels. A run of all
jobs takes half a second."""
import hashlib
import os
import pathlib
import re
import shutil
import subprocess
import tempfile

from workspace import PIPELINE, REPOSITORY, Checkout, SiteTest, environment, read_pipeline

SITE = "demo"
STUB = REPOSITORY / "tests/e2e/stub_program.sh"


class StubSite(Checkout):
    site = SITE

    def __init__(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-e2e-"))
        for name in ("Makefile", "scripts"):
            (self.folder / name).symlink_to(REPOSITORY / name)
        shutil.copytree(REPOSITORY / "configs", self.folder / "configs")
        for declaration in self.folder.glob("configs/**/pipeline.toml"):  # what stubs write is not to be judged
            declaration.write_text(re.sub(r"(?m)^section\.verdict = .*\n", "", declaration.read_text()))
        (self.folder / "CMakeLists.txt").touch()
        (self.folder / "build/run").mkdir(parents=True)
        (self.folder / "data" / SITE).mkdir(parents=True)
        for program in PIPELINE.programs():
            self.add_program(program)
        (self.folder / "build/programs.mk").touch()

    def add_program(self, program):
        (self.folder / "build/run" / program).symlink_to(STUB)

    def use_profile(self, profile, imported):
        """Gives the site the profile, files of these keys of [import], and the profile's programs; returns its pipeline."""
        for key in imported:
            (self.folder / "data" / key).write_text("as other systems write it")
        text = (REPOSITORY / f"configs/sites/{SITE}.toml").read_text()
        tables = "".join(f'{key} = "{key}"\n' for key in sorted(imported))
        (self.folder / f"configs/sites/{SITE}.toml").write_text(f'profile = "{profile}"\n{text}[import]\n{tables}')
        pipeline = read_pipeline(str(self.folder / "configs"), profile, imported)
        for program in pipeline.programs():
            if not (self.folder / "build/run" / program).exists():  # another profile may have it
                self.add_program(program)
        return pipeline

    def change_of(self, options, profile="default"):
        """A value for SET that the first of these options does not have by default; None where there is no option."""
        path = next(self.folder.glob(f"configs/*/default/{options}.toml"))
        option = next((line for line in path.read_text().splitlines() if "=" in line and not line.startswith(("#", "seed"))), None)
        if option is None:
            return None
        key, value = (part.strip() for part in option.partition("#")[0].split("=", 1))
        other = {"true": "false", "false": "true", "[]": "'[\"other\"]'"}.get(value, '"other"' if value.startswith('"') else None)
        return f"{options}.{key}={other or (value.replace('[', '[1,').replace(' ', '') if value.startswith('[') else value + '1')}"

    def make(self, *arguments, **stub):
        """Runs make; stub: num_shards=3, num_tiles=2, fails=PROGRAM, changes=1 of the stub programs."""
        names = {"num_shards": "STUB_SHARDS", "num_tiles": "STUB_TILES", "fails": "STUB_FAILS", "changes": "STUB_CHANGES"}
        changes = {names[key]: str(value) for key, value in stub.items()}
        return subprocess.run(self.command(*arguments), cwd=self.folder, env=environment() | changes, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)  # fmt: skip

    def path(self, name):
        return self.folder / "maps" / SITE / name

    def ran(self):
        """Names of the rules that the last make ran, in order."""
        lines = [line.split() for line in self.path("logs/journal.txt").read_text().splitlines()]
        return [words[1] for words in lines if words[2] == "begin" and words[1] != "make"]

    def new_recording(self):
        """As if the recording had changed."""
        os.utime(self.folder / "data" / SITE / "synthesize.json")

    def hashes(self):
        """Relative path -> hash of every artifact; receipts hold the time of their run."""
        folders = [self.path(job.folder) for job in PIPELINE.jobs.values() if job.program and job.folder != "RECORDING"]
        files = [path for folder in folders for path in folder.rglob("*")
                 if path.is_file() and not path.name.startswith("receipt")]
        return {str(path.relative_to(self.folder)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


class StubTest(SiteTest):
    """Each test has a site of its own."""

    def setUp(self):
        self.work = self.site = StubSite().removed_after(self)
