#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""describe_pipeline: prints the declared pipeline as a drawing and a table in Markdown; --write puts them into docs/pipeline.md.

They go between the page's markers. A test compares the page with the declarations, configs/*/pipeline.toml.
Exit codes: 0 done; 1 the page has no markers; 2 wrong command line.
"""

import argparse
from pathlib import Path

from nightmap_eval.artifacts import put_between
from nightmap_site.declaration import import_keys, profiles
from nightmap_site.pieces import DeclarationFile
from nightmap_site.pipeline import read_pipeline
from nightmap_site.script_errors import run_main

CHECKOUT = Path(__file__).resolve().parents[1]
HEAD = ("| job | what it does | once per | reads | writes (U: the unit) |", "|---|---|---|---|---|")
BEGIN, END = "<!-- pipeline:begin -->", "<!-- pipeline:end -->"


def filled_by(reference):
    if " else " in reference.declared:
        return reference.declared.replace(" by hash", "").replace(" if made", "").replace(" if any", "")
    if reference.source:
        return f"*{reference.source}*"
    about = {"near": " of the tile and its neighbours", "previous and this": " of the shard and the one before",
             "all": " of all units"}  # fmt: skip
    return f"{reference.job}.{reference.output}{about.get(reference.units, '')}"


def row(job, also=()):
    """also: other variants of the job, which differ only in what they read."""
    given = ", ".join(dict.fromkeys(filled_by(reference) for variant in (job, *also) for reference in variant.inputs)) or "-"
    files = ", ".join(f"`{name.replace('{unit}', 'U')}`" for name in [*job.outputs.values(), *job.beside.values()])
    if not job.program:
        given = f"results of {' and '.join(f'`make {goal}`' for goal in job.results_of)}" if job.results_of else "all results"
    by = f", by `{job.program}`" if job.program not in (None, job.name) else ""
    return f"| `{job.name}`{by} | {job.purpose} | {job.unit} | {given} | {files} |"


def describe(configs):
    pipeline = read_pipeline(configs)
    jobs = [row(job) for job in pipeline.jobs.values()]
    pieces = [f"| `{profile}` | {told(DeclarationFile(configs, profile).pieces)} |" for profile in profiles(configs)]
    return "\n".join([drawing(pipeline), *HEAD, *jobs, "", "The pieces of each profile:", "", "| profile | pieces |", "|---|---|", *pieces,
                      jobs_of_profiles(configs, pipeline)])  # fmt: skip


def told(pieces):
    def said(piece):
        if isinstance(piece, str):
            return f"`{piece}`"
        otherwise = f"else {told(piece['else'])}" if "else" in piece else ""
        given = f"with `import.{piece['given']}` {told(piece['pieces'])}" if "pieces" in piece else f"without `import.{piece['given']}`"
        return f"({given} {otherwise.removeprefix('' if 'pieces' in piece else 'else ')}".rstrip() + ")"
    return ", ".join(said(piece) for piece in pieces)


def jobs_of_profiles(configs, default):
    """The jobs of all profiles that differ from the default ones, and from those of profiles that they are made of."""
    variants_of = {}  # profile, job, program and purpose -> the jobs
    for profile in profiles(configs):
        for given in variants(configs, profile):
            others = [name for name in _folders(configs, profile, given) if name in profiles(configs) and name != profile]
            known = {row(job) for name in ("default", *others) for job in read_pipeline(configs, name, given).jobs.values()}
            for job in read_pipeline(configs, profile, given).jobs.values():
                if row(job) not in known:
                    variants_of.setdefault((profile, job.name, job.program, job.purpose), []).append(job)
    rows, fed = [], {}  # fed: profile -> jobs that only read something else
    for (profile, *_), same in variants_of.items():
        if is_fed_otherwise(same, default):
            fed.setdefault(profile, []).extend(same)
        else:
            rows.append(f"| `{profile}` {row(same[0], same[1:])}")
    rows += [row_of_fed(profile, jobs, default) for profile, jobs in fed.items()]
    rows.sort(key=lambda text: text.split("`")[1])
    head = (f"| profile {HEAD[0]}", f"|---{HEAD[1]}")
    return "\nJobs that a profile adds or changes:\n\n" + "\n".join([*head, *rows]) + "\n"


def _folders(configs, profile, given):
    return dict.fromkeys(piece.partition(".")[0] for piece in DeclarationFile(configs, profile).chosen(given))


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


def variants(configs, profile):
    """Keys of [import] that a site of the profile may have: none, and each."""
    return [[], *([key] for key in sorted(import_keys(configs, profile)))]


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
    edges = [f"  {source} --> {name}" for name, sources in feeds(pipeline).items() for source in sources]
    return "\n".join(["```mermaid", "flowchart LR", *edges, "```"]) + "\n"


def print_or_write(about, page, markers, text_of):
    """Prints the text, or with --write puts it between the markers of the page. about: the docstring of the script."""
    parser = argparse.ArgumentParser(description=about.splitlines()[0])
    parser.add_argument("--write", action="store_true", help=f"put it into docs/{page.name}")
    if parser.parse_args().write:
        put_between(page, *markers, text_of())
    else:
        print(text_of(), end="")


if __name__ == "__main__":
    run_main(lambda: print_or_write(__doc__, CHECKOUT / "docs/pipeline.md", (BEGIN, END), lambda: describe(str(CHECKOUT / "configs"))))
