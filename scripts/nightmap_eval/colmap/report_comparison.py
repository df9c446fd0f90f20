# SPDX-License-Identifier: Apache-2.0
"""Section of the report on the comparison with COLMAP, from the results of `make evaluate-colmap`."""

from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from nightmap_eval import html
from nightmap_eval.artifacts import hash_if_there
from nightmap_eval.colmap.comparison import PHASES
from nightmap_eval.drawing import BLUE, GRAY, GREEN, ORANGE, RED, draw_grid, map_axes, to_png
from nightmap_eval.query_errors import PROTOCOLS, RECALL_THRESHOLDS, WRONG_CM
from nightmap_site.checked_reading import read_json, using

ERROR_ROWS = (
    ("median (cm)", "median_translation_error_cm", "{:.1f}"),
    ("median (deg)", "median_rotation_error_deg", "{:.2f}"),
    ("90 % (cm)", "p90_translation_error_cm", "{:.1f}"),
    ("90 % (deg)", "p90_rotation_error_deg", "{:.2f}"),
    *(
        (f"{cm} cm, {deg} deg (%)", f"recall_{cm}cm_{deg}deg_percent", "{:.0f}")
        for cm, deg in RECALL_THRESHOLDS
    ),
)
COLORS = {"nightmap": BLUE, "colmap_mapper": ORANGE, "colmap_triangulate": GREEN, "colmap_held": RED}
DEFAULT = "_default"  # with COLMAP's number of retrieved images: the same color, dashed
MARKERS = {"nightmap": "^", "colmap_mapper": "x", "colmap_triangulate": "+", "colmap_held": "1"}
BINS_CM = np.geomspace(0.1, 1000, 25)


def _error_tables(results):
    """Errors against the truth, or else against nightmap; tables against the other methods are folded."""
    references = [
        reference for reference in ("truth", *results["methods"])
        if any(reference in figures["against"] for figures in results["methods"].values())
    ] or ["truth"]  # fmt: skip
    tables = [html.table(("", *results["methods"]), comparison_rows(results, name)) for name in references]
    titles = [f"Errors against {name}" for name in references]
    failures = [
        html.paragraph(f"{method} against {name}, {protocol} alignment: {values['failed']}.", "failed")
        for method, figures in results["methods"].items()
        for name, by_protocol in figures["against"].items()
        for protocol, values in by_protocol.items() if "failed" in values
    ]  # fmt: skip
    return [html.paragraph(titles[0] + "."), tables[0], *failures, *map(html.folded, titles[1:], tables[1:])]


def _model_table(results):
    head = ("method", "model", "map frames", "RMSE to nightmap's map (cm)", "queries", "used")
    rows = [
        (name, model["model"], model["num_map_frames"], html.number(model.get("rmse_to_map_cm")),
         model["num_queries"], "yes" if model["fits"] else model["reason"])
        for name, figures in results["methods"].items() for model in figures["models"]
    ]  # fmt: skip
    return html.table(head, rows)


def _time_table(results):
    rows = [
        (name, kind, part, f"{seconds:.1f}")
        for name, figures in results["methods"].items()
        for kind in ("map", "query")
        for part, seconds in figures[f"{kind}_parts_s"].items()
    ]
    return html.folded("Time of each part", html.table(("method", "", "part", "s"), rows))


def comparison_section(site):
    """None when there is no comparison."""
    path, remedy = site.evaluate_colmap / "results.json", "delete the file and run make evaluate-colmap again"
    if not path.exists():
        return None
    results = read_json(path, remedy)
    with using(path, remedy):
        parts = [html.paragraph("; ".join([results["colmap"], *results["setting"]]) + ".", "note")]
        if any(hash_if_there(site.folder / name) != known for name, known in results["made_of"].items()):
            parts.append(html.paragraph(
                "The map, its queries or the truth changed after this comparison: run make evaluate-colmap again.", "failed"))  # fmt: skip
        parts += _error_tables(results)
        parts += [html.image((site.evaluate_colmap / Path(name).name).read_bytes(), name) for name in results["plots"]]
        return html.section("Comparison with COLMAP", *parts, _model_table(results), _time_table(results))


def _text(value, text_format):
    return "n/a" if value is None else text_format.format(value)


def _error(figures, reference, protocol, key):
    return figures["against"].get(reference, {}).get(protocol, {}).get(key)


