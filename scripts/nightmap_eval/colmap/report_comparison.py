# SPDX-License-Identifier: Apache-2.0
"""Section of the report on the comparison with COLMAP, from the results of `make evaluate-colmap`."""

from pathlib import Path

from nightmap_eval import html
from nightmap_eval.artifacts import hash_if_there
from nightmap_eval.colmap.comparison_table import comparison_rows
from nightmap_site.checked_reading import read_json, using


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
