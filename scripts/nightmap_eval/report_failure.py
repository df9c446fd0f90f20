# SPDX-License-Identifier: Apache-2.0
"""The section of the report on a failed or killed run: failed jobs, the end of their logs, results out of date."""

from nightmap_eval import html
from nightmap_site.checked_reading import read_object

FAILURE = {"goals": [str], "failed": [{"job": str, "log": [str]}], "out_of_date": [str], "num_out_of_date": int}


def read_failure(site):
    """logs/failure.json; None when the last run succeeded."""
    path = site.logs / "failure.json"
    return read_object(path, FAILURE) if path.exists() else None


def failure_section(failure):
    parts = [html.paragraph(f"make {' '.join(failure['goals'])} failed or was killed. The sections below show the existing results.",
                            "failed")]  # fmt: skip
    for job in failure["failed"]:
        code = job.get("exit_code")
        ended = "was killed" if code is None else f"exit code {code}"
        parts.append(html.paragraph(f"{job['job']}: {ended}. The end of logs/{job['job']}.log:"))
        parts.append(html.preformatted("\n".join(job["log"])))
    stale = failure["out_of_date"]
    parts.append(html.paragraph(f"{failure['num_out_of_date']} runs of jobs are out of date or were never made:"))
    parts.append(html.preformatted("\n".join(stale)))
    return html.section("The last run", *parts)
