#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""report: writes the report of a site as one self-contained HTML page.

The page shows what the run did and how good the map is: trajectory, floor plan with path, drive, queries,
accuracy, the comparison with COLMAP if there is one, time and memory per stage, loops, skipped items,
configs. A section whose stage did not run says so. The page does not depend on the clock.
Exit codes: 0 written; 1 missing or inconsistent data; 2 wrong command line.
"""

import sys

try:
    from nightmap_eval import html
    from nightmap_eval.artifacts import write_atomic
    from nightmap_eval.camera.report_queries import query_section
    from nightmap_eval.colmap.report_comparison import comparison_section
    from nightmap_eval.metrics_json import read_metrics
    from nightmap_eval.page.scene import scene_section
    from nightmap_eval.report_map import map_sections
    from nightmap_eval.report_run import failure_section, read_failure, run_sections, summary, verdict_parts
    from nightmap_site.job_results import read_stages
    from nightmap_site.script_errors import DataError, paths_parser, run_main
    from nightmap_site.site import Site
except (ImportError, MemoryError) as error:  # a package that is missing, or a limit of memory
    sys.exit(f"error: the report cannot load its libraries: {error or 'out of memory'}; run make deps, or raise the limit of memory (ulimit -v)")


def make_report(site_dir, data, of_what_is_whole=False):
    """Returns the page, which begins with the failure of a failed run. of_what_is_whole: it says which files are damaged."""
    if not site_dir.is_dir():
        raise DataError(f"{site_dir}: no such folder; run `make map` first")
    site = Site(site_dir, data)
    failure = read_failure(site)
    try:
        lead, sections = lead_and_sections(site, data)
    except (DataError, OSError) as error:
        if not (failure or of_what_is_whole):
            raise
        lead, sections = "Some of the results cannot be shown.", [html.section("Results", html.paragraph(str(error), "failed"))]
    return html.page(f"nightmap: {site.name}", lead, [*([failure_section(failure)] if failure else []), *sections])


def lead_and_sections(site, data):
    metrics = read_metrics(site.made("evaluate", "metrics"))
    stages, (verdict, about_verdict) = read_stages(site), verdict_parts(site)
    sections = [
        *about_verdict,
        *filter(None, [scene_section(site, metrics, data)]),
        *map_sections(site, metrics),
        *([query_section(site, metrics, data)] if has_queries(site) else []),
        *filter(None, [comparison_section(site)]),
        *(section for _, module in site.sections("report") for section in module.sections(site, metrics)),
        *run_sections(site, metrics, stages),
    ]
    return verdict + summary(metrics, stages), sections


def has_queries(site):
    """A camera's map is made to locate pictures; a laser's map may have nothing to locate."""
    return site.has("localize") and (site.has_camera() or site.made("localize", "queries") is not None)


def main():
    parser = paths_parser(__doc__, site_dir="maps/<site>", out="index.html to write", data="?folder of the recordings, for query pictures")
    parser.add_argument("--of-what-is-whole", action="store_true", help="write a page even if some results are damaged")
    arguments = parser.parse_args()
    write_atomic(arguments.out, make_report(arguments.site_dir, arguments.data, arguments.of_what_is_whole))


if __name__ == "__main__":
    run_main(main)
