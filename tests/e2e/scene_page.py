# SPDX-License-Identifier: Apache-2.0
"""The map in space on the page of the report, in a browser with WebGL in software, for its tests."""
import json
import pathlib
import sys
import unittest

import numpy as np

from driven_browser import DrivenPage
from workspace import Workspace

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))

from nightmap_eval.ply import read_ply  # noqa: E402

GOALS = ("map", "localize")
SCENE = "window.nightmapScene"


class ScenePage(DrivenPage):
    """A page with the scene, which has started."""

    def __init__(self, test, path, size_px=(1200, 900)):
        super().__init__(test, path, size_px)
        self.value("document.getElementById('scene').scrollIntoView()")
        self.value(f"{SCENE}.ready.then(() => true)")

    def hash(self):
        """Hash of the picture, once nothing moves any more."""
        self.value("new Promise(done => setTimeout(done, 300))")
        return self.value(f"{SCENE}.pictureHash()")

    def camera(self):
        return np.array(self.value(f"{SCENE}.camera"))

    def on_page(self, at):
        """A pixel of the canvas as one of the window."""
        left, top = self.value("(box => [box.x, box.y])(document.querySelector('#scene canvas').getBoundingClientRect())")
        return left + at[0], top + at[1]

    def middle(self):
        self.value("document.querySelector('#scene canvas').scrollIntoView({block: 'center'})")
        return self.middle_of("#scene canvas")

    def view(self, name):
        self.click(f"#scene [data-view={name}]")
        self.middle()

    def layer(self, name):
        [found] = [layer for layer in self.value(f"{SCENE}.layers") if layer["name"] == name]
        return found

    def texts(self, selector):
        return self.value(f"Array.from(document.querySelectorAll({json.dumps(selector)}), node => node.textContent)")


class SceneCase(unittest.TestCase):
    """The page of the small building."""

    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made(*GOALS).removed_after(cls)
        cls.work.output("report")
        cls.page = cls.work.path("report/index.html")
        cls.cloud_m, _ = read_ply(cls.work.path("point_cloud/cloud.ply"))

    def open(self, **more):
        return ScenePage(self, self.page, **more)
