# SPDX-License-Identifier: Apache-2.0
"""The request to make: its goals and variables, the configs that follow from them, and their check before anything is
written."""

import json
import os

from nightmap_make import preflight
from nightmap_make.changed_files import write_if_changed
from nightmap_make.config_values import canonical, plain_errors
from nightmap_make.imports import check_import_keys, check_imports
from nightmap_make.input_files import num_recorded_frames
from nightmap_make.lock import is_held
from nightmap_make.programs import build_programs, reason_to_build
from nightmap_make.resolved_configs import ConfigRequest, ResolvedConfigs
from nightmap_make.site_state import SiteState
from nightmap_site.needs import check_needs
from nightmap_site.pipeline import PROFILE_FILE, closure, profile_text, read_pipeline
from nightmap_site.toml_file import PipelineError, read_toml

ENOUGH_FRAMES = 100  # fewer say little about the next
MARGIN = 1.2
PREVIEW = "nq"  # flags of make that change nothing


def make_flags(makeflags):
    first = makeflags.split(" ")[0]
    return "" if first.startswith("-") or "=" in first else first


def listed_frames(site_dir):
    """Number of frames that the last run of frames listed; 0 when unknown."""
    try:
        with open(f"{site_dir}/frames/report.json", encoding="utf-8") as file:
            return int(json.load(file)["num_frames"])
    except (OSError, ValueError, KeyError, TypeError):
        return 0


