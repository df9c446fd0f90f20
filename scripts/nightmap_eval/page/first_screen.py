# SPDX-License-Identifier: Apache-2.0
"""The screen that the page opens with: is the map good, where is it not, and what is there to do next; beside the plan."""

from nightmap_eval import html
from nightmap_eval.metrics_json import laser_figures, lead_figures
from nightmap_eval.page.usual import judged_errors
from nightmap_eval.report_plan import ERROR
from nightmap_eval.verdict.verdict import GOOD, LOOK, NOT_KNOWN, REFUSE

MAX_NAMED = 3
CLASSES = {GOOD: "good", LOOK: "look", REFUSE: "refuse"}


def first_screen(site, metrics, stages, failure, verdict, plan_parts):
    """verdict: content of a verdict.json, or None. plan_parts: see layers.plan_parts, or None."""
    plan, places, judged, rooms = plan_parts or (html.paragraph("There is no plan: no trajectory and no grid can be shown.", "note"), [], [], {})
    made = made_at(stages)
    title = f'<h1>{html.escape(site.name)}</h1><p class="note">{"made " + html.escape(made) if made else "nothing was made yet"}</p>'
    cards = [
        sentence(failure, verdict),
        card("Where to look", where(places, judged, failure, verdict)),
        card("What to do next", html.bullets(next_steps(site, failure, verdict))),
        card("In figures", facts_list(facts(metrics, stages, rooms))),
    ]
    return html.Raw(f'{title}<div class="first"><div class="said">{"".join(cards)}</div><div class="map">{plan}</div></div>')


def card(title, content):
    return html.Raw(f'<div class="card"><h2>{html.escape(title)}</h2>{html.escape(content)}</div>')


def made_at(stages):
    """Time of the newest result, in UTC; empty without any."""
    newest = max((receipt.get("start_time", "") for stage in stages for receipt in stage.receipts), default="")
    return newest.replace("T", " ").replace("Z", " UTC")


def sentence(failure, verdict):
    css_class, word, rest = _judgement(failure, verdict)
    return html.Raw(f'<div class="card verdict {css_class}"><strong>{html.escape(word)}</strong> {html.escape(rest)}</div>')


def _judgement(failure, verdict):
    """(class, word, sentence) of a failed run, else of the verdict."""
    if failure:
        jobs = ", ".join(job["job"] for job in failure["failed"]) or "a job"
        return "refuse", "The last run failed.", f"{jobs} did not end well; what is shown is of earlier runs, where there are any."
    if not verdict:
        return "", "No verdict yet.", "make map ends with one."
    found, checks = verdict["verdict"], verdict["checks"]
    if found == GOOD:
        measured = sum(item["verdict"] == GOOD for item in checks)
        unknown = sum(item["verdict"] == NOT_KNOWN for item in checks)
        return CLASSES[found], "Good.", f"All {measured} checks are within their limits{f'; {unknown} could not be measured' if unknown else ''}."
    failed = [item for item in checks if item["verdict"] == found]
    named = ", ".join(item["name"] for item in failed[:MAX_NAMED]) + (f" and {len(failed) - MAX_NAMED} more" if len(failed) > MAX_NAMED else "")
    word = {LOOK: "Look at this.", REFUSE: "Do not use this map."}[found]
    return CLASSES[found], word, f"{len(failed)} of {len(checks)} checks failed: {named}."


def where(places, judged, failure, verdict):
    if not places and (failure or not verdict):
        return html.paragraph("Places are judged when a run has ended well.")
    if not places:
        return html.paragraph(f"No place of the map stands out, by {', '.join(judged)}." if judged else "Nothing of this map is judged by place.")
    items = "".join(f'<li><a href="#plan" data-place="{place.x_m:.2f} {place.y_m:.2f} {place.floor}">at {place.x_m:.1f}, {place.y_m:.1f}'
                    f'{f" on floor {place.floor}" if place.floor else ""}</a>: {html.escape(place.said)}</li>' for place in places)  # fmt: skip
    return html.Raw(f'<ol class="plain">{items}</ol>')


