# SPDX-License-Identifier: Apache-2.0
"""The page of a site in a browser: its first screen, the plan that people click, phones and wide screens, contrast, the keyboard, and the
file alone in another folder."""
import json
import pathlib
import re
import shutil
import tempfile
import unittest

import numpy as np

from accuracy import FOLDER, make, real
from driven_browser import DrivenPage
from labels_test import use_labels
from scene_page import SCENE, ScenePage
from workspace import REPOSITORY, SITE, Workspace, said_by

WIDTHS_PX = (390, 1280, 1920)
FIRST_SCREEN_PX = 900
MIN_CONTRAST = 4.5  # of text, by WCAG 2
OVERFLOW = """(() => { for (const one of document.querySelectorAll("details")) one.open = true;
    return document.documentElement.scrollWidth - document.documentElement.clientWidth; })()"""
# Texts on the page with too little contrast: ratio of luminances by WCAG 2, against the nearest background that is not clear.
CONTRASTS = """(() => {
  const values = (color) => color.match(/[\\d.]+/g).map(Number);
  const channel = (c) => (c /= 255) <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4;
  const luminance = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
  const behind = (element) => { for (let at = element; at; at = at.parentElement) {
    const color = values(getComputedStyle(at).backgroundColor); if (color[3] === undefined || color[3] > 0.9) return color; } return [255, 255, 255]; };
  const bad = [];
  const walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (walk.nextNode()) {
    const element = walk.currentNode.parentElement;
    if (!walk.currentNode.textContent.trim() || element.closest("svg, script, style, option")) continue;
    const [a, b] = [luminance(values(getComputedStyle(element).color)), luminance(behind(element))];
    const ratio = (Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05);
    if (ratio < %s) bad.push(`${ratio.toFixed(2)}: ${walk.currentNode.textContent.slice(0, 60)}`);
  }
  return bad;
})()""" % MIN_CONTRAST


def bottom_of(page, selector):
    return page.value(f"document.querySelector({selector!r}).getBoundingClientRect().bottom")


class PlanView:
    """Where a place of the map is on the screen, from the plan's viewBox and box: the drawing is fitted in the middle."""

    def __init__(self, page):
        page.value("document.querySelector('.floor-map svg').scrollIntoView({block: 'center'})")
        self.x, self.y, width, height = map(float, page.value("document.querySelector('.floor-map svg').getAttribute('viewBox')").split())
        left, top, wide, high = page.value(
            "(() => { const box = document.querySelector('.floor-map svg').getBoundingClientRect(); return [box.x, box.y, box.width, box.height]; })()")
        self.scale = min(wide / width, high / height)
        self.left, self.top = left + (wide - self.scale * width) / 2, top + (high - self.scale * height) / 2
        self.middle_m = (self.x + width / 2, -(self.y + height / 2))

    def at(self, x_m, y_m):
        return self.left + self.scale * (x_m - self.x), self.top + self.scale * (-y_m - self.y)


