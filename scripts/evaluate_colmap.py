#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""evaluate_colmap: compares COLMAP on the same pictures with nightmap and the truth.

Nightmap and COLMAP locate the same queries in maps of the same mapping frames (all of them, so that the
maps are comparable). COLMAP locates them in its own map and in a map of its points at nightmap's poses,
once with these poses adjusted together with the queries' and once with them held; and in each of these again
with COLMAP's default number of retrieved images. COLMAP's own map is built several times: the median run by
the number of queries near the reference counts; results.json lists every run. Each method is measured
against the truth, if there is one, and against the other methods. Writes results.json, summary.csv (a row per
method, reference and protocol), queries.csv (a row per query) and plots. With --page it puts its table
between `<!-- colmap_SITE:begin -->` and `<!-- colmap_SITE:end -->` of that file.
Exit codes: 0 written; 1 missing or inconsistent data; 2 wrong command line.
"""

import csv
import io

from nightmap_eval.artifacts import Frames, hash_if_there, to_json, write_atomic
from nightmap_eval.colmap.colmap_run import MAPPER_RUNS, METHODS, RUNS, read_receipt
from nightmap_eval.colmap.comparison import Located, Part, colmap_costs, errors_against, locate_by_models, nightmap_costs, summaries
from nightmap_eval.colmap.report_comparison import comparison_table, histogram_png, queries_png, recall_png
from nightmap_eval.figure_page import put_figure
from nightmap_eval.grid import read_grid
from nightmap_eval.query_errors import PROTOCOLS, read_located, refuse_mapped_queries
from nightmap_eval.trajectory import read_truth, read_tum
from nightmap_site.script_errors import DataError, paths_parser, run_main
from nightmap_site.site import Site

NEAR = "recall_5cm_5deg_percent"
SETTING = (
    "map images: all mapping frames of nightmap",
    "COLMAP's defaults except as listed here; on the CPU; intrinsics known and never refined",
    "matching of the map: {matching}",
    "matching of a query: {query_matching}; of the methods named _default: {default_matching}",
    f"colmap_mapper: the median of {len(MAPPER_RUNS)} runs with different seeds",
    "queries are registered, then bundle adjustment with the whole map; colmap_held: by the mapper, which "
    "triangulates and adjusts with them while nightmap's poses stay",
    "COLMAP's models are put on nightmap's map by a similarity over their map cameras",
)


class ComparedSite(Site):
    """A site with the data that all methods share: frames, queries, nightmap's result, the truth if it is known."""

    def __init__(self, site_dir):
        super().__init__(site_dir)
        trajectory, queries = self.needed("map_frame", "trajectory"), self.needed("localize", "queries")
        self.truth_paths = (self.ground_truth, self.query_ground_truth)
        self.made_of = (trajectory, queries, *self.truth_paths)
        self.trajectory = read_tum(trajectory)
        self.rows, self.query_times_ns, located = read_located(queries)
        self.nightmap = Located("nightmap", [Part(self.trajectory, located)])
        frames = Frames(self)
        self.map_times = {row["color_path"]: int(t) for row, t in zip(frames.rows, frames.times_ns)}
        self.query_times = {r["color_path"]: int(t) for r, t in zip(self.rows, self.query_times_ns)}
        refuse_mapped_queries(self.query_times, self.map_times)

    def truth(self):
        return Part(*map(read_truth, self.truth_paths)) if all(path.exists() for path in self.truth_paths) else None

    def locate_by_colmap(self, run):
        """None when the run is skipped because it would repeat another."""
        folder = self.evaluate_colmap / run.register_step
        receipt = read_receipt(folder)
        if "skipped" in receipt:
            return None
        if receipt["failed"]:
            return Located(run.method, failed=receipt["failed"])
        mapped = self.evaluate_colmap / run.map_step / "models"
        return locate_by_models(
            run.method, mapped, folder / "models", self.map_times, self.query_times, self.trajectory
        )

    def runs_of(self, method):
        """The runs of a method, each with its located queries."""
        runs = [(run, self.locate_by_colmap(run)) for run in RUNS if run.method == method]
        return [(run, located) for run, located in runs if located]


def near_percent(located, reference):
    """Share of the reference's queries that lie near the reference, each aligned on the map around it."""
    local = summaries(located, reference)["local"] if located.parts else {}
    return local.get(NEAR, 0.0)


