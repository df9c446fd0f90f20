# SPDX-License-Identifier: Apache-2.0
"""One call of make for a site, from the check of the configs to the summary."""

import json
import os
import signal
import sys
from types import SimpleNamespace

import remove_leftovers
import resolve_config
from nightmap_make import preflight
from nightmap_make.graph import Graph, closure
from nightmap_make.journal import begin_run, end_run, journal_size, last_run
from nightmap_make.lock import SiteLock
from nightmap_make.pipeline import PipelineError, read_pipeline
from nightmap_make.rules_file import RulesFile, Times, list_goal
from nightmap_make.site_state import SiteState

PREVIEW = "nq"
PHASES = ("shard", "query", "tile")  # what lists of these say decides which rules there are
COMPARISON = "evaluate-colmap"
# What a goal made, said at the end.
MADE = {"map": "map of {site}: {folder}", "localize": "located queries: {folder}/localize/queries.csv",
        "plan": "path: {folder}/plan/path.json", "drive": "drive: {folder}/drive/drive.json",
        "evaluate": "metrics: {folder}/evaluate/metrics.json", "report": "report: {folder}/report/index.html",
        COMPARISON: "comparison: {folder}/evaluate_colmap/results.json"}  # fmt: skip


def num_recorded_files(stamp):
    """Of the file that resolve_config.py writes: "N files HASH"."""
    if not stamp:
        return 0
    with open(stamp, encoding="utf-8") as file:
        return int(file.read().split()[0])


def listed_frames(site_dir):
    """How many frames the last run of frames listed; 0 when that is not known."""
    try:
        with open(f"{site_dir}/frames/report.json", encoding="utf-8") as file:
            return int(json.load(file)["num_frames"])
    except (OSError, ValueError, KeyError, TypeError):
        return 0


class Refused(Exception):
    """A mistake in what was asked; nothing was run. Exit code 2."""


def make_flags(makeflags):
    """The single-letter flags that make was called with."""
    first = makeflags.split(" ")[0]
    return "" if first.startswith("-") or "=" in first else first


