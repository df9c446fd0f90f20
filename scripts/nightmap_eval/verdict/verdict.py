# SPDX-License-Identifier: Apache-2.0
"""Checks of a map or a recording, and the verdict that follows from all of them."""

import math
from dataclasses import asdict, dataclass

from nightmap_site.checked_reading import NUMBER, read_object, using
from nightmap_site.job_results import StageResult

# The fields of verdict.json, see nightmap_site.checked_reading.check.
FORM = {"verdict": str, "checks": [{"name": str, "verdict": str, "?value": NUMBER, "unit": str, "limit": str, "reason": str, "advice": str}]}

GOOD, NOT_KNOWN, LOOK, REFUSE = VERDICTS = ("good", "not known", "look at this", "do not use")
SURVEY = {"num_frames": int, "num_frames_surveyed": int}


@dataclass(frozen=True)
class Check:
    """value in `unit` against `limit` (text), with the reason of the limit. advice: what to do, empty where the verdict is good.

    A check that could not run has no value: it is not known, which is shown. Where the map may be wrong for it, look at this."""

    name: str
    verdict: str
    value: float | None
    unit: str
    limit: str
    reason: str
    advice: str


def check(name, value, unit, good, reason, advice, usable=(-math.inf, math.inf)):
    """A value that is good within `good` (least, largest), and of no use outside `usable`."""
    verdict = GOOD if _within(value, good) else LOOK if _within(value, usable) else REFUSE
    least, most = (f"{limit:g}" for limit in good)
    limits = f"at most {most}" if good[0] == -math.inf else f"at least {least}" if good[1] == math.inf else f"{least} to {most}"
    return Check(name, verdict, value, unit, f"{limits} {unit}".rstrip(), reason, "" if verdict == GOOD else advice.format(value=value))


def unknown(name, reason, advice, matters=False):
    return Check(name, LOOK if matters else NOT_KNOWN, None, "", "not measured", reason, advice)


def escaped(text):
    """Text of a user, for an advice."""
    return text.replace("{", "{{").replace("}", "}}")


def _within(value, limits):
    return limits[0] <= value <= limits[1]  # a value that is no number is in no limits


def worst(checks):
    """The verdict of all checks; good without any, and where some are not known that do not matter."""
    found = max((item.verdict for item in checks), key=VERDICTS.index, default=GOOD)
    return GOOD if found == NOT_KNOWN else found


def checks_of(site, goals):
    """The checks of the site's jobs of these goals, the worst first."""
    checks = [item for job, module in site.sections("verdict") if job.goal in goals for item in module.checks(site)]
    return sorted(checks, key=lambda item: -VERDICTS.index(item.verdict))


def verdict_json(site, checks):
    return {"format": "nightmap verdict", "version": 1, "site": site.name, "verdict": worst(checks),
            "checks": [{key: value for key, value in asdict(item).items() if value is not None} for item in checks]}  # fmt: skip


def lines(checks):
    """Text for the terminal: the verdict, and what is not good with its advice."""
    yield f"verdict: {worst(checks)}"
    for item in checks:
        if item.verdict != GOOD:
            value = "not known" if item.value is None else f"{item.value:.3g} {item.unit}"
            yield f"  {item.verdict}: {item.name} {value} ({item.limit}): {item.advice}"


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
