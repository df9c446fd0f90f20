# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on the run: a failed run, checks, jobs, loop closures, skipped items, configs."""

from collections import Counter

from nightmap_eval import html
from nightmap_eval.artifacts import read_csv
from nightmap_eval.metrics_json import lead_figures
from nightmap_eval.page.files import size_text
from nightmap_eval.page.first_screen import memory_text, seconds_text, total_s
from nightmap_eval.verdict.verdict import FORM, GOOD
from nightmap_site.checked_reading import read_object, read_text

MAX_ROWS = 200
FAILURE = {"goals": [str], "failed": [{"job": str, "log": [str]}], "out_of_date": [str], "num_out_of_date": int}


def run_sections(site, metrics, stages):
    return [
        stage_section(site, stages),
        *([loop_section(site)] if site.path("pose_graph", "loops_csv") else []),
        skipped_section(metrics, stages),
        config_section(site),
    ]


def disk_bytes(folder):
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def stage_section(site, stages):
    if not stages:
        return html.section("Time and memory", html.paragraph("No receipts and no reports.", "note"))
    head = ("job", "runs", "time", "peak memory", "disk", "figures")
    rows, disk = [], {stage.name: disk_bytes(site.folder / stage.name) for stage in stages}
    for stage in stages:
        memory, figures = stage.peak_memory_bytes(), ", ".join(f"{name} {html.number(value)}" for name, value in stage.figures().items())
        rows.append([stage.name, stage.num_runs, seconds_text(stage.wall_time_s()), "n/a" if memory is None else memory_text(memory),
                     size_text(disk[stage.name]), figures])  # fmt: skip
    rows.append(["all", sum(stage.num_runs for stage in stages), seconds_text(total_s(stages)), "", size_text(sum(disk.values())), ""])
    parts = [html.table(head, rows)]
    if any(receipt.get("build_type") == "Debug" for stage in stages for receipt in stage.receipts):
        parts.append(html.paragraph("These times come from a Debug build; they do not show the speed of nightmap.", "failed"))
    return html.section("Time and memory", *parts)


def skipped_section(metrics, stages):
    rows = [(stage.name, reason) for stage in stages for reason in stage.skipped()]
    table = html.table(("stage", "skipped"), rows[:MAX_ROWS])
    parts = [table if rows else html.paragraph("None.", "note")]
    for key, said in (("frames_without_pose", "have no pose."),
                      ("frames_bridged", "matched no other frame: their poses are guesses."),
                      ("frames_apart", "lie apart from the rest of the map: only guessed motion connects them.")):  # fmt: skip
        frames = lead_figures(metrics, "coverage").get(key, [])
        shown = ", ".join(map(str, frames[:MAX_ROWS])) + (" ..." if len(frames) > MAX_ROWS else "")
        parts += [html.paragraph(f"{len(frames)} frames ({shown}) {said}")] if frames else []
    return html.section("Skipped items", *parts)


def config_section(site):
    paths = sorted(site.config.glob("*.toml"))
    if not paths:
        return html.section("Configs", html.paragraph("No resolved configs.", "note"))
    folds = [html.folded(path.stem, html.preformatted(read_text(path))) for path in paths]
    return html.section("Configs", *folds)


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
    return html.section("The last run", *parts, is_open=True)


def read_verdict(site):
    """The verdict.json of the map, else that of the recording; None without both."""
    path = site.made("verdict", "verdict") or site.made("check", "verdict")
    return read_object(path, FORM) if path else None


def checks_section(verdict):
    """Checks that failed come first, with their advice; the others are folded."""
    header = ("check", "verdict", "value", "unit", "good", "reason of the limit")
    failed = [item for item in verdict["checks"] if item["verdict"] != GOOD]
    good = [item for item in verdict["checks"] if item["verdict"] == GOOD]
    advice = [html.paragraph(f"{item['name']}: {item['advice']}", "failed") for item in failed if item["advice"]]
    parts = [*advice, html.table(header, map(_check_row, failed))] if failed else []
    return html.section("Checks", *parts, html.folded(f"{len(good)} checks that are good", html.table(header, map(_check_row, good))))


def _check_row(item):
    return item["name"], item["verdict"], item.get("value", "not known"), item["unit"], item["limit"], item["reason"]


def loop_section(site):
    path = site.made("pose_graph", "loops_csv")
    if not path:
        return html.section("Loops", html.paragraph("The pose_graph stage did not run.", "note"))
    rows = read_csv(path, ("status", "reason"))
    if not rows:
        return html.section("Loops", html.paragraph("No loop was proposed.", "note"))
    counts = Counter((row["status"], row["reason"]) for row in rows)
    parts = [html.table(("status", "reason", "loops"), [(*key, counts[key]) for key in sorted(counts)])]
    shown = html.table(tuple(rows[0]), [list(row.values()) for row in rows[:MAX_ROWS]])
    title = f"Each loop (first {MAX_ROWS} of {len(rows)})" if len(rows) > MAX_ROWS else "Each loop"
    parts.append(html.folded(title, shown))
    return html.section("Loops", *parts)
