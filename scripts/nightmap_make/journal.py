# SPDX-License-Identifier: Apache-2.0
"""The events of the last run of make, logs/journal.txt, a line per event: TIME_S NAME begin | TIME_S NAME end CODE.
run_job.sh writes the lines of rules; NAME is `make` where a whole run begins and ends."""

import os
import time

from nightmap_make.changed_files import write
from nightmap_site.script_errors import writing

RUN = "make"


class Outcome:
    """codes: exit code of each rule that the last run began, in that order; None when the rule did not end.
    code: exit code of the whole run; None when it was killed or still runs. goals: the goals of the run. begun_s: when each rule
    began, and "make", the run."""

    def __init__(self):
        self.codes, self.code, self.goals, self.begun_s = {}, None, [], {}

    def failed(self):
        return {name: code for name, code in self.codes.items() if code != 0}


def journal_path(site_dir):
    return f"{site_dir}/logs/journal.txt"


def begin_run(site_dir, goals):
    """Begins the journal of a run and drops that of the run before; receipts and logs keep its results."""
    line = f"{time.time():.0f} {RUN} begin {' '.join(goals)}\n"
    write(journal_path(site_dir), line.encode("utf-8", "replace").decode())


def end_run(site_dir, code):
    with writing(journal_path(site_dir)), open(journal_path(site_dir), "a", encoding="utf-8") as file:
        file.write(f"{time.time():.0f} {RUN} end {code}\n")


def last_run(site_dir):
    outcome = Outcome()
    if not os.path.exists(journal_path(site_dir)):
        return outcome
    with open(journal_path(site_dir), encoding="utf-8", errors="replace") as file:
        for line in file:
            time_s, name, event, *rest = [*line.split(), "", "", ""]
            if event == "begin" and time_s.isdigit():
                outcome.begun_s[name] = int(time_s)
            code = int(rest[0]) if event == "end" and rest[0].isdigit() else None
            if name == RUN and event == "begin":
                outcome.goals = line.split()[3:]
            elif name == RUN:
                outcome.code = code
            elif name:
                outcome.codes[name] = code
    return outcome


def journal_size(site_dir):
    return os.path.getsize(journal_path(site_dir))
