# SPDX-License-Identifier: Apache-2.0
"""Notes of the report beside an outdated path or drive: a failed run of plan or drive leaves the previous
result."""

import re
import tomllib

from nightmap_site.checked_reading import read_toml, using
from nightmap_site.receipts import Hashes, Receipt
from nightmap_site.script_errors import printable

# The line that run_job.sh adds to the log of a failed stage, and the stage's own error.
FAILED = re.compile(r"nightmap: \w+ failed, exit code (\d+)")
ERROR = re.compile(r"\S+ error \w+: (.*)")
ENDS = ("start", "goal")


def last_failure(site, stage):
    """The reason why the last run failed; None when it succeeded."""
    path = site.logs / f"{stage}.log"
    if not path.exists():
        return None
    lines = path.read_bytes().decode("utf-8", "replace").splitlines()
    failed = FAILED.fullmatch(lines[-1]) if lines else None
    if not failed:
        return None
    reasons = [found[1] for found in map(ERROR.fullmatch, lines) if found]
    return printable(reasons[-1] if reasons else f"exit code {failed[1]}, see {path.name}")


def other_ends(site, receipt):
    """START and GOAL of the present configs if the path has other ends; else None."""
    path = site.config / "plan.toml"
    if not path.exists():
        return None
    now = read_toml(path)
    with using(receipt.path):
        then = tomllib.loads(receipt.content.get("config", ""))
    asked = {name: now[name] for name in ENDS if now.get(name) and now[name] != then.get(name)}
    return ", ".join(f"{name} = {value}" for name, value in asked.items()) or None


def notes(site, stage, result):
    """Sentences on the results of the last runs of plan or drive; `result` is the word for a result."""
    path, failure, found = site.made(stage, "receipt"), last_failure(site, stage), []
    if failure:
        shown = f"the {result} shown here is of an earlier run" if path else f"there is no {result}"
        found.append(f"The last run of {stage} failed, {shown}: {failure}")
    if not path:
        return found
    receipt = Receipt(path)
    changed = [str(path.relative_to(site.folder) if path.is_relative_to(site.folder) else path.name)
               for path, _ in receipt.changed("inputs", Hashes())]  # fmt: skip
    if changed:
        found.append(f"The {result} is out of date: {', '.join(changed)} changed since. Run make {stage}.")
    ends = other_ends(site, receipt) if stage == "plan" else None
    if ends:
        found.append(f"The {result} was planned for other ends than those of the present configs ({ends}). Run make plan.")
    return found
