#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""describe_pipeline: prints the declared pipeline as a drawing and a table in Markdown; --write puts them into ARCHITECTURE.md.

They go between the page's markers. A test compares the page with the declaration, configs/pipeline.toml.
Exit codes: 0 done; 1 the page has no markers; 2 wrong command line.
"""

import argparse
from pathlib import Path

from nightmap_eval.artifacts import put_between
from nightmap_site.declaration import overlays, read_toml
from nightmap_site.pipeline import read_pipeline
from nightmap_site.script_errors import run_main

CHECKOUT = Path(__file__).resolve().parents[1]
HEAD = ("| job | what it does | once per | reads | writes (U: the unit) |", "|---|---|---|---|---|")
BEGIN, END = "<!-- pipeline:begin -->", "<!-- pipeline:end -->"


def filled_by(reference):
    """Describes the source of a port in a few words."""
    if " else " in reference.declared:
        return reference.declared
    if reference.source:
        return f"*{reference.source}*"
    about = {"near": " of the tile and its neighbours", "previous and this": " of the shard and the one before",
             "all": " of all units"}  # fmt: skip
    return f"{reference.job}.{reference.output}{about.get(reference.units, '')}"


def _results_read(script):
    return f"results of {' and '.join(f'`make {goal}`' for goal in script.results_of)}" if script.results_of else "all results"


def row(job, also=()):
    """also: other variants of the job, which differ only in what they read."""
    given = ", ".join(dict.fromkeys(filled_by(reference) for variant in (job, *also) for reference in variant.inputs)) or "-"
    files = ", ".join(f"`{name.replace('{unit}', 'U')}`" for name in [*job.outputs.values(), *job.beside.values()])
    by = f", by `{job.program}`" if job.program not in (None, job.name) else ""
    return f"| `{job.name}`{by} | {job.purpose} | {job.unit} | {given if job.program else _results_read(job)} | {files} |"


def table(pipeline):
    return "\n".join([*HEAD, *(row(job) for job in pipeline.jobs.values())]) + "\n"


def describe(configs):
    pipeline = read_pipeline(configs)
    return f"{drawing(pipeline)}\n{table(pipeline)}" + profiles(Path(configs), pipeline)


def profiles(configs, default):
    """The jobs of all profiles that differ from the default ones, and from those of profiles that they include."""
    variants_of, left_out = {}, []  # the first: profile, job, program and purpose -> the jobs
    for overlay in sorted(configs.glob("*/pipeline.toml")):
        profile = overlay.parent.name
        for given in variants(overlay):
            pipeline = read_pipeline(str(configs), profile, given)
            included = [name for name in overlays(str(configs), profile, given) if name != profile]
            known = {row(job) for of in ("default", *included) for job in read_pipeline(str(configs), of, given).jobs.values()}
            left_out += [f"; `{profile}` includes `{name}`" for name in included]
            for job in pipeline.jobs.values():
                if row(job) not in known:
                    variants_of.setdefault((profile, job.name, job.program, job.purpose), []).append(job)
            of_included = read_pipeline(str(configs), included[-1], given).jobs if included else default.jobs
            out = ", ".join(f"`{name}`" for name in default.jobs if name in of_included and name not in pipeline.jobs)
            of = f"`{profile}`" + "".join(f" with `import.{key}`" for key in given if len(variants(overlay)) > 1)
            told = any(f"`{profile}`" in text and text.endswith(f" leaves out {out}") for text in left_out)
            left_out += [f"; {of} leaves out {out}"] if out and not told else []
    rows, fed = [], {}  # fed: profile -> jobs that only read something else
    for (profile, *_), same in variants_of.items():
        if is_fed_otherwise(same, default):
            fed.setdefault(profile, []).extend(same)
        else:
            rows.append(f"| `{profile}` {row(same[0], same[1:])}")
    rows += [row_of_fed(profile, jobs, default) for profile, jobs in fed.items()]
    rows.sort(key=lambda text: text.split("`")[1])
    head = (f"| profile {HEAD[0]}", f"|---{HEAD[1]}")
    return f"\nJobs that a profile adds or changes{''.join(left_out)}:\n\n" + "\n".join([*head, *rows]) + "\n"


def is_fed_otherwise(variants_of_job, default):
    """Whether these variants of a job differ from the default one in nothing but what they read."""
    known = default.jobs.get(variants_of_job[0].name)
    return known is not None and all((job.purpose, job.program, job.unit, job.outputs, job.beside) ==
                                     (known.purpose, known.program, known.unit, known.outputs, known.beside) for job in variants_of_job)  # fmt: skip


def row_of_fed(profile, jobs, default):
    """One row for the jobs of a profile that only read something else, with what they read instead or besides."""
    def given(job):
        return [filled_by(reference) for reference in job.inputs]
    names = ", ".join(dict.fromkeys(f"`{job.name}`" for job in jobs))
    new = dict.fromkeys(text for job in jobs for text in given(job) if text not in given(default.jobs[job.name]))
    return f"| `{profile}` | {names} | as without the profile, from other files | | {', '.join(new)} | |"


def variants(overlay):
    """The keys of [import] that change a profile: none and each, or all where it is no profile without them."""
    tables = [table for tables in read_toml(overlay).values() for table in (tables if isinstance(tables, list) else [tables])]
    given = sorted({table["given"] for table in tables if isinstance(table, dict) and "given" in table})
    has_own = any("given" not in table for table in tables)
    return [[], *([key] for key in given)] if has_own else [given]


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
    text = describe(str(CHECKOUT / "configs"))
    if arguments.write:
        put_between(CHECKOUT / "ARCHITECTURE.md", BEGIN, END, text)
    else:
        print(text, end="")


if __name__ == "__main__":
    run_main(main)
