# SPDX-License-Identifier: Apache-2.0
"""Sections of the report on the run: verdict, a failed run, summary line, stages, loop closures, skipped items, configs."""

from collections import Counter

from nightmap_eval import html
from nightmap_eval.artifacts import read_csv
from nightmap_eval.metrics_json import laser_figures, lead_figures
from nightmap_eval.verdict.verdict import FORM, GOOD
from nightmap_site.checked_reading import read_object, read_text

MAX_ROWS = 200
FAILURE = {"goals": [str], "failed": [{"job": str, "log": [str]}], "out_of_date": [str], "num_out_of_date": int}


def run_sections(site, metrics, stages):
    return [
        stage_section(stages),
        *([loop_section(site)] if site.path("pose_graph", "loops_csv") else []),
        skipped_section(metrics, stages),
        config_section(site),
    ]


def _time(seconds):
    if seconds is None:
        return "n/a"
    return f"{seconds:.1f} s" if seconds < 600 else f"{seconds / 60:.1f} min"


def _total_s(stages):
    return sum(stage.wall_time_s() or 0.0 for stage in stages)


def summary(metrics, stages):
    """One line: the result of the run and the accuracy of the map."""
    parts = []
    coverage = lead_figures(metrics, "coverage")
    if coverage:
        parts.append(f"{coverage['num_frames_with_pose']} of {coverage['num_frames']} frames mapped over {coverage['path_length_m']:.1f} m")
    laser = laser_figures(metrics)
    if laser:
        parts.append(f"{laser['num_scans_with_pose']} of {laser['num_scans']} scans mapped over {laser['path_length_m']:.1f} m")
    if stages:
        parts.append(f"{_time(_total_s(stages))} of stage time")
    trajectory = lead_figures(metrics, "trajectory")
    if trajectory:
        se3 = trajectory["se3"]
        parts.append(f"trajectory error {100 * se3['ate_rmse_m']:.1f} cm and {se3['rotation_rmse_deg']:.1f} deg RMSE")
    elif metrics:
        parts.append("no ground truth, accuracy unknown")
    if "queries" in metrics:
        queries, recall = metrics["queries"], metrics["queries"].get("recall_5cm_5deg_percent")
        parts.append(f"{queries['num_located']} of {queries['num_queries']} queries located"
                     + ("" if recall is None else f", {recall:.0f} % within 5 cm and 5 deg"))  # fmt: skip
    if "loops" in metrics:
        loops = metrics["loops"]
        parts.append(f"loops: {loops['num_accepted']} accepted, {loops['num_rejected']} rejected")
    num_skipped = sum(len(stage.skipped()) for stage in stages)
    parts.append(f"{num_skipped} items skipped")
    return "; ".join(parts) + "."


def stage_section(stages):
    if not stages:
        return html.section("Stages", html.paragraph("No receipts and no reports.", "note"))
    head = ("stage", "runs", "wall time", "peak memory", "figures")
    rows = []
    for stage in stages:
        memory, figures = stage.peak_memory_bytes(), ", ".join(f"{name} {html.number(value)}" for name, value in stage.figures().items())
        rows.append([stage.name, stage.num_runs, _time(stage.wall_time_s()), "n/a" if memory is None else f"{memory / 2**20:.0f} MiB", figures])
    rows.append(["all", sum(stage.num_runs for stage in stages), _time(_total_s(stages)), "", ""])
    parts = [html.table(head, rows)]
    if any(receipt.get("build_type") == "Debug" for stage in stages for receipt in stage.receipts):
        parts.append(html.paragraph("These times come from a Debug build; they do not show the speed of nightmap.", "failed"))
    return html.section("Stages", *parts)


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
    return html.section("The last run", *parts)


def verdict_parts(site):
    """The beginning of the page's first line, and sections, of verdict.json of the map, else that of the recording; nothing without both."""
    path = site.made("verdict", "verdict") or site.made("check", "verdict")
    if not path:
        return "", []
    verdict = read_object(path, FORM)
    failed = [item for item in verdict["checks"] if item["verdict"] != GOOD]
    advice = [html.paragraph(f"{item['name']}: {item['advice']}", "failed") for item in failed]
    rows = [(item["name"], item["verdict"], item.get("value", "not known"), item["unit"], item["limit"], item["reason"]) for item in verdict["checks"]]
    table = html.table(("check", "verdict", "value", "unit", "good", "reason of the limit"), rows)
    return f"Verdict: {verdict['verdict']}. ", [html.section(f"Verdict: {verdict['verdict']}", *advice, table)]


def loop_section(site):
    path = site.made("pose_graph", "loops_csv")
    if not path:
        return html.section("Loop closures", html.paragraph("The pose_graph stage did not run.", "note"))
    rows = read_csv(path, ("status", "reason"))
    if not rows:
        return html.section("Loop closures", html.paragraph("No loop was proposed.", "note"))
    counts = Counter((row["status"], row["reason"]) for row in rows)
    parts = [html.table(("status", "reason", "loops"), [(*key, counts[key]) for key in sorted(counts)])]
    shown = html.table(tuple(rows[0]), [list(row.values()) for row in rows[:MAX_ROWS]])
    title = f"Each loop (first {MAX_ROWS} of {len(rows)})" if len(rows) > MAX_ROWS else "Each loop"
    parts.append(html.folded(title, shown))
    return html.section("Loop closures", *parts)
