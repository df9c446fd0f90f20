# SPDX-License-Identifier: Apache-2.0
"""The page on which objects are drawn on a laser map, in a browser, for its tests."""
import json
import math
import pathlib
import sys
import time

from driven_browser import CONTROL, DrivenPage

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "scripts"))

import fake_site  # noqa: E402
import laser_site  # noqa: E402
from nightmap_eval.grid import read_grid  # noqa: E402

PLACE_M = 0.03  # the mouse is on whole pixels, of about 1 cm each
KEYS = ("x_m", "y_m", "size_x_m", "size_y_m", "angle_deg")
COLUMN = 'format: nightmap objects\nversion: 1\nobjects:\n  - name: "column"\n    x_m: 1\n    y_m: -0.5\n    size_x_m: 1\n' \
         "    size_y_m: 0.6\n    angle_deg: 0\n    distinctiveness: 0.83\n"  # fmt: skip
COLUMN_AS_WRITTEN = """\
format: nightmap objects
version: 1
objects:
  - name: "column"
    x_m: 1.000
    y_m: -0.500
    size_x_m: 1.000
    size_y_m: 0.600
    angle_deg: 0.000
    distinctiveness: 0.830
"""


def objects_in(text):
    """Objects of a file that the page wrote, each as a dictionary."""
    objects = []
    for line in text.splitlines()[3:]:
        key, value = line.removeprefix("  - ").strip().split(": ", 1)
        if key == "name":
            objects.append({})
        objects[-1][key] = json.loads(value)
    return objects


class ObjectsPageCase(laser_site.LaserFolderTest):
    """A site with a room of 6 m x 4 m around the middle of the map, and the page of its report."""

    def setUp(self):
        super().setUp()
        laser_site.write_site(self.site_dir, truth=False)
        self.yaml = self.site_dir / "grid" / "map.yaml"

    def use(self, text):
        """Makes a file the objects in use."""
        self.write(self.folder / "objects.yaml", text)
        self.write("config/site/hall.toml", '[import]\nobjects = "objects.yaml"\n')

    def open(self):
        self.report()
        self.page = DrivenPage(self, self.site_dir / "report/index.html")
        # Opening draws all again, some time after the click: what is typed before that is lost.
        self.page.value("void document.querySelector('details#objects').addEventListener('toggle', () => { window.isOpened = true; })")
        self.page.click("details#objects > summary")
        self.page.wait("window.isOpened === true")
        self.page.middle_of("#objects svg")
        self.grid = read_grid(self.yaml)

    def at(self, x_m, y_m):
        """Pixels of a point of the map, by its cell in the picture of the grid."""
        x, y = x_m - self.grid.origin_x_m, y_m - self.grid.origin_y_m
        cos, sin = math.cos(self.grid.origin_yaw_rad), math.sin(self.grid.origin_yaw_rad)
        column, row = (cos * x + sin * y) / self.grid.resolution_m, (cos * y - sin * x) / self.grid.resolution_m
        return self.page.value(f"""(() => {{ const image = document.querySelector("#objects image");
            const point = new DOMPoint({column}, {self.grid.cells.shape[0] - row}).matrixTransform(image.getScreenCTM());
            return [point.x, point.y]; }})()""")

    def draw(self, start, end):
        self.page.drag(self.at(*start), self.at(*end))

    def handle(self, name):
        return self.page.middle_of(f"#objects [data-handle='{name}']")

    def downloaded(self):
        """Text of the file that the page downloads. A browser without a person refuses after ten."""
        path = pathlib.Path(self.page.downloads) / "objects.yaml"
        path.unlink(missing_ok=True)
        self.page.click("#objects .download")
        for _ in range(200):
            if path.exists():
                return path.read_text(encoding="utf-8")
            time.sleep(0.05)
        return self.fail("no file was downloaded")

    def text(self):
        """The same without a file."""
        self.page.value("""window.kept = [URL.createObjectURL, HTMLAnchorElement.prototype.click];
                           URL.createObjectURL = (blob) => { window.blob = blob; return ""; };
                           HTMLAnchorElement.prototype.click = () => {};""")
        self.page.click("#objects .download")
        return self.page.value("[URL.createObjectURL, HTMLAnchorElement.prototype.click] = window.kept; window.blob.text()")

    def objects(self):
        return objects_in(self.text())

    def notice(self):
        return self.page.value("document.querySelector('#objects .notice').textContent")

    def field(self, index, key):
        return f"#objects fieldset:nth-child({index + 1}) .{key} input"

    def undo(self):
        self.page.key("z", CONTROL)

    def open_file(self, text, name="other.yaml"):
        path = self.folder / name
        path.write_text(text, encoding="utf-8")
        self.page.choose_file("#objects input[type=file]", path)
        self.page.wait(f"document.querySelector('#objects .notice').textContent.includes({json.dumps(name)})")
        return self.notice()

    def assert_place(self, found, *expected, tolerance=PLACE_M):
        for key, value in zip(KEYS, expected):
            self.assertAlmostEqual(found[key], value, delta=1.5 if key == "angle_deg" else tolerance, msg=f"{key} of {found}")

    def press(self, at):
        self.page.press(at)
        self.page.mouse("mouseReleased", at, "left")