class PageTest(unittest.TestCase):
    def check_page(self, path):
        """All that holds on the page of every site."""
        for width_px in WIDTHS_PX:
            page = DrivenPage(self, path, (width_px, FIRST_SCREEN_PX))
            page.call("Emulation.setDeviceMetricsOverride", width=width_px, height=FIRST_SCREEN_PX, deviceScaleFactor=1, mobile=False)
            with self.subTest(path=path.parent.parent.name, width_px=width_px):
                self.assertLess(bottom_of(page, ".verdict"), FIRST_SCREEN_PX)
                self.assertLess(bottom_of(page, ".said .card:nth-of-type(3)"), FIRST_SCREEN_PX)  # where to look, and what to do next
                self.assertLessEqual(page.value(OVERFLOW), 0)
        for scheme in ("light", "dark"):
            page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
            self.assertEqual(page.value(CONTRASTS), [], scheme)
        ids = page.value("[...document.querySelectorAll('[id]')].map((element) => element.id)")
        self.assertEqual(sorted(set(ids)), sorted(ids))
        self.check_layers(page)
        self.check_clicks(page)
        self.check_scene(path)

    def check_layers(self, page):
        """Each layer is on the plan exactly while its box is checked."""
        names = page.value("[...document.querySelectorAll('.floor-map .layers input')].map((box) => box.value)")
        self.assertTrue(names)
        for number, name in enumerate(names):
            of_layer = ("[...document.querySelectorAll('.floor-map g[data-layer]')].filter((layer) => layer.dataset.layer === "
                        f"document.querySelectorAll('.floor-map .layers input')[{number}].value)")  # fmt: skip
            self.assertGreater(page.value(f"{of_layer}.length"), 0, name)
            shown = f"{of_layer}.filter((layer) => layer.dataset.floor === '0').map((layer) => layer.getClientRects().length > 0)"
            if not page.value(shown):  # it has parts on other floors only
                continue
            box = f"document.querySelectorAll('.floor-map .layers input')[{number}]"
            before = page.value(f"{box}.checked")
            self.assertEqual(page.value(shown), [before], name)
            page.value(f"{box}.click()")
            self.assertEqual(page.value(shown), [not before], name)
            page.value(f"{box}.click()")

    def check_scene(self, path):
        """The map in space draws, and orbits when it is dragged."""
        page = ScenePage(self, path)
        middle, before, picture = page.middle(), page.camera(), page.hash()
        self.assertGreater(page.value(f"{SCENE}.pixelsDrawn()"), 0.02)
        page.drag(middle, (middle[0] + 150, middle[1] + 40))
        self.assertNotEqual(page.hash(), picture)
        self.assertGreater(np.linalg.norm(page.camera() - before), 0.1)

    def check_clicks(self, page):
        view = PlanView(page)
        (x, y), places = view.middle_m, []
        for dx, dy in ((-1.0, 0.5), (1.0, -0.25)):
            at = view.at(x + dx, y + dy)
            page.press(at)
            page.mouse("mouseReleased", at, "left")
            places.append((x + dx, y + dy))
        said = page.value("document.querySelector('.floor-map .readout').textContent")
        found = [float(value) for pair in re.findall(r'"(-?[\d.]+),(-?[\d.]+)"', said) for value in pair]
        self.assertEqual(len(found), 4, said)
        for value, expected in zip(found, [value for place in places for value in place]):
            self.assertAlmostEqual(value, expected, delta=1.5 / view.scale + 0.006)
        self.assertAlmostEqual(float(re.search(r"([\d.]+) m apart", said)[1]), (4 + 0.5625) ** 0.5, delta=4 / view.scale + 0.006)


