# SPDX-License-Identifier: Apache-2.0
"""Resolves all that the stages of a site read beside recordings: their configs, the copies of the site's config, and files whose
times are those of the last change of recordings and pictures.

A file is written only when its meaning changed, so a comment or a touch makes nothing stale. When a stage's receipts show that its
outputs were made with exactly the present config, the file gets a modification time before that run: trying a value and going back
costs nothing. A preview writes the same files to a folder of its own, with the times of the real ones where the meaning is the same,
so that `make -n`, `-q` and `why` can answer for any SET without touching the real configs.
"""

import os

from nightmap_make.changed_files import settle
from nightmap_make.config_values import canonical, effective_configs, makes_recordings
from nightmap_make.input_files import input_files
from nightmap_make.site_configs import check_site, settle_site, site_parts
from nightmap_make.run_receipts import made_with, receipts_in
from nightmap_site.toml_file import PipelineError


class ConfigRequest:
    """Sources of configs. The values of make's variables are text as the user gave it."""

    profile = "default"
    profile_from = "PROFILE"  # the variable or the file that names the profile
    imports = ()  # keys of [import] of the site
    seed = "0"
    set = query = camera = fov_deg = near = near_radius = turn = ""
    ends = []  # STAGE.KEY=VALUE of START and GOAL; they may contain spaces
    asks = "pictures"  # of which QUERY names files, or "scans"
    is_synthetic = False  # synthesize makes the recording
    programs = {}  # name of a config -> program, where the names may differ
    reads_recordings = True  # False: only the queries are looked at

    def __init__(self, configs, site, data, config_dir, work_dir, **more):
        """configs: a folder; site: the file of the site's config; config_dir: of the last run that was no preview; work_dir:
        where to write, config_dir or the folder of a preview. more: any of the above."""
        self.configs, self.site, self.data, self.config_dir, self.work_dir = configs, site, data, config_dir, work_dir
        for name, value in more.items():
            if not hasattr(self, name):
                raise TypeError(f"a request of configs has no {name}")
            setattr(self, name, value)

    def program_of(self, name):
        return self.programs.get(name, name)

    @property
    def site_name(self):
        return os.path.basename(self.site).removesuffix(".toml")


class ResolvedConfigs:
    """configs: name -> options; sources: name -> key -> file or variable that set it; sites: part -> text and tables that
    stages read of the site's config and QUERY. Reads and checks them, and writes nothing before settle. Raises PipelineError."""

    def __init__(self, request):
        _check_request(request)
        self._request = request
        self.configs, self.sources = effective_configs(request)
        check_site(request.site)
        self.sites = site_parts(request)
        for files in input_files(request, self.sites):
            files.check(request.site_name)

    def settle(self, folders):
        """Writes the changed files. folders: name of a config -> names of the folders of its jobs. Returns files whose times are those of
        the last change of `recordings` and `pictures`."""
        for name, config in self.configs.items():
            self._settle_config(name, config, folders.get(name, [name]))
        for part, (text, site) in self.sites.items():
            settle_site(part, text, site, self._request)
        return {files.name: files.settle(self._request) for files in input_files(self._request, self.sites)}

    def _settle_config(self, name, config, folders):
        request, file, program = self._request, f"{name}.toml", self._request.program_of(name)
        settle(os.path.join(request.config_dir, file), os.path.join(request.work_dir, file), canonical(config),
               changed_ns=lambda: made_with(self._receipts(program, folders), program, config))  # fmt: skip

    def _receipts(self, program, folders):
        """Those of a made-up recording lie with it, not with the map."""
        request = self._request
        if makes_recordings(program):
            path = os.path.join(request.data, request.site_name, "synthesize_receipt.json")
            return [path] if os.path.lexists(path) else []
        return receipts_in([os.path.join(os.path.dirname(request.config_dir), folder) for folder in folders])


def _check_request(request):
    if not (request.seed.isascii() and request.seed.isdigit() and len(request.seed) < 19):
        raise PipelineError(f"SEED={request.seed}: give a whole number")
    if not os.path.exists(request.site):
        folder = os.path.dirname(request.site)
        known = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
        names = ", ".join(name[:-5] for name in known if name.endswith(".toml"))
        raise PipelineError(f"no site config {request.site}; sites: {names}")
