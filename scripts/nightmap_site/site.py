# SPDX-License-Identifier: Apache-2.0
"""A site's folder, maps/<site>/, and the pipeline that its last make used: where files are, and which jobs belong to it."""

import importlib.util
from pathlib import Path

from nightmap_site.pipeline import pipeline_of_site
from nightmap_site.receipts import WrittenFiles
from nightmap_site.script_errors import DataError

# The tree that make works in (its scripts may be a link), else the checkout.
CHECKOUT = Path(".") if Path("configs/pipeline.toml").is_file() else Path(__file__).resolve().parents[2]
CONFIGS = CHECKOUT / "configs"


class Site:
    """data: folder of the recordings, where the script was told of it."""

    def __init__(self, folder, data=None):
        self.folder, self.data = Path(folder), data
        self.name = self.folder.resolve().name
        self.pipeline = pipeline_of_site(CONFIGS, self.folder)
        self._written = WrittenFiles()
        # Folders and files of the site that no job declares as its output.
        self.config, self.logs = self.folder / "config", self.folder / "logs"
        self.evaluate_colmap = self.folder / "evaluate_colmap"
        self.ground_truth = self.folder / "frames" / "ground_truth.tum"
        self.query_ground_truth = self.folder / "queries" / "query_ground_truth.tum"
        self.robot_truth = self.folder / "frames" / "robot_truth.tum"
        self.relations = self.folder / "frames" / "relations.txt"

    def has(self, job):
        """Whether the pipeline of the site has a job; whether it ran is another question."""
        return job in self.pipeline.jobs

    def has_camera(self):
        """Whether the map is made of a camera's frames; else of laser scans alone, or of what a profile says."""
        return self.has("features")

    def folder_of(self, job):
        """The folder of a job's results, which several jobs may share. Only of jobs that the pipeline of the site has."""
        return self.folder / self.pipeline.jobs[job].folder

    def path(self, job, output, unit=None):
        """The file of a job's output, as declared; None when the site's pipeline has no such job or output. Raises DataError when
        the file is not what the job wrote."""
        name = self.pipeline.jobs[job].file_of(output) if self.has(job) else None
        if name is None:
            return None
        path = self.folder_of(job) / (name if unit is None else name.replace("{unit}", unit))
        self._written.require(path)
        return path

    def input(self, job, port):
        """The file that fills a port of a job of the site, from the one job that makes it."""
        reference = next(reference for reference in self.pipeline.jobs[job].inputs if reference.port == port)
        return self.path(reference.job, reference.output)

    def made(self, job, output, unit=None):
        """Like path; None also when the file is missing."""
        path = self.path(job, output, unit)
        return path if path is not None and path.exists() else None

    def needed(self, job, output):
        """Like path; raises DataError when the site's pipeline has no such job or output."""
        path = self.path(job, output)
        if path is None:
            raise DataError(f"{self.folder}: its pipeline has no {job}.{output}, which is needed here; "
                            "run make map with a profile that has it")  # fmt: skip
        return path

    def sections(self, kind):
        """(job, module) of each job that declares a module of its own for a "report" or an "evaluation"."""
        for job in self.pipeline.jobs.values():
            if job.sections.get(kind):
                yield job, _load(CHECKOUT / job.sections[kind], f"{job.name}_{kind}")


def _load(path, name):
    if not path.is_file():
        raise DataError(f"{path}: no such file; configs/pipeline.toml or the profile's names it as a section")
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
