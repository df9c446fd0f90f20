# SPDX-License-Identifier: Apache-2.0
"""What make was asked for: its goals and variables, the configs that follow from them, and the check of all that before
anything is written."""

import json
import os
from types import SimpleNamespace

import resolve_config
from nightmap_make import preflight
from nightmap_make.pipeline import PipelineError, read_pipeline

PREVIEW = "nq"  # flags of make that only look


class Refused(Exception):
    """A mistake in what was asked; nothing was run. Exit code 2."""


def make_flags(makeflags):
    """The single-letter flags that make was called with."""
    first = makeflags.split(" ")[0]
    return "" if first.startswith("-") or "=" in first else first


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


class Asked:
    """call: what resolve_config.py is called with; config: folder of the resolved configs."""

    def __init__(self, environment, goals):
        self.env, self.goals = environment, goals
        self.name, self.folder = environment["SITE"], f"{environment['MAPS']}/{environment['SITE']}"
        flags = make_flags(environment.get("MAKEFLAGS", ""))
        self.is_preview = "why" in goals or any(flag in flags for flag in PREVIEW)
        self.config = f"{self.folder}/.preview" if self.is_preview else f"{self.folder}/config"
        try:
            with resolve_config.plain_errors():
                self._check()
        except (resolve_config.ConfigError, PipelineError) as error:
            raise Refused(error) from None

    def _check(self):
        """Reads and checks what is asked for, and writes nothing."""
        env = self.env
        value = [f"plan.{end.lower()}={env[end]}" for end in ("START", "GOAL") if env.get(end)]
        self.call = SimpleNamespace(
            configs="configs", site=f"{env['SITES']}/{self.name}.toml", data=env["DATA"], profile="default",
            seed=env["SEED"], set=[env["SET"]], value=value, query=[env["QUERY"]] if env.get("QUERY") else [],
            camera=env.get("CAMERA") or None, fov_deg=env.get("FOV_DEG") or None, out=f"{self.folder}/config",
            preview=self.config if self.is_preview else None, synthetic=False,
            no_recordings=self._asks_pictures_only())  # fmt: skip
        self._read_site()
        self.configs, sources, self.sites = resolve_config.check(self.call)
        self.imports = self.sites["site"][1].get("import", {})
        self.pipeline = read_pipeline("configs", self.call.profile, self.imports)
        for key, path in self.imports.items():
            if not os.path.exists(f"{env['DATA']}/{path}"):
                raise PipelineError(f"{self.call.site}: [import] {key}: {env['DATA']}/{path} does not exist: give its path "
                                    "relative to DATA")  # fmt: skip
        if not self.is_preview and "status" not in self.goals:
            self._preflight(sources)

    def _asks_pictures_only(self):
        """To locate a picture in the map that there is no recording is looked at."""
        return bool(self.goals == ["localize"] and self.env.get("QUERY") and os.path.exists(f"{self.folder}/frames/shards.txt"))

    def _read_site(self):
        """The site's own words on its profile, before anything is looked at with it."""
        self.call.profile = self.env.get("PROFILE") or "default"
        if not os.path.exists(self.call.site):
            return
        site = resolve_config.load(self.call.site)
        if not self.env.get("PROFILE"):
            self.call.profile = site.get("profile", "default")
        self.call.synthetic = site.get("synthetic", False) is True

    def _preflight(self, sources):
        programs = [program for program in self.pipeline.programs() if program in self.configs]
        texts = {name: preflight.ConfigText(self.configs[name], resolve_config.canonical(self.configs[name]), sources[name])
                 for name in programs}  # fmt: skip
        preflight.check_configs(self.env["BUILD"], texts)
        preflight.check_clashes(self.pipeline.clashes, texts)

    def settle(self):
        """Writes the configs that changed. Returns files as old as the last change of `recordings` and `pictures`."""
        try:
            with resolve_config.plain_errors():
                return resolve_config.settle_all(self.configs, self.sites, self.call)
        except resolve_config.ConfigError as error:
            raise Refused(error) from None

    def check_disk(self, jobs, stamps):
        """Room for the frames that are new since the last list of them, by what jobs write per frame."""
        num_frames = self._num_recorded(stamps) - listed_frames(self.folder)
        kilobytes = sum(job.kB_per_frame for job in jobs if job.goal in self.goals or job.goal == "map")
        try:
            preflight.check_disk(self.folder, 1000 * kilobytes * num_frames, f"a map of {num_frames} more frames")
        except PipelineError as error:
            raise Refused(error) from None

    def _num_recorded(self, stamps):
        """Frames of the recordings, of which most have two files."""
        if self.call.synthetic:
            recorded = self.configs["synthesize"].get("num_frames", 0)
        else:
            recorded = num_recorded_files(stamps.get("recordings")) // 2
        most = self.configs["frames"].get("max_frames", 0)
        return min(recorded, most) if most > 0 else recorded