class Asked:
    """request: what the configs follow from; resolved: the configs; config: their folder."""

    def __init__(self, environment, goals):
        self.env, self.goals = environment, goals
        self.name, self.folder = environment["SITE"], f"{environment['MAPS']}/{environment['SITE']}"
        flags = make_flags(environment.get("MAKEFLAGS", ""))
        self.is_made_now = "status" in goals and is_held(self.folder)
        self.is_preview = "why" in goals or self.is_made_now or any(flag in flags for flag in PREVIEW)
        self.config = f"{self.folder}/.preview" if self.is_preview else f"{self.folder}/config"
        with plain_errors():
            self._check()

    def _check(self):
        """Reads and checks the request; writes nothing."""
        env = self.env
        ends = [f"plan.{end.lower()}={env[end]}" for end in ("START", "GOAL") if env.get(end)]
        self.request = ConfigRequest(
            configs="configs", site=f"{env['SITES']}/{self.name}.toml", data=env["DATA"], config_dir=f"{self.folder}/config",
            work_dir=self.config, seed=env["SEED"], set=env["SET"], ends=ends, query=env.get("QUERY", ""), camera=env.get("CAMERA", ""),
            fov_deg=env.get("FOV_DEG", ""), near=env.get("NEAR", ""), near_radius=env.get("NEAR_RADIUS", ""), turn=env.get("TURN", ""),
            # Locating a picture or a scan in the existing map does not need the recordings.
            reads_recordings=not (self.goals == ["localize"] and env.get("QUERY") and os.path.exists(f"{self.folder}/frames/shards.txt")))  # fmt: skip
        self._choose_pipeline(self.request)
        self.resolved = ResolvedConfigs(self.request)
        self.configs, self.tables = self.resolved.configs, self.resolved.sites["site"][1]
        imports = self.tables.get("import", {})
        check_import_keys(self.request.site, imports, self.request.profile, bool(env.get("PROFILE")))
        check_imports(self.request.site, env["DATA"], imports)
        if "status" not in self.goals:
            self._preflight()

    def _choose_pipeline(self, request):
        """The profile, which the site's config may name, decides; all other checks and the build of the programs depend on it."""
        tables = read_toml(request.site) if os.path.exists(request.site) else {}
        request.profile = self.env.get("PROFILE") or tables.get("profile", "default")
        request.profile_from = request.site if "profile" in tables and not self.env.get("PROFILE") else "PROFILE"
        request.is_synthetic = tables.get("synthetic", False) is True
        imports = tables.get("import", {})  # of the right type if ResolvedConfigs finds no mistake
        request.imports = tuple(imports) if isinstance(imports, dict) else ()
        self.pipeline = read_pipeline("configs", str(request.profile), request.imports)
        request.asks, request.programs = self.pipeline.asks, self.pipeline.options
        jobs = [job for job in self.pipeline.jobs.values() if request.is_synthetic or job.when != "synthetic"]  # only made-up recordings are rendered
        self.programs = list(dict.fromkeys(job.program for job in jobs if job.program))

    def _preflight(self):
        self._check_options()
        programs = {name: program for name, program in self.pipeline.options.items() if name in self.configs and program in self.programs}
        if self.is_preview and not all(os.path.exists(f"{self.env['BUILD']}/run/{program}") for program in self.programs):
            return  # they are not built yet, and a preview builds nothing
        if not self.is_preview and reason_to_build(self.env["BUILD"], self.programs) and not build_programs(self.env, self.programs):
            raise PipelineError("the programs cannot be built: the first error is above")
        texts = {name: preflight.ConfigText(programs[name], self.configs[name], canonical(self.configs[name]), self.resolved.sources[name],
                                            *self._inputs(name)) for name in programs}  # fmt: skip
        preflight.check(self.env["BUILD"], texts, self.pipeline.clashes, self.is_preview)
        self._check_goals()
        self._check_needs()

    def _check_options(self):
        """Options of another name than their program have a file of defaults like any program's."""
        for job in self.pipeline.jobs.values():
            if job.options != job.program and job.options not in self.configs:
                raise PipelineError(f"{job.where('options')}: there is no configs/{self.request.profile}/default/{job.options}.toml: copy "
                                    f"the default options of {job.program} to it")  # fmt: skip

    def _check_goals(self):
        """A profile may leave out all jobs of a command."""
        made = {job.goal for job in self.pipeline.jobs.values()}
        for goal, of_jobs in zip(self.goals, self.goals_of_jobs(), strict=True):
            if of_jobs in self.pipeline.goals and of_jobs not in made:
                known = ", ".join(name for name in self.pipeline.goals if name in made)
                why = self.pipeline.goals[of_jobs].why_without
                raise PipelineError(f"{self.request.profile_from}: the profile {self.request.profile!r} has no job of `make {goal}`"
                                    f"{f': {why}' if why else ''}; it has those of: {known}")

    def _check_needs(self):
        state = SiteState(self.name, self.folder, self.env["DATA"])
        state.is_synthetic, state.tables = self.request.is_synthetic, self.tables
        needed = self.needed_jobs()
        jobs = [job for job in self.pipeline.jobs.values() if job.name in needed and (job.when == "asked" or state.has(job.when))]
        check_needs(jobs, self.tables.get("sequence", []), self.request.site)

    def goals_of_jobs(self, of=None):
        """The goals whose jobs make the goals of this call, or others."""
        goals = self.pipeline.goals
        return [goals[goal].needs if goal in goals else goal for goal in of or self.goals]

    def needed_jobs(self, of=None):
        """Names of the jobs that the goals of this call need, or others; a goal may be a file of the site's folder."""
        goals = self.goals_of_jobs(of)
        folders = [goal.removeprefix(f"{self.folder}/").split("/")[0] for goal in goals if goal.startswith(f"{self.folder}/")]
        return closure(self.pipeline, goals, folders)

    def _inputs(self, options):
        """Port -> text that a job with these options reads there of the site's config and QUERY, and port -> path of a file of [import]."""
        inputs = [reference for job in self.pipeline.jobs.values() if job.options == options for reference in job.inputs]
        sites, imports = self.resolved.sites, self.tables.get("import", {})
        return ({reference.port: sites[reference.source][0] for reference in inputs if reference.source in sites},
                {reference.port: os.path.join(self.env["DATA"], imports[reference.output]) for reference in inputs
                 if reference.job == "import" and reference.output in imports})  # fmt: skip

    def settle(self):
        """Writes the configs that changed. Returns files as old as the last change of `recordings` and `pictures`."""
        with plain_errors():
            folders = {name: sorted({job.folder for job in self.pipeline.jobs.values() if job.options == name})
                       for name in self.pipeline.options}  # fmt: skip
            stamps = self.resolved.settle(folders)
            if not self.is_preview:
                write_if_changed(f"{self.folder}/{PROFILE_FILE}", profile_text(self.request.profile, self.tables.get("import", {})))
            return stamps

    def check_disk(self, jobs):
        """Room for the frames added since the last list of frames."""
        num_frames = self._num_recorded() - listed_frames(self.folder)
        if num_frames <= 0:
            return
        needed = [job for job in jobs if job.goal in self.goals or job.goal == "map"]
        preflight.check_disk(self.folder, num_frames * self._bytes_per_frame(needed), f"a map of {num_frames} more frames")

    def _bytes_per_frame(self, jobs):
        """Bytes that the results of this site take per frame where there are some, else the declared largest size."""
        num_listed, folders = listed_frames(self.folder), {}
        for job in jobs:
            folders[job.folder] = folders.get(job.folder, 0) + 1000 * job.kB_per_frame
        for folder in folders if num_listed >= ENOUGH_FRAMES else ():
            folders[folder] = MARGIN * preflight.size_bytes(f"{self.folder}/{folder}") / num_listed or folders[folder]
        return sum(folders.values())

    def _num_recorded(self):
        if not self.request.reads_recordings:
            return 0
        made_up = self.configs.get("synthesize", {})
        recorded = (made_up.get("num_frames", 0) * made_up.get("render", True) if self.request.is_synthetic
                    else num_recorded_frames(self.tables, self.env["DATA"]))
        most = self.configs["frames"].get("max_frames", 0)
        return min(recorded, most) if most > 0 else recorded
