# SPDX-License-Identifier: Apache-2.0
"""The map in space on the page of the report: picture, layers, views, measuring."""
import pathlib
import re
import shutil
import tempfile

import numpy as np

from driven_browser import DrivenPage
from scene_page import SCENE, SceneCase, ScenePage

PACKED_M = 1e-4  # of a point that the page has rounded


class SceneTest(SceneCase):
    def test_it_draws_the_map_and_asks_nobody_for_anything(self):
        page = self.open()
        self.assertGreater(page.value(f"{SCENE}.pixelsDrawn()"), 0.1)
        requested = page.value("performance.getEntriesByType('resource').map(entry => entry.name).filter(name => !name.startsWith('data:'))")
        self.assertEqual(requested, [])
        addresses = page.value("Array.from(document.querySelectorAll('[src], link'), node => node.src || node.href)")
        self.assertEqual([address for address in addresses if not address.startswith("data:")], [])

    def test_the_page_alone_in_another_folder_works(self):
        folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-e2e-"))
        self.addCleanup(shutil.rmtree, folder)
        shutil.copy(self.page, folder / "a page.html")
        page = ScenePage(self, folder / "a page.html")
        self.assertGreater(page.value(f"{SCENE}.pixelsDrawn()"), 0.1)

    def test_dragging_turns_and_keys_fly(self):
        page = self.open()
        x, y = page.middle()
        before, picture = page.camera(), page.hash()
        page.drag((x, y), (x + 150, y + 30))
        turned = page.camera()
        self.assertGreater(np.linalg.norm(turned - before), 0.5)
        self.assertNotEqual(page.hash(), picture)
        self.assertEqual(page.texts(".scene-place"), [])  # a drag is no click
        for key in ("w", "e", "ArrowUp"):
            before = page.camera()
            page.key(key)
            page.wait(f"Math.hypot(...{SCENE}.camera.map((metres, i) => metres - {before.tolist()}[i])) > 0.005")

    def test_views_and_the_way_of_the_robot(self):
        page = self.open()
        pictures = {page.hash()}
        for name in ("above", "side", "whole", "robot"):
            page.view(name)
            pictures.add(page.hash())
        self.assertEqual(len(pictures), 4)  # `whole` is the first
        slider = "document.querySelector('.scene-way input')"
        self.assertFalse(page.value(f"{slider}.parentElement.hidden"))
        page.value(f"{slider}.value = {slider}.max; {slider}.dispatchEvent(new Event('input'))")
        self.assertNotIn(page.hash(), pictures)
        way_m = np.loadtxt(self.work.path("map_frame/keyframes.tum"), ndmin=2)[:, 1:4]
        self.assertLess(np.linalg.norm(page.camera() - way_m[-1]), 1e-3)

    def test_every_layer_changes_the_picture(self):
        page = self.open()
        layers = page.value(f"{SCENE}.layers")
        self.assertLessEqual({"colors", "octree", "grid", "trajectory", "loops_rejected", "queries"}, {layer["name"] for layer in layers})
        page.click("#scene input[name=colors]")  # else it hides what is below it
        for name in [layer["name"] for layer in layers if layer["name"] != "colors"] + ["colors"]:
            with self.subTest(name):
                was_on, picture = page.layer(name)["on"], page.hash()
                page.click(f"#scene input[name={name}]")
                page.wait(f"{SCENE}.layers.some(layer => layer.name === '{name}' && layer.on !== {str(was_on).lower()} && layer.isLoaded)")
                self.assertNotEqual(page.hash(), picture)
        self.assertEqual(page.texts(".scene-said"), [""])

    def test_a_cut_leaves_the_lower_part(self):
        page = self.open()
        drawn = page.value(f"{SCENE}.pixelsDrawn()")
        page.value("(cut => { cut.value = 300; cut.dispatchEvent(new Event('input')); })(document.querySelector('.scene-cut input'))")
        self.assertLess(page.value(f"{SCENE}.pixelsDrawn()"), 0.9 * drawn)

    def floor_places(self):
        """Two places of the floor that are far from each other and seen from above."""
        columns = np.floor(self.cloud_m[:, :2] / 0.2).astype(int)
        tops = {}
        for cell, z in zip(map(tuple, columns), self.cloud_m[:, 2]):
            tops[cell] = max(z, tops.get(cell, z))
        free = np.array([cell for cell in tops if all(tops.get((cell[0] + i, cell[1] + j), 9) < 0.04 for i in (-1, 0, 1) for j in (-1, 0, 1))])
        along = free @ [1.0, 0.7]
        return [[*((free[row] + 0.5) * 0.2), 0.0] for row in (along.argmin(), along.argmax())]

    def test_clicks_give_places_on_the_surfaces_and_their_distance(self):
        page = self.open()
        page.view("above")
        for name in ("trajectory", "queries"):
            page.click(f"#scene input[name={name}]")
        page.middle()
        told_m = []
        for place_m in self.floor_places():
            at = page.on_page(page.value(f"{SCENE}.pixelOf({place_m})"))
            page.press(at)
            page.mouse("mouseReleased", at, "left")
            page.wait(f"document.querySelectorAll('.scene-place').length === {len(told_m) + 1}")
            told_m.append([float(word) for word in page.texts(".scene-place")[-1].split(", ")])
            self.assertLess(np.linalg.norm(self.cloud_m - told_m[-1], axis=1).min(), 1e-3)
            self.assertLess(np.linalg.norm(np.subtract(told_m[-1], place_m)), 0.15)
            self.assertLess(abs(told_m[-1][2]), 0.04)
        distance_m = float(re.match(r"A to B: ([\d.]+) m", page.texts(".scene-distance")[0])[1])
        self.assertAlmostEqual(distance_m, np.linalg.norm(np.subtract(*told_m)), delta=2e-3)
        self.assertGreater(distance_m, 1)
        names = "Array.from(document.querySelectorAll('.scene-names span:not([hidden])'), node => node.textContent)"
        page.wait(f"{names}.includes('{distance_m:.3f} m')")
        picture = page.hash()
        page.key("Escape")
        self.assertEqual(page.texts(".scene-place, .scene-distance"), [])
        self.assertNotIn("A", page.texts(".scene-names span"))
        self.assertNotEqual(page.hash(), picture)

    def test_a_picked_point_is_one_of_the_file(self):
        page = self.open()
        width, height = page.value("(canvas => [canvas.clientWidth, canvas.clientHeight])(document.querySelector('#scene canvas'))")
        places = [page.value(f"{SCENE}.pick({x * width}, {y * height})") for x in (0.4, 0.5, 0.6) for y in (0.4, 0.5, 0.6)]
        found = [place for place in places if place]
        self.assertGreater(len(found), 3)
        for place in found:
            self.assertLess(np.linalg.norm(self.cloud_m - place, axis=1).min(), PACKED_M)
        self.assertIsNone(page.value(f"{SCENE}.pick(2, 2)"))

    def test_a_narrow_window_shows_all_without_overflow(self):
        page = self.open(size_px=(500, 800))  # headless Chromium opens no narrower window
        page.call("Emulation.setDeviceMetricsOverride", width=390, height=800, deviceScaleFactor=2, mobile=True)
        page.wait("document.querySelector('#scene canvas').clientWidth < 390")
        self.assertLessEqual(page.value("document.querySelector('#scene').scrollWidth"), 390)
        self.assertLessEqual(page.value("document.querySelector('.scene-stage').getBoundingClientRect().right"), 390)
        self.assertGreater(page.value(f"{SCENE}.pixelsDrawn()"), 0.1)

    def test_nothing_below_moves_when_the_view_starts(self):
        page = DrivenPage(self, self.page)
        height = "document.getElementById('scene').offsetHeight"
        before = page.value(f"document.querySelector('.scene-layers input:disabled') ? {height} : null")
        page.value("document.getElementById('scene').scrollIntoView()")
        page.value("window.nightmapScene.ready.then(() => true)")
        self.assertGreater(page.value("document.querySelectorAll('.scene-layers input:enabled').length"), 3)
        self.assertIn(before, (page.value(height), None))  # none: the view had started when it was asked
        self.assertIn('name="trajectory" checked disabled>Trajectory</label>', self.page.read_text(encoding="utf-8"))

    def test_the_background_is_dark_where_pages_are(self):
        page = self.open()
        corner = "nightmapScene.view.pixels().slice(0, 3).reduce((sum, part) => sum + part)"
        self.assertGreater(page.value(corner), 600)
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        self.assertLess(page.value(corner), 120)

    def test_the_canvas_has_a_name_and_takes_the_focus_of_the_keyboard(self):
        page = self.open()
        self.assertIn("three dimensions", page.value("document.querySelector('#scene canvas').getAttribute('aria-label')"))
        self.assertIn("three dimensions", page.texts("#scene canvas")[0])
        page.value("document.querySelector('#scene [data-view=robot]').focus()")
        page.key("Tab")
        self.assertEqual(page.value("document.activeElement.tagName"), "CANVAS")
        self.assertNotEqual(page.value("getComputedStyle(document.querySelector('.scene-stage')).outlineStyle"), "none")

    def test_without_webgl_a_sentence_says_so(self):
        page = DrivenPage(self, self.page)
        page.call("Page.addScriptToEvaluateOnNewDocument", source="HTMLCanvasElement.prototype.getContext = () => null;")
        page.call("Page.reload")
        page.wait("document.readyState === 'complete' && document.getElementById('scene') !== null")
        page.value("document.getElementById('scene').scrollIntoView()")
        page.wait("document.querySelector('.scene-said').textContent.includes('hardware acceleration')")
