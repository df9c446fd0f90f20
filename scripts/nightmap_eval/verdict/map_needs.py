# SPDX-License-Identifier: Apache-2.0
"""Needs of a map of a recording on this machine, told by the time that the survey took of some of its frames."""

from nightmap_site.checked_reading import read_object, using
from nightmap_site.job_results import StageResult

SURVEY = {"num_frames": int, "num_frames_surveyed": int}


def map_needs(site):
    """num_frames, time_s and size_MB of a map; not_counted: jobs whose time is unknown. None when the survey was not timed."""
    path = site.path("survey", "report")
    report, wall_time_s = read_object(path, SURVEY), StageResult(site.folder_of("survey")).wall_time_s()
    with using(path):
        if wall_time_s is None or report["num_frames_surveyed"] <= 0:
            return None
        frame_s = wall_time_s / report["num_frames_surveyed"]
    jobs = [job for job in site.pipeline.jobs.values() if job.goal == "map" and not job.script and job.when != "synthetic"]
    surveys = sum(job.surveys_per_frame for job in jobs)
    unknown = sorted(job.name for job in jobs if not job.surveys_per_frame and job.unit in ("shard", "tile"))
    kB = {job.folder: 0 for job in jobs}
    for job in jobs:
        kB[job.folder] += job.kB_per_frame
    return {"num_frames": report["num_frames"], "time_s": round(frame_s * surveys * report["num_frames"], 1),
            "size_MB": round(sum(kB.values()) * report["num_frames"] / 1000), "not_counted": unknown}  # fmt: skip


def needs_line(needs):
    minutes = needs["time_s"] / 60
    time = f"{minutes:.0f} min" if minutes >= 2 else f"{needs['time_s']:.0f} s" if minutes < 1 else f"{minutes:.1f} min"
    besides = f" and the time of {', '.join(needs['not_counted'])}" if needs["not_counted"] else ""
    return f"a map of the {needs['num_frames']} frames takes about {time}{besides} here, and up to {needs['size_MB']} MB"
