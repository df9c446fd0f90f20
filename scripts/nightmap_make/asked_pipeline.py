# SPDX-License-Identifier: Apache-2.0
"""The pipeline that the variables of make ask for. It follows from the profile, which the site's config may name; all other
checks and the build of the programs depend on it."""

import os

from nightmap_make.config_values import load
from nightmap_site.pipeline import read_pipeline


class AskedPipeline:
    """profile_from: the variable or the file that names the profile. Raises ConfigError, PipelineError."""

    def __init__(self, env):
        self.site = f"{env['SITES']}/{env['SITE']}.toml"
        tables = load(self.site) if os.path.exists(self.site) else {}
        self.profile, self.profile_from = env.get("PROFILE") or "default", "PROFILE"
        if not env.get("PROFILE") and "profile" in tables:
            self.profile, self.profile_from = tables["profile"], self.site
        self.is_synthetic = tables.get("synthetic", False) is True
        imports = tables.get("import", {})  # of the right type if ResolvedConfigs finds no mistake
        self.imports = tuple(imports) if isinstance(imports, dict) else ()
        self.pipeline = read_pipeline("configs", str(self.profile), self.imports)

    def programs(self):
        """Names of the programs that jobs of the site run; only a made-up recording is rendered."""
        jobs = self.pipeline.jobs.values()
        return list(dict.fromkeys(job.program for job in jobs if job.program and (self.is_synthetic or job.when != "synthetic")))