def next_steps(site, failure, verdict):
    """Advice of what failed; of a good map, what it is for."""
    name = site.name
    if failure:
        for job in failure["failed"]:
            reasons = [found[1] for found in map(ERROR.fullmatch, job["log"]) if found]
            yield f"{job['job']}: {reasons[-1] if reasons else 'read the end of its log'} (the log is in the section The last run)"
        yield html.Raw(f"then run {command('make ' + ' '.join(failure['goals']) + ' SITE=' + name)} again: it makes only what is missing")
        return
    failed = [item for item in verdict["checks"] if item["advice"] and item["verdict"] != GOOD] if verdict else []
    worst = [item for item in failed if verdict["verdict"] == item["verdict"]] or failed
    for item in worst[:MAX_NAMED]:
        yield f"{item['name']}: {item['advice']}"
    if len(worst) > MAX_NAMED:
        yield html.Raw('the others stand in <a href="#checks">Checks</a>')
    if not verdict:
        yield command(f"make map SITE={name}")
    elif verdict["verdict"] != REFUSE:
        yield from _uses(site)


def _uses(site):
    if site.has("localize"):
        what = "scan.log" if site.pipeline.asks == "scans" else "photo.jpg"
        yield html.Raw(f"ask where a {'scan' if what == 'scan.log' else 'picture'} was taken: {command(f'make localize SITE={site.name} QUERY={what}')}")
    if site.has("plan"):
        yield html.Raw(f"plan a path, with a click on the plan for each end: {command(f'make plan SITE={site.name}')}")
    if any(job.goal == "export" for job in site.pipeline.jobs.values()):
        yield html.Raw(f"give the map to other programs: {command(f'make export SITE={site.name}')}")


def command(text):
    return html.Raw(f"<code>{html.escape(text)}</code>")


def seconds_text(seconds):
    if seconds is None:
        return "n/a"
    return f"{seconds:.1f} s" if seconds < 600 else f"{seconds / 60:.1f} min" if seconds < 7200 else f"{seconds / 3600:.1f} h"


def memory_text(size):
    return f"{size / 2**20:.0f} MiB" if size < 10_000 * 2**20 else f"{size / 2**30:.1f} GiB"


def total_s(stages):
    return sum(stage.wall_time_s() or 0.0 for stage in stages)


def facts(metrics, stages, rooms):
    """(name, text) of the result of the run and the accuracy of the map."""
    coverage, laser, trajectory = lead_figures(metrics, "coverage"), laser_figures(metrics), lead_figures(metrics, "trajectory")
    if coverage:
        yield "frames mapped", f"{coverage['num_frames_with_pose']} of {coverage['num_frames']} over {coverage['path_length_m']:.1f} m"
    if laser:
        yield "scans mapped", f"{laser['num_scans_with_pose']} of {laser['num_scans']} over {laser['path_length_m']:.1f} m"
    areas = [room.area_m2 for of_floor in rooms.values() for room in of_floor]
    if areas:
        yield "rooms", f"{len(areas)}, {sum(areas):.1f} m² of floor"
    if trajectory:
        yield "trajectory error", judged_errors(trajectory["se3"], (coverage or laser).get("path_length_m", 0.0))
    elif metrics:
        yield "accuracy", "unknown: no ground truth"
    if "queries" in metrics:
        queries, recall = metrics["queries"], metrics["queries"].get("recall_5cm_5deg_percent")
        yield "queries located", f"{queries['num_located']} of {queries['num_queries']}" + ("" if recall is None else f", {recall:.0f} % within 5 cm and 5°")
    if "loops" in metrics:
        yield "loops", f"{metrics['loops']['num_accepted']} accepted, {metrics['loops']['num_rejected']} rejected"
    if stages:
        memory = max((stage.peak_memory_bytes() or 0 for stage in stages), default=0)
        yield "computing", f"{seconds_text(total_s(stages))} of all jobs, {memory_text(memory)} at most"
    yield "items skipped", str(sum(len(stage.skipped()) for stage in stages))


def facts_list(rows):
    return html.Raw('<dl class="facts">' + "".join(f"<dt>{html.escape(name)}</dt><dd>{html.escape(text)}</dd>" for name, text in rows) + "</dl>")