def comparison_rows(results, reference="truth"):
    """Rows: a title and one text per method. Errors are relative to the reference."""
    methods = results["methods"].values()
    num_points = [f.get("num_points", sum(model["num_points"] for model in f["models"] if model["fits"]) or None) for f in methods]
    phases_s = [f["query_phases_s"] for f in methods]
    rows = [
        ("queries", *(str(f["num_queries"]) for f in methods)),
        ("located", *(f"failed: {f['failed']}" if f["failed"] else str(f["num_located"]) for f in methods)),
        ("located, per run", *(", ".join(str(run["num_located"]) for run in f.get("runs", ())) for f in methods)),
        ("refused", *(str(f["num_refused"]) for f in methods)),
        (f"wrong (more than {WRONG_CM} cm off)",
         *(_text(_error(f, reference, "global", "num_wrong"), "{}") for f in methods)),
        ("models, fitting models", *(f"{len(f['models'])}, {sum(m['fits'] for m in f['models'])}"
                                     if f["models"] else "" for f in methods)),
    ]  # fmt: skip
    for protocol in PROTOCOLS:
        for title, key, text_format in ERROR_ROWS:
            cells = [_text(_error(f, reference, protocol, key), text_format) for f in methods]
            rows.append((f"{protocol} {title}", *cells))
    rows += [
        ("map (s)", *(f"{f['map_time_s']:.0f}" for f in methods)),
        ("time per query (s)", *(f"{f['time_per_query_s']:.2f}" for f in methods)),
        *((f"{phase} per query (s)", *(s[phase] if isinstance(s[phase], str) else f"{s[phase]:.3f}" for s in phases_s)) for phase in PHASES),
        ("time per query (CPU s)", *(_text(f["cpu_time_per_query_s"], "{:.2f}") for f in methods)),
        ("points", *(_text(num, "{}") for num in num_points)),
        ("map size (MB)", *(f"{f['map_size_bytes'] / 1e6:.1f}" for f in methods)),
    ]
    return rows


def comparison_table(results):
    """Markdown; errors against the truth, or against nightmap without truth."""
    reference = "truth" if results["has_ground_truth"] else "nightmap"
    names = list(results["methods"])
    caption = (
        f"{results['site']}, {results['num_map_frames']} map frames, {results['colmap']}, "
        f"{results['threads']} threads; errors against {'the truth' if reference == 'truth' else reference}.\n\n"
    )
    lines = ["| | " + " | ".join(names) + " |", "|---|" + "---:|" * len(names)]
    lines += ["| " + " | ".join(row) + " |" for row in comparison_rows(results, reference)]
    return caption + "\n".join(lines) + "\n"


def _line(method):
    return {"color": COLORS[method.removesuffix(DEFAULT)], "ls": "--" if method.endswith(DEFAULT) else "-"}


def _panels(errors, size):
    """One plot per protocol; errors: protocol -> method -> errors in cm."""
    figure, all_axes = plt.subplots(1, len(errors), figsize=size, sharey=True, squeeze=False)
    for axes, protocol in zip(all_axes[0], errors):
        axes.set_xscale("log")
        axes.set_xlabel("position error (cm)")
        axes.set_title(f"{protocol} alignment", fontsize=11)
        axes.grid(alpha=0.3)
    return figure, all_axes[0]


def recall_png(errors, num_queries):
    """Share of all queries located within each error; a query without a pose never counts."""
    figure, panels = _panels(errors, (9.5, 3.6))
    for axes, by_method in zip(panels, errors.values()):
        for method, errors_cm in by_method.items():
            percent = 100 * np.searchsorted(np.sort(errors_cm), BINS_CM, side="right") / num_queries
            axes.plot(BINS_CM, percent, **_line(method), label=method)
        axes.set_ylim(0, 102)
    panels[0].set_ylabel("queries (%)")
    panels[0].legend(fontsize=9, loc="lower right")
    return to_png(figure)


def histogram_png(errors):
    figure, panels = _panels(errors, (9.5, 3.2))
    for axes, by_method in zip(panels, errors.values()):
        for method, errors_cm in by_method.items():
            inside = np.clip(errors_cm, BINS_CM[0], BINS_CM[-1])
            axes.hist(inside, BINS_CM, histtype="step", lw=1.6, **_line(method), label=method)
    panels[0].set_ylabel("queries")
    panels[0].legend(fontsize=9, loc="upper left")
    return to_png(figure)


def queries_png(grid, trajectory_m, positions_m):
    """Positions of the queries by each method, in nightmap's map; positions_m: method -> (n, 3)."""
    figure, axes = map_axes("Located queries from above, in nightmap's map")
    if grid is not None:
        draw_grid(axes, grid)
    axes.plot(trajectory_m[:, 0], trajectory_m[:, 1], color=GRAY, lw=0.8, label="map frames")
    for method, points_m in positions_m.items():
        axes.plot(points_m[:, 0], points_m[:, 1], MARKERS[method.removesuffix(DEFAULT)], ms=5 - 2 * method.endswith(DEFAULT),
                  color=COLORS[method.removesuffix(DEFAULT)], label=method)  # fmt: skip
    axes.legend(fontsize=9, loc="upper left", bbox_to_anchor=(1.01, 1))
    return to_png(figure)
