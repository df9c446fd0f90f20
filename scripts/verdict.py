#!/usr/bin/python3
# SPDX-License-Identifier: Apache-2.0
"""verdict: judges a recording or a map by figures that need no truth; writes verdict.json.

Each job that declares section.verdict has checks: a value, a limit with its reason, advice where the limit is passed. The
worst check is the verdict: good, look at this, do not use. The job whose folder --out lies in says whose checks count: `check`
asks those of the recording alone, and says what time and room a map takes; `verdict` asks those of the map too.
Exit codes: 0 written, whatever the verdict is; 1 missing or inconsistent data; 2 wrong command line.
"""

from nightmap_eval.artifacts import to_json, write_atomic
from nightmap_eval.verdict.verdict import checks_of, lines, map_needs, needs_line, verdict_json
from nightmap_site.script_errors import paths_parser, printable, run_main
from nightmap_site.site import Site


def main():
    arguments = paths_parser(__doc__, site_dir="maps/<site>", data="?folder of the recordings",
                             out="verdict.json to write, in the folder of a job").parse_args()  # fmt: skip
    site = Site(arguments.site_dir, arguments.data)
    job = site.pipeline.jobs[arguments.out.parent.name]
    checks, needs = checks_of(site, job.results_of), map_needs(site) if job.goal == "check" and site.has("survey") else None
    write_atomic(arguments.out, to_json(verdict_json(site, checks) | ({"needs": needs} if needs else {})))
    print(printable("\n".join([*lines(checks), *([needs_line(needs)] if needs else [])])))


if __name__ == "__main__":
    run_main(main)