class SmallSiteTest(PageTest):
    @classmethod
    def setUpClass(cls):
        cls.work = Workspace.made("map", "localize", "evaluate", "report").removed_after(cls)
        cls.path = cls.work.path("report/index.html")

    def page(self):
        return DrivenPage(self, self.path)

    def test_everything_holds_on_it_and_on_the_file_alone(self):
        self.check_page(self.path)
        folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-e2e-"))
        self.addCleanup(shutil.rmtree, folder)
        self.check_page(pathlib.Path(shutil.copy(self.path, folder / "mailed.html")))

    def test_a_failed_run_says_what_failed_and_what_to_do(self):
        work = self.work.copy().removed_after(self)
        work.output("map", "SET=octree.resolution_m=0.1", "LAUNCH=sh -c 'echo 10:00:00 error octree: no room in /a/long/path/$$(seq -s/ 60); exit 1'", code=2)
        path = work.path("report/index.html")
        self.check_page(path)
        said = DrivenPage(self, path).value("document.querySelector('.said').textContent")
        self.assertRegex(said, "The last run failed. octree_0_0 did not end well")
        self.assertIn("octree_0_0: no room in /a/long/path", said)
        self.assertIn(f"make map SITE={SITE}", said)

    def test_a_bad_map_says_why_and_what_to_do(self):
        work = self.work.copy().removed_after(self)
        verdict = json.loads(work.path("verdict/verdict.json").read_text())
        verdict["verdict"] = verdict["checks"][0]["verdict"] = "do not use"
        verdict["checks"][0] |= {"name": "depth of the camera", "advice": "record again, slower"}
        work.path("verdict/verdict.json").write_text(json.dumps(verdict))
        said_by(["/usr/bin/python3", REPOSITORY / "scripts/report.py", "--site-dir", work.path(""), "--out", work.path("report/index.html")], work.folder)
        self.check_page(work.path("report/index.html"))
        said = DrivenPage(self, work.path("report/index.html")).value("document.querySelector('.said').textContent")
        self.assertRegex(said, r"Do not use this map. 1 of \d+ checks failed: depth of the camera.")
        self.assertIn("depth of the camera: record again, slower", said)

    def test_links_lead_to_the_results(self):
        paths = set(re.findall(r'href="(\.\./[^"]+)"', self.path.read_text()))
        self.assertGreater(len(paths), 30)
        for path in paths:
            self.assertTrue((self.path.parent / path).is_file(), path)

    def test_the_plan_is_used_with_the_keyboard(self):
        page = self.page()
        for _ in range(60):  # Tab reaches it
            page.key("Tab")
            if page.value("document.activeElement === document.querySelector('.floor-map svg')"):
                break
        else:
            self.fail("Tab does not reach the plan")
        before = page.value("document.querySelector('.floor-map svg').getAttribute('viewBox')")
        page.key("ArrowRight")
        x, y, width, height = map(float, page.value("document.querySelector('.floor-map svg').getAttribute('viewBox')").split())
        self.assertAlmostEqual(x, float(before.split()[0]) + 0.1 * width, places=3)
        page.key("Enter")
        self.assertIn(f'START="{x + width / 2:.2f},{-(y + height / 2) + 0:.2f}"', page.value("document.querySelector('.floor-map .readout').textContent"))
        page.key("Escape")
        self.assertNotIn("START", page.value("document.querySelector('.floor-map .readout').textContent"))

    def test_the_plan_moves_and_zooms_around_the_pointer(self):
        page = self.page()
        view = PlanView(page)
        place = (view.middle_m[0] + 1, view.middle_m[1] - 0.5)
        page.click(".floor-map svg")  # gives it the focus
        page.mouse("mouseWheel", view.at(*place), deltaX=0, deltaY=-100)
        nearer = PlanView(page)
        self.assertGreater(nearer.scale, 1.2 * view.scale)
        for now, before in zip(nearer.at(*place), view.at(*place)):
            self.assertAlmostEqual(now, before, delta=1)
        page.drag(nearer.at(*place), [value - 50 for value in nearer.at(*place)])
        for now, before in zip(PlanView(page).at(*place), nearer.at(*place)):
            self.assertAlmostEqual(now, before - 50, delta=8)  # the first pixels are a click yet

    def test_a_place_to_look_at_is_shown(self):
        place = '<a href="#plan" data-place="1.00 0.50 0">at 1.0, 0.5</a>'
        path = self.work.path("report/place.html")
        path.write_text(re.sub("No place of the map stands out[^<]*", place, self.path.read_text()))
        self.assertIn(place, path.read_text())
        page = DrivenPage(self, path)
        page.click("[data-place]")
        for value, expected in zip(PlanView(page).middle_m, (1.0, 0.5)):
            self.assertAlmostEqual(value, expected, places=2)

    def test_sections_open_by_their_links(self):
        page = self.page()
        self.assertFalse(page.value("document.getElementById('files').open"))
        page.value("document.querySelector('nav a[href=\"#files\"]').click()")
        page.wait("document.getElementById('files').open")


class SitesTest(PageTest):
    """The page of a made-up building, a real office, a laser's map, a map of a ceiling, and one with labels."""

    def check(self, site, data):
        self.check_page(make(site, data, "map", "evaluate", "report") / "report/index.html")

    def test_demo(self):
        self.check("demo", FOLDER / "data")

    def test_two_floors(self):
        path = make("two_floors", FOLDER / "data", "map", "report") / "report/index.html"
        self.check_page(path)
        page = DrivenPage(self, path)
        page.value("(() => { const floors = document.querySelector('.floor-map select'); floors.value = '1'; floors.dispatchEvent(new Event('change')); })()")
        shown = page.value("[...document.querySelectorAll('.floor-map g[data-layer]')].filter((layer) => layer.getClientRects().length)"
                           ".map((layer) => layer.dataset.floor)")  # fmt: skip
        self.assertEqual(set(shown), {"1"})
        page.click(".floor-map svg")
        self.assertIn("SET=plan.floor=1", page.value("document.querySelector('.floor-map .readout').textContent"))

    def test_hololens_office(self):
        self.check("hololens_office", real("hololens_office"))

    def test_freiburg(self):
        self.check("freiburg_079", real("laser"))

    def test_ceiling(self):
        self.check("ceiling_office", FOLDER / "data")

    def test_labels(self):
        work = Workspace().removed_after(self)
        use_labels(work)
        work.output("map", "report")
        self.check_page(work.path("report/index.html"))


if __name__ == "__main__":
    unittest.main()