def middle(runs, reference):
    """The median run (the worse of two) by queries near the reference, then by located queries."""
    order = sorted(runs, key=lambda run: (near_percent(run[1], reference), run[1].num_located()))
    return order[(len(runs) - 1) // 2]


def method_figures(site, method, references):
    """Figures of one method, and against every reference except itself."""
    num_located = method.num_located()
    return {
        "failed": method.failed, "models": method.models, "num_queries": len(site.rows), "num_located": num_located,
        "num_refused": len(site.rows) - num_located,
        "against": {name: summaries(method, reference) for name, reference in references.items() if name != method.name and method.parts},
    }  # fmt: skip


def run_figures(site, run, located, reference):
    """The entry of results.json for one of several runs."""
    costs = colmap_costs(site, run, len(site.rows))
    figures = {"map": run.map_step, "failed": located.failed, "num_located": located.num_located(),
               NEAR: near_percent(located, reference)}  # fmt: skip
    return figures | {key: costs[key] for key in ("map_time_s", "time_per_query_s")}


def errors_of(method, reference, protocol):
    """Errors against one reference: time -> cm, degrees. None of a method that cannot be aligned on it; its figures say why."""
    try:
        times, metres, degrees = errors_against(method, reference, protocol)
    except DataError:
        return {}
    return dict(zip(times, zip(100 * metres, degrees)))


def to_csv(header, rows):
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(rows)
    return text.getvalue()


def summary_csv(results):
    rows = [{"method": method, "reference": reference, "protocol": protocol} | values for method, figures in results["methods"].items()
            for reference, by_protocol in figures["against"].items() for protocol, values in by_protocol.items()]  # fmt: skip
    keys = dict.fromkeys(["method", "reference", "protocol", *(key for row in rows for key in row)])
    return to_csv(keys, [[row.get(key, "") for key in keys] for row in rows])


def queries_csv(site, methods, errors):
    """Whether each method located a query, and its errors against the truth where it is known."""
    header = ["query_idx", "color_path"]
    located = {m.name: {t for part in m.parts for t in part.queries.times_ns.tolist()} for m in methods}
    for method in methods:
        header += [f"{method.name}_status"]
        header += [f"{method.name}_{p}_error_{unit}" for p in errors for unit in ("cm", "deg")]
    rows = []
    for row, time_ns in zip(site.rows, site.query_times_ns.tolist()):
        cells = [row["query_idx"], row["color_path"]]
        for method in methods:
            cells.append("located" if time_ns in located[method.name] else "refused")
            for protocol in errors:
                found = errors[protocol][method.name].get(time_ns, (None, None))
                cells += ["" if value is None else f"{value:.6g}" for value in found]
        rows.append(cells)
    return to_csv(header, rows)


def write_plots(site, methods, errors, num_queries, folder):
    errors_cm = {
        protocol: {name: [cm for cm, _ in found.values()] for name, found in by_method.items() if found}
        for protocol, by_method in errors.items() if any(by_method.values())
    }  # fmt: skip
    plots = {}
    if errors_cm:
        plots["recall.png"] = recall_png(errors_cm, num_queries)
        plots["errors.png"] = histogram_png(errors_cm)
    grid = site.made("grid", "yaml")
    positions_m = {m.name: m.merged().queries.positions_m for m in methods if m.num_located()}
    plots["queries.png"] = queries_png(
        read_grid(grid) if grid else None, site.trajectory.positions_m, positions_m
    )
    for name, png in plots.items():
        write_atomic(folder / name, png)
    return list(plots)


def settings(site):
    matching = {
        name: receipt.get("matching", receipt.get("skipped", "failed"))
        for name, step in (("matching", "matches"), ("query_matching", "queries"), ("default_matching", "queries_default"))
        for receipt in [read_receipt(site.evaluate_colmap / step)]
    }  # fmt: skip
    return [line.format(**matching) for line in SETTING]


def main():
    arguments = paths_parser(__doc__, site_dir="maps/<site>", out="results.json to write; the other files go beside it",
                             page="?page that receives the table").parse_args()  # fmt: skip
    site = ComparedSite(arguments.site_dir)
    truth, folder = site.truth(), arguments.out.parent
    reference = truth or site.nightmap.merged()
    runs_of = {name: runs for name in METHODS if (runs := site.runs_of(name))}
    chosen = [middle(runs, reference) for runs in runs_of.values()]
    methods = [site.nightmap, *(located for _, located in chosen)]
    references = {"truth": truth} if truth else {}
    references |= {m.name: m.merged() for m in methods if m.num_located()}
    figures = {"nightmap": method_figures(site, site.nightmap, references) | nightmap_costs(site, len(site.rows))}
    for run, located in chosen:
        costs = colmap_costs(site, run, len(site.rows))
        figures[run.method] = method_figures(site, located, references) | costs
        if len(runs_of[run.method]) > 1:
            figures[run.method]["map"] = run.map_step
            figures[run.method]["runs"] = [run_figures(site, *each, reference) for each in runs_of[run.method]]
    matches = read_receipt(site.evaluate_colmap / "matches")
    results = {
        "format": "nightmap comparison with COLMAP", "version": 2, "site": site.name,
        "colmap": matches["colmap"], "threads": matches["threads"], "setting": settings(site),
        "num_map_frames": len(site.map_times), "has_ground_truth": truth is not None,
        "made_of": {str(path.relative_to(site.folder)): hash_if_there(path) for path in site.made_of},
        "methods": figures,
    }  # fmt: skip
    errors = {protocol: {method.name: errors_of(method, truth, protocol) for method in methods} for protocol in PROTOCOLS} if truth else {}
    num_queries = len(truth.queries) if truth else 0
    results["plots"] = write_plots(site, methods, errors, num_queries, folder)
    write_atomic(folder / "summary.csv", summary_csv(results))
    write_atomic(folder / "queries.csv", queries_csv(site, methods, errors))
    write_atomic(arguments.out, to_json(results))
    table = comparison_table(results)
    if arguments.page:
        put_figure(arguments.page, f"colmap_{results['site']}", table)
    print(table, end="")


if __name__ == "__main__":
    run_main(main)
