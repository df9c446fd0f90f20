# SPDX-License-Identifier: Apache-2.0
"""Runs the jobs that map a composed site as a whole, up to its queries, as the pipeline declares them and with its default configs."""

from checkout import CHECKOUT
from nightmap_site.pipeline import closure, read_pipeline

CONFIGS = CHECKOUT / "configs"
GOAL = "localize"
FROM_SOURCE = ("frames", "queries")  # jobs that read recordings; those of each shard are composed too


def jobs_of_whole():
    """The jobs of the default profile, in order."""
    pipeline = read_pipeline(str(CONFIGS))
    needed = closure(pipeline, [GOAL])
    return [job for job in pipeline.jobs.values() if job.name in needed and job.unit == "site" and job.name not in FROM_SOURCE]


def shards(folder, job, ending="h5"):
    return sorted((folder / job).glob(f"shard_*.{ending}"))


def first_visit(folder):
    """Odometry of the shards of the first visit; the second has as many."""
    odometry = shards(folder, "odometry")
    return odometry[: len(odometry) // 2]


def inputs_of(job, folder, source, data, profile):
    """Port -> file, or list of the files of all shards. `source`, `data`: the real site and its recordings, of which queries are."""
    declared, files = read_pipeline(str(CONFIGS), profile).jobs, {}
    asks = any(given.job == "queries" for given in job.inputs)
    for given in job.inputs:
        if given.source == "data":
            files[given.port] = data if asks else folder / "data"
            continue
        name = declared[given.job].file_of(given.output)
        if "{unit}" in name:
            files[given.port] = shards(folder, given.job, name.rpartition(".")[2])
        else:
            files[given.port] = (source if given.job == "queries" else folder) / given.job / name
    return files


def run(job, programs, folder, source, data, profile="default"):
    """Runs a job of a profile on a site; returns its StageResult. Raises DataError when its program fails."""
    for name in job.outputs.values():
        (folder / job.name / name).parent.mkdir(parents=True, exist_ok=True)
    [config] = CONFIGS.glob(f"*/default/{job.options}.toml")
    return programs.run(job.program, inputs_of(job, folder, source, data, profile), job.outputs, folder / job.name, config)
