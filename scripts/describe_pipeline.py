#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""describe_pipeline: prints the declared pipeline as a drawing and a table in Markdown; --write puts them into ARCHITECTURE.md.

They go between the page's markers. A test compares the page with the declaration, configs/pipeline.toml.
Exit codes: 0 done; 1 the page has no markers; 2 wrong command line.
"""

import argparse
from pathlib import Path

from nightmap_eval.artifacts import put_between
from nightmap_eval.script_errors import run_main
from nightmap_make.pipeline import read_pipeline

CHECKOUT = Path(__file__).resolve().parents[1]
BEGIN, END = "<!-- pipeline:begin -->", "<!-- pipeline:end -->"


def filled_by(reference):
    """Describes the source of a port in a few words."""
    if reference.source:
        return f"*{reference.source}*"
    about = {"near": " of the tile and its neighbours", "previous and this": " of the shard and the one before"}
    return f"{reference.job}.{reference.output}{about.get(reference.units, '')}"


def row(job):
    given = ", ".join(dict.fromkeys(filled_by(reference) for reference in job.inputs)) or "-"
    files = ", ".join(f"`{name.replace('{unit}', 'U')}`" for name in [*job.outputs.values(), *job.beside.values()])
    return f"| `{job.name}` | {job.purpose} | {job.unit} | {given if job.program else 'all results'} | {files} |"


def table(pipeline):
    lines = ["| job | what it does | once per | reads | writes (U: the unit) |", "|---|---|---|---|---|"]
    return "\n".join(lines + [row(job) for job in pipeline.jobs.values()]) + "\n"


def describe(pipeline):
    return f"{drawing(pipeline)}\n{table(pipeline)}"


def feeds(pipeline):
    """job -> the jobs whose outputs it reads, without those that reach it through another one too."""
    sources, all_before = {}, {}
    for job in pipeline.jobs.values():
        read = [reference.job for reference in job.inputs if reference.job] + [name for name, _ in job.finds]
        read = [name for name in dict.fromkeys(read) if name in pipeline.jobs]
        further = set().union(*(all_before[name] for name in read))
        sources[job.name] = [name for name in read if name not in further]
        all_before[job.name] = further | set(read)
    return sources


def drawing(pipeline):
    """Which job follows which, as a Mermaid flow chart."""
    edges = [f"  {source} --> {name}" for name, sources in feeds(pipeline).items() for source in sources]
    return "\n".join(["```mermaid", "flowchart LR", *edges, "```"]) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="put the table into ARCHITECTURE.md")
    arguments = parser.parse_args()
    text = describe(read_pipeline(str(CHECKOUT / "configs")))
    if arguments.write:
        put_between(CHECKOUT / "ARCHITECTURE.md", BEGIN, END, text)
    else:
        print(text, end="")


if __name__ == "__main__":
    run_main(main)
