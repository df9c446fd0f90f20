# SPDX-License-Identifier: Apache-2.0
"""Needs of jobs for recordings (`needs` of a job), compared with the [[sequence]] tables of the site's config."""

import re

from nightmap_site.toml_file import PipelineError


def _without_depth(sequences):
    """Indices of the recordings without depth where no recording has depth."""
    lacking = [i for i, sequence in enumerate(sequences) if sequence.get("depth") == "none"]
    return lacking if len(lacking) == len(sequences) else []


def _of_rigs(sequences):
    """Indices of the recordings that a rig made at once."""
    rigs = [sequence.get("rig") for sequence in sequences]
    return [i for i, rig in enumerate(rigs) if rig and rigs.count(rig) > 1]


# Need -> the recordings that fail it (indices), and what to say of them.
NEEDS = {
    "depth": (_without_depth, "no recording has depth (depth = \"none\"), which {jobs} need: record depth"),
    "one camera": (_of_rigs, "cameras of a rig record at once, which {jobs} cannot use: keep one [[sequence]] of each rig"),
}


def check_needs(jobs, sequences, site):
    """Raises PipelineError, with one line per need, when the recordings lack what jobs of the run need. site: path of the site's
    config, which has the tables `sequences`."""
    wrong = []
    for need, (failing, said) in NEEDS.items():
        names = [job.name for job in jobs if need in job.needs]
        indices = failing(sequences) if names else []
        if indices:
            with open(site, encoding="utf-8") as file:
                lines = [number for number, line in enumerate(file, 1) if re.match(r"\s*\[\[\s*sequence\s*\]\]", line)]
            places = ", ".join(f"{site}:{lines[i]}" for i in indices)
            wrong.append(f"{places}: {said.format(jobs=', '.join(names))}, or choose a profile without these jobs (docs/profiles.md)")
    if wrong:
        raise PipelineError("\n".join(wrong))
