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
    """The page, which begins with the failure of a failed run; beside it writes what it compares the next with. of_what_is_whole: it says which
    files are damaged, as the page of a failed run does."""
    if not site_dir.is_dir():
        raise DataError(f"{site_dir}: no such folder; run `make map` first")
    site = Site(site_dir, data if data is not None and data.is_dir() else None)
    failure = read_failure(site)
    whole = Whole(failure is not None or of_what_is_whole)
    metrics, stages, verdict = (
        whole.part(lambda: read_metrics(site.made("evaluate", "metrics")), {}), whole.part(lambda: read_stages(site), []), whole.part(lambda: read_verdict(site)))
    sections = whole.part(lambda: sections_of(site, whole, metrics, stages, verdict), [])
    plan = whole.part(lambda: plan_parts(site, truth_in_map(site, metrics)))
    changed = whole.part(lambda: changes_since(site, metrics, stages, verdict, page_folder, is_kept=not whole.is_lenient))
    first = first_screen(site, metrics, stages, failure, verdict, plan)
    told = [failure_section(failure)] if failure else []
    return html.page(f"{site.name}: nightmap", first, [*told, *whole.sections(), *sections, *filter(None, [changed]), files_section(site, page_folder)])


class Whole:
    """Parts of the page that can be made. Where it is lenient, those that cannot be are told in a section; else the first is an error."""

    def __init__(self, is_lenient):
        self.is_lenient, self.errors = is_lenient, []

    def part(self, make, otherwise=None):
        try:
            return make()
        except (DataError, OSError) as error:
            if not self.is_lenient:
                raise
            self.errors += [str(error)] if str(error) not in self.errors else []
            return otherwise

    def sections(self):
        return [html.section("Damaged results", *(html.paragraph(error, "failed") for error in self.errors), is_open=True)] if self.errors else []


def sections_of(site, whole, metrics, stages, verdict):
    data = site.data
    makers = [
        lambda: [scene_section(site, metrics, data)],
        lambda: map_sections(site, metrics),
        lambda: [query_section(site, metrics, data)] if has_queries(site) else [],
        lambda: [loop_pictures_section(site, data)],
        lambda: [calibration_section(site)],
        lambda: [comparison_section(site)],
        *(lambda module=module: module.sections(site, metrics) for _, module in site.sections("report")),
        lambda: [checks_section(verdict) if verdict else None],
        lambda: run_sections(site, metrics, stages),
    ]
    made = [section for maker in makers for section in whole.part(lambda: list(maker()), [])]
    return [section for section in made if section is not None]


def changes_since(site, metrics, stages, verdict, page_folder, is_kept):
    """The section on what changed. is_kept: this state is what the next page compares with; that of a failed run is not."""
    if site.has("verdict") and not verdict:
        return None
    runs = changes.next_runs(changes.read_runs(page_folder), changes.state_of(site, metrics, stages, verdict))
    if is_kept:
        changes.write_runs(page_folder, runs)
    return changes.changes_section(runs)


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
