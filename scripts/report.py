#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""report: writes the report of a site as one self-contained HTML page.

The page opens with the verdict, the plan of the map, where to look and what to do next. Sections open below: the map in space, trajectory,
accuracy, queries, the comparison with COLMAP if there is one, checks, what changed since the run before (kept in runs.json beside the
page), time and memory of jobs, loops, skipped items, configs, files. A section whose job did not run says so. The page does not depend on
the clock. It is one file to open from disk or to send; only the links to results need it in its folder.
Exit codes: 0 written; 1 missing or inconsistent data; 2 wrong command line.
"""

import sys

try:
    from nightmap_eval import html
    from nightmap_eval.artifacts import write_atomic
    from nightmap_eval.camera.report_calibration import calibration_section
    from nightmap_eval.camera.report_loops import loop_pictures_section
    from nightmap_eval.camera.report_queries import query_section
    from nightmap_eval.colmap.report_comparison import comparison_section
    from nightmap_eval.metrics_json import read_metrics
    from nightmap_eval.page import changes
    from nightmap_eval.page.files import files_section
    from nightmap_eval.page.first_screen import first_screen
    from nightmap_eval.page.layers import plan_parts
    from nightmap_eval.page.scene import scene_section
    from nightmap_eval.report_map import map_sections, truth_in_map
    from nightmap_eval.report_run import checks_section, failure_section, read_failure, read_verdict, run_sections
    from nightmap_site.job_results import read_stages
    from nightmap_site.script_errors import DataError, paths_parser, run_main
    from nightmap_site.site import Site
except (ImportError, MemoryError) as error:  # a package that is missing, or a limit of memory
    sys.exit(f"error: the report cannot load its libraries: {error or 'out of memory'}; run make deps, or raise the limit of memory (ulimit -v)")


def make_report(site_dir, data, page_folder, of_what_is_whole=False):
    """Writes what changed beside the page, and returns the page, which begins with the failure of a failed run. of_what_is_whole: it says
    which files are damaged."""
    if not site_dir.is_dir():
        raise DataError(f"{site_dir}: no such folder; run `make map` first")
    site = Site(site_dir, data)
    failure = read_failure(site)
    failed = [failure_section(failure)] if failure else []
    try:
        first, sections = first_and_sections(site, data, failure, page_folder)
    except (DataError, OSError) as error:
        if not (failure or of_what_is_whole):
            raise
        first = first_screen(site, {}, [], failure, None, None)
        sections = [html.section("Results", html.paragraph(f"Some of the results cannot be shown: {error}", "failed"), is_open=True)]
    return html.page(f"{site.name}: nightmap", first, [*failed, *sections])


def first_and_sections(site, data, failure, page_folder):
    metrics, stages, verdict = read_metrics(site.made("evaluate", "metrics")), read_stages(site), read_verdict(site)
    runs = changes.next_runs(changes.read_runs(page_folder), changes.state_of(site, metrics, stages, verdict))
    sections = [
        scene_section(site, metrics, data),
        *map_sections(site, metrics),
        *([query_section(site, metrics, data)] if has_queries(site) else []),
        loop_pictures_section(site, data),
        calibration_section(site),
        comparison_section(site),
        *(section for _, module in site.sections("report") for section in module.sections(site, metrics)),
        checks_section(verdict) if verdict else None,
        changes.changes_section(runs),
        *run_sections(site, metrics, stages),
        files_section(site, page_folder),
    ]
    first = first_screen(site, metrics, stages, failure, verdict, plan_parts(site, truth_in_map(site, metrics)))
    changes.write_runs(page_folder, runs)
    return first, [section for section in sections if section is not None]


def has_queries(site):
    """A camera's map is made to locate pictures; a laser's map may have nothing to locate."""
    return site.has("localize") and (site.has_camera() or site.made("localize", "queries") is not None)


def main():
    parser = paths_parser(__doc__, site_dir="maps/<site>", out="index.html to write", data="?folder of the recordings, for query pictures")
    parser.add_argument("--of-what-is-whole", action="store_true", help="write a page even if some results are damaged")
    arguments = parser.parse_args()
    write_atomic(arguments.out, make_report(arguments.site_dir, arguments.data, arguments.out.parent, arguments.of_what_is_whole))


if __name__ == "__main__":
    run_main(main)
