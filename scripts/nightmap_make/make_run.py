# SPDX-License-Identifier: Apache-2.0
"""One call of make for a site, from the check of the configs to the summary."""

import os
import sys
import time

import remove_leftovers
from nightmap_make import clock, slots, step_needs
from nightmap_make.changed_files import write, write_if_changed
from nightmap_make.child import Child
from nightmap_make.graph import Graph
from nightmap_make.journal import begin_run, end_run, journal_size, last_run
from nightmap_make.lock import SiteLock
from nightmap_make.programs import reason_to_build
from nightmap_make.request import make_flags
from nightmap_make.rules_file import RulesFile, Times
from nightmap_make.site_state import SiteState
from nightmap_site.script_errors import os_error_text, printable
from nightmap_site.toml_file import PipelineError


class MakeRun:
    def __init__(self, asked):
        self.asked, self.env, self.goals, self.folder = asked, asked.env, asked.goals, asked.folder
        self.is_preview = asked.is_preview
        self.work = f"{self.folder}/.preview" if self.is_preview else self.folder
        self.child, self.told = Child(), set()
        self.began_ns = time.time_ns()
        # A report of a failed run is always out of date.
        self.had_failure = os.path.exists(f"{self.folder}/logs/failure.json")

    def run(self):
        if self.is_preview:
            self.stamps = self.asked.settle()
            self._write_rules()
            self._preview_times()
            if self.asked.is_made_now:
                from nightmap_make import live_status
                return live_status.tell(self)
            return self._why() if "why" in self.goals else self._make(self.goals) or self._preview_build()
        lock = SiteLock(self.folder)
        try:
            self.stamps = self.asked.settle()
            return self._status() if "status" in self.goals else self._run_locked()
        finally:
            lock.release()

    def _run_locked(self):
        self._write_rules()
        self._mend_times()
        self.asked.check_disk(self.graph.jobs.values())
        begin_run(self.folder, self.goals)
        if self.had_failure:
            os.remove(f"{self.folder}/logs/failure.json")
        self.child.pass_signals_on()
        code = 2
        try:
            code = self._make_in_phases()
        finally:
            try:
                end_run(self.folder, code)
            except OSError as error:  # the failed jobs are still to be told
                print(f"nightmap: {os_error_text(error)}", file=sys.stderr)
        return self._finish(code)

    def _preview_build(self):
        """The exit code of -q and -n where no rule is out of date; -n says why programs would be built."""
        reason = reason_to_build(self.env["BUILD"], self.asked.programs)
        if reason and "n" in make_flags(self.env.get("MAKEFLAGS", "")):
            print(f"build the programs: {reason}")
            return 0
        return 1 if reason else 0

    def _make_in_phases(self):
        """Makes what goes first, lists of units above all, each with the rules of the lists known so far."""
        if not self._goals_without_jobs() and self._make(self.goals, "-q", quiet=True) == 0:  # most calls need no more
            self._remove_gone()
            return 0
        for job in list(self.asked.pipeline.jobs.values()):
            if not self.asked.pipeline.goes_first(job) or job.name not in self.graph.jobs or job.name not in self.asked.needed_jobs():
                continue
            before, size = self.site_state.lists[job.lists], journal_size(self.folder)
            code = self._make(self._goals_up_to(job))
            if code != 0:
                return code
            if journal_size(self.folder) == size:
                continue  # nothing was made
            self._write_rules()
            if self.site_state.lists[job.lists] != before:
                remove_leftovers.remove(self.folder, self.graph, job.lists)
        self._refuse_without_jobs()
        self._remove_gone()
        return self._make(self.goals)

    def _goals_up_to(self, job):
        """The outputs of a job, after those of the jobs before it make, so that they are made even if it fails. Lists come
        before all that depends on their units."""
        needed, names = self.asked.needed_jobs(), list(self.graph.jobs)
        before = [] if job.lists else [self.graph.jobs[name] for name in names[: names.index(job.name)] if name in needed]
        return [self.graph.path_of(one, next(iter(one.outputs))) for one in [*before, job] if one.unit == "site"]

    def _remove_gone(self):
        """Before the goals are made, so that evaluation and report do not read it."""
        folders = remove_leftovers.remove_gone(self.folder, self.graph)
        if folders:
            print(f"nightmap: site {self.asked.name} no longer has {', '.join(folders)}: its results are removed")

    def _goals_without_jobs(self):
        """(goal, job) where the site lacks what a job of the goal is for."""
        of_goals = [(goal, job) for goal, needed in zip(self.goals, self.asked.goals_of_jobs())
                    for job in self.asked.pipeline.jobs.values() if job.goal == needed]  # fmt: skip
        made = {goal for goal, job in of_goals if job.name in self.graph.jobs}
        return [(goal, job) for goal, job in of_goals if goal not in made]

    def _refuse_without_jobs(self):
        for goal, job in self._goals_without_jobs():
            if job.when == "queries" and self.asked.pipeline.asks == "scans":
                raise PipelineError(f"site {self.asked.name} has no scans to locate: name a log of them in QUERY, or give "
                              f"{self.asked.request.site} a [[query]]")
            if job.when == "queries":
                raise PipelineError(f"site {self.asked.name} has no query pictures: name some in QUERY, or give {self.asked.request.site} a "
                              "[[query]] or hold_out_every > 0")  # fmt: skip
            raise PipelineError(f"make {goal}: {job.name} is for sites with {job.when}, which {self.asked.request.site} has not")

    def _write_rules(self):
        self.site_state = self._look_at_site()
        goals = self.asked.pipeline.goals
        included = [f"{self.work}/again.mk", *(goals[goal].rules for goal in self.goals if goal in goals and goals[goal].rules)]
        self.graph = Graph(self.asked.pipeline, self.site_state, self.goals)
        slots.settle(self.graph)
        self.rules = RulesFile(self.graph, Times())
        files = {f"{self.work}/graph.mk": self.rules.text() + "".join(f"include {name}\n" for name in included),
                 f"{self.work}/again.mk": self._again()}  # fmt: skip
        if not self.is_preview:
            files |= dict(self.rules.list_files()) | dict(self.rules.name_files())
            for folder in {os.path.dirname(path) for rule in self.graph.rules for path in rule.output_paths()}:
                os.makedirs(folder, exist_ok=True)
            os.makedirs(f"{self.folder}/logs", exist_ok=True)
            if self.env.get("LAUNCH"):
                files[step_needs.path_of(self.folder)] = step_needs.text(self.graph, self.env["THREADS"])
        for path, text in files.items():
            write_if_changed(path, text)
        for line in [] if self.is_preview else self.rules.edited():
            self._tell_once(line)

    def _mend_times(self):
        """Moves times in the future to the present."""
        if not clock.in_future(self.rules):
            return
        moved, ahead_s = clock.moved_times(self.rules, self.began_ns)
        print(clock.warning(moved, ahead_s, self.folder), file=sys.stderr)
        for path, time_ns in moved.items():
            try:
                os.utime(path, ns=(time_ns, time_ns))
            except OSError as error:
                raise PipelineError(f"{path}: its time lies in the future and cannot be changed ({error.strerror}): touch it as its owner") from None
        self._write_rules()

    def _preview_times(self):
        """Lets rules be stale that are so once times in the future are moved, as _mend_times would."""
        if not clock.in_future(self.rules):
            return
        from nightmap_make import why
        moved, ahead_s = clock.moved_times(self.rules, self.began_ns)
        if "why" in self.goals:
            print(clock.warning(moved, ahead_s, self.folder), file=sys.stderr)
        self.rules.times.pretend(moved)
        staleness = why.Staleness(self.rules)
        stale = [" ".join(rule.output_paths()) for rule in staleness.reasons if rule not in staleness.uncertain]
        write(f"{self.work}/again.mk", self._again() + "".join(f"{paths}: FORCE\n" for paths in stale))

    def _again(self):
        return self.rules.again() + (self.rules.unmade() if self.is_preview else "")

    def _look_at_site(self):
        state = SiteState(self.asked.name, self.folder, self.env["DATA"], self.env["BUILD"], self.asked.config)
        state.is_synthetic, state.tables = self.asked.request.is_synthetic, self.asked.tables
        state.stamps = self.stamps
        state.read_lists(self.asked.pipeline, (lambda message: None) if self.is_preview else self._tell_once)
        return state

    def _tell_once(self, message):
        if message not in self.told:
            self.told.add(message)
            print(printable(message), file=sys.stderr)

    def _make(self, goals, *flags, quiet=False):
        """Runs make on the rules of the site; returns its exit code."""
        renew = ["-W", "scripts/report.py"] if self.had_failure else []
        command = ["make", "--no-print-directory", *flags, *renew, "-f", f"{self.work}/graph.mk", *goals]
        silence = [(os.POSIX_SPAWN_OPEN, fd, os.devnull, os.O_WRONLY, 0) for fd in (1, 2)] if quiet else []
        return self.child.run(command, self.env, file_actions=silence)

    # ---- after ----

    def _finish(self, code):
        """Prints the summary of a run; after a failed run also writes the report. (The imports are local because these
        modules are large, and a make with nothing to do needs none.)"""
        outcome = last_run(self.folder)
        if code != 0:
            from nightmap_make import after_failure
            after_failure.tell_of_failure(self, code, outcome)
            return code
        if outcome.codes:
            from nightmap_make import summary
            lines = [*summary.verdict_lines(self.folder, outcome), *summary.table(self.graph, self.folder, outcome)]
            print(printable("\n".join(lines)))
        if self.had_failure and "report" not in self.goals:
            from nightmap_make import after_failure
            after_failure.write_page(self, 0)
        for goal in self.goals:
            self._say(goal)
        return self._judge()

    def _judge(self):
        """Exit code 3 for a map that is not to be used, where the call asks for that."""
        if self.env.get("STRICT") != "1" or "verdict" not in self.graph.jobs or "map" not in {
                job.goal for job in map(self.graph.jobs.get, self.asked.needed_jobs()) if job}:  # fmt: skip
            return 0
        from nightmap_make import summary
        verdict = summary.verdict_of(self.graph.path_of(self.graph.jobs["verdict"], "verdict"))
        if verdict != "do not use":
            return 0
        print(f"nightmap: the verdict on the map of {self.asked.name} is: {verdict} (STRICT=1)", file=sys.stderr)
        return 3

    def _say(self, goal):
        if goal == "localize":
            import show_queries
            print(printable("\n".join(show_queries.lines(self.folder))))
        made = self.asked.pipeline.goals[goal].made if goal in self.asked.pipeline.goals else None
        if made:
            print(made.format(site=self.asked.name, folder=self.folder))

    def _status(self):
        """Prints how the last run ended, and writes the report of the existing results."""
        from nightmap_make import after_failure
        self._write_rules()
        outcome = last_run(self.folder)
        print(printable("\n".join(after_failure.status_lines(outcome))))
        if not after_failure.write_page(self, outcome.code):
            return 2
        self._say("report")
        return 0

    def _why(self):
        from nightmap_make import why
        print(printable("\n".join(why.lines(why.Staleness(self.rules), self.env["BUILD"], self.asked.programs))))
        return 0