class MakeRun:
    def __init__(self, environment, goals):
        self.env, self.goals = environment, goals
        self.name, self.folder = environment["SITE"], f"{environment['MAPS']}/{environment['SITE']}"
        flags = make_flags(environment.get("MAKEFLAGS", ""))
        self.is_preview = "why" in goals or any(flag in flags for flag in PREVIEW)
        self.work = f"{self.folder}/.preview" if self.is_preview else self.folder
        self.config = f"{self.folder}/.preview" if self.is_preview else f"{self.folder}/config"
        self.child, self.told = None, set()

    def run(self):
        try:
            with resolve_config.plain_errors():
                self._check()
        except (resolve_config.ConfigError, PipelineError) as error:
            raise Refused(error) from None
        if self.is_preview:
            self._settle()
            self._write_rules()
            return self._why() if "why" in self.goals else self._make(self.goals)
        lock = SiteLock(self.folder)
        try:
            return self._status() if "status" in self.goals else self._run_locked()
        finally:
            lock.release()

    # ---- before ----

    def _check(self):
        """Reads and checks what is asked for, and writes nothing."""
        env = self.env
        value = [f"plan.{end.lower()}={env[end]}" for end in ("START", "GOAL") if env.get(end)]
        self.asked = SimpleNamespace(
            configs="configs", site=f"{env['SITES']}/{self.name}.toml", data=env["DATA"], profile="default",
            seed=env["SEED"], set=[env["SET"]], value=value, query=[env["QUERY"]] if env.get("QUERY") else [],
            camera=env.get("CAMERA") or None, fov_deg=env.get("FOV_DEG") or None, out=f"{self.folder}/config",
            preview=self.config if self.is_preview else None, synthetic=False,
            no_recordings=self._asks_pictures_only())  # fmt: skip
        self._read_site()
        configs, sources, self.sites = resolve_config.check(self.asked)
        self.configs, (_, self.site) = configs, self.sites["site"]
        self.pipeline = read_pipeline("configs", self.asked.profile, self.site.get("import", {}))
        for key, path in self.site.get("import", {}).items():
            if not os.path.exists(f"{env['DATA']}/{path}"):
                raise PipelineError(f"{self.asked.site}: [import] {key}: {env['DATA']}/{path} does not exist: give its path "
                                    "relative to DATA")  # fmt: skip
        if not self.is_preview and "status" not in self.goals:
            self._preflight(sources)

    def _asks_pictures_only(self):
        """To locate a picture in the map that there is no recording is looked at."""
        return bool(self.goals == ["localize"] and self.env.get("QUERY") and os.path.exists(f"{self.folder}/frames/shards.txt"))

    def _read_site(self):
        """The site's own words on its profile, before anything is looked at with it."""
        self.asked.profile = self.env.get("PROFILE") or "default"
        if not os.path.exists(self.asked.site):
            return
        site = resolve_config.load(self.asked.site)
        if not self.env.get("PROFILE"):
            self.asked.profile = site.get("profile", "default")
        self.asked.synthetic = site.get("synthetic", False) is True

    def _preflight(self, sources):
        programs = [program for program in self.pipeline.programs() if program in self.configs]
        texts = {name: preflight.ConfigText(self.configs[name], resolve_config.canonical(self.configs[name]), sources[name])
                 for name in programs}  # fmt: skip
        preflight.check_configs(self.env["BUILD"], texts)
        preflight.check_clashes(self.pipeline.clashes, texts)

    # ---- the run ----

    def _run_locked(self):
        self._settle()
        self._write_rules()
        self._check_disk()
        begin_run(self.folder, self.goals)
        signal.signal(signal.SIGTERM, self._pass_on)
        signal.signal(signal.SIGHUP, self._pass_on)
        code = self._make_in_phases()
        end_run(self.folder, code)
        return self._finish(code)

    def _check_disk(self):
        """Room for the frames that are new since the last list of them, by what jobs write per frame."""
        num_frames = self._num_recorded() - listed_frames(self.folder)
        kilobytes = sum(job.kB_per_frame for job in self.graph.jobs.values() if job.goal in self.goals or job.goal == "map")
        try:
            preflight.check_disk(self.folder, 1000 * kilobytes * num_frames, f"a map of {num_frames} more frames")
        except PipelineError as error:
            raise Refused(error) from None

    def _num_recorded(self):
        """Frames of the recordings, of which most have two files."""
        if self.site_state.is_synthetic:
            recorded = self.configs["synthesize"].get("num_frames", 0)
        else:
            recorded = num_recorded_files(self.stamps.get("recordings")) // 2
        most = self.configs["frames"].get("max_frames", 0)
        return min(recorded, most) if most > 0 else recorded

    def _settle(self):
        try:
            with resolve_config.plain_errors():
                self.stamps = resolve_config.settle_all(self.configs, self.sites, self.asked)
        except resolve_config.ConfigError as error:
            raise Refused(error) from None

    def _make_in_phases(self):
        """The lists of units first, each with the rules of those that are known already."""
        for job in list(self.graph.pipeline.jobs.values()):
            if job.lists not in PHASES or job.name not in self.graph.jobs or not self._is_needed(job):
                continue
            before, size = self.site_state.lists, journal_size(self.folder)
            code = self._make([list_goal(job)])
            if code != 0:
                return code
            if journal_size(self.folder) == size:
                continue  # nothing was made
            self._write_rules()
            if job.lists == "shard" and self.site_state.lists["shard"] != before["shard"]:
                remove_leftovers.remove(self.folder, self.graph)
        self._refuse_without_queries()
        return self._make(self.goals)

    def _is_needed(self, job):
        """Whether a goal reads this list. (A goal that is a file of the site may be of any job.)"""
        if any(goal.startswith(f"{self.folder}/") for goal in self.goals):
            return True
        return job.name in closure(self.pipeline, [{COMPARISON: "localize"}.get(goal, goal) for goal in self.goals])

    def _refuse_without_queries(self):
        asked = {"localize", COMPARISON} & set(self.goals)
        if asked and "localize" not in self.graph.jobs:
            raise Refused(f"site {self.name} has no query pictures: name some in QUERY, or give {self.asked.site} a "
                          "[[query]] or hold_out_every > 0")  # fmt: skip

    def _write_rules(self):
        self.site_state = self._look_at_site()
        self.graph = Graph(self.pipeline, self.site_state, self.goals)
        self.rules = RulesFile(self.graph, Times())
        files = {f"{self.work}/graph.mk": self.rules.text() + self._included(), f"{self.work}/again.mk": self._again()}
        if not self.is_preview:
            files |= dict(self.rules.list_files()) | dict(self.rules.name_files())
            for folder in {os.path.dirname(path) for rule in self.graph.rules for path in rule.output_paths()}:
                os.makedirs(folder, exist_ok=True)
            os.makedirs(f"{self.folder}/logs", exist_ok=True)
        for path, text in files.items():
            if not resolve_config.has_text(path, text):
                os.makedirs(os.path.dirname(path), exist_ok=True)
                resolve_config.write(path, text)

    def _again(self):
        return self.rules.again() + (self.rules.unmade() if self.is_preview else "")

    def _included(self):
        names = [f"{self.work}/again.mk"]
        names += ["scripts/evaluate_colmap.mk"] if COMPARISON in self.goals else []
        return "".join(f"include {name}\n" for name in names)

    def _look_at_site(self):
        state = SiteState(self.name, self.folder, self.env["DATA"], self.env["BUILD"], self.config)
        state.is_synthetic, state.imports = self.asked.synthetic, self.site.get("import", {})
        state.stamps = self.stamps
        state.read_lists((lambda message: None) if self.is_preview else self._tell_once)
        return state

    def _tell_once(self, message):
        if message not in self.told:
            self.told.add(message)
            print(message, file=sys.stderr)

    def _make(self, goals):
        """Runs make on the rules of the site; its exit code."""
        command = ["make", "--no-print-directory", "-f", f"{self.work}/graph.mk", *goals]
        self.child = os.posix_spawnp(command[0], command, self.env)
        while True:
            try:
                _, status = os.waitpid(self.child, 0)
                return os.waitstatus_to_exitcode(status) & 0xff
            except KeyboardInterrupt:  # make got it too, and ends its jobs
                continue

    def _pass_on(self, number, _):
        if self.child:
            os.kill(self.child, number)

    # ---- after ----

    def _finish(self, code):
        """The summary of a run; after one that failed also the page. (These modules are large; a make that had
        nothing to do needs none.)"""
        outcome = last_run(self.folder)
        if code != 0:
            from nightmap_make import morning
            morning.tell_of_failure(self, code, outcome)
            return code
        if outcome.codes:
            from nightmap_make import summary
            print("\n".join(summary.table(self.graph, self.folder, outcome)))
        self._clear_failure()
        for goal in self.goals:
            self._say(goal)
        return 0

    def _clear_failure(self):
        """A page that told of a failed run is made anew."""
        if os.path.exists(f"{self.folder}/logs/failure.json"):
            os.remove(f"{self.folder}/logs/failure.json")
            if "report" not in self.goals:
                self._make(["report"])

    def _say(self, goal):
        if goal == "localize":
            import show_queries
            print("\n".join(show_queries.lines(self.folder)))
        if goal in MADE:
            print(MADE[goal].format(site=self.name, folder=self.folder))

    def _status(self):
        """How the last run ended, and the page of what there is."""
        from nightmap_make import morning
        self._settle()
        self._write_rules()
        outcome = last_run(self.folder)
        print("\n".join(morning.status_lines(outcome)))
        morning.write_page(self, outcome.code)
        print(MADE["report"].format(folder=self.folder))
        return 0

    def _why(self):
        from nightmap_make import why
        print("\n".join(why.lines(why.Staleness(self.rules), self.env["BUILD"])))
        return 0
