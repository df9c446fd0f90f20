# SPDX-License-Identifier: Apache-2.0
"""A folder with configs, a site and its recording, where the modules that resolve configs work as make calls them."""

import contextlib
import tomllib

from folder_case import FolderTest
from nightmap_make.config_values import plain_errors
from nightmap_make.resolved_configs import ConfigRequest, ResolvedConfigs
from nightmap_site.toml_file import PipelineError

SITE = 'root = "office"\n[[sequence]]\nfolder = "."\n'
CONFIG = "maps/office/config"
PREVIEW = "maps/office/.preview"


class ConfigFolder(FolderTest):
    DEFAULTS = {"octree": 'resolution_m = 0.05\nnum_hits = 2\nmode = "ray"\n', "plan": 'seed = 7\nstart = ""\nfootprint_m = []\n'}

    def setUp(self):
        self.enterContext(contextlib.chdir(self.folder))
        self.write("configs/coarse/octree.toml", "")
        for stage, text in self.DEFAULTS.items():
            self.write(f"configs/default/{stage}.toml", text)
        self.write("configs/sites/office.toml", SITE)
        self.write("data/office/rgb/1.png", "pixels")

    def resolve(self, **changes):
        """Writes the configs; returns the files whose times are those of recordings and pictures."""
        with plain_errors():
            request = ConfigRequest(**{"configs": "configs", "site": "configs/sites/office.toml", "data": "data",
                                       "config_dir": CONFIG, "work_dir": CONFIG} | changes)  # fmt: skip
            return ResolvedConfigs(request).settle({})

    def refused(self, **changes):
        """The message of a refusal: one line."""
        with self.assertRaises(PipelineError) as caught:
            self.resolve(**changes)
        self.assertRegex(str(caught.exception), r"\A[^\n]+\Z")
        return str(caught.exception)

    def text(self, name, folder=CONFIG):
        return (self.folder / folder / name).read_text()

    def config(self, name, folder=CONFIG):
        return tomllib.loads(self.text(f"{name}.toml", folder))

    def time(self, name, folder=CONFIG):
        return (self.folder / folder / f"{name}.toml").stat().st_mtime_ns
