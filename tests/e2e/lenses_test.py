# SPDX-License-Identifier: Apache-2.0
"""A recording seen through a fisheye and through a lens of eight coefficients makes the map that the pinhole makes."""
import json
import pathlib
import shutil
import tempfile
import unittest

import numpy as np
from PIL import Image

from accuracy import DATA, metrics_of, real
from nightly import IS_NIGHT
from workspace import BUILD, said_by

FRAMES = range(220, 373) if IS_NIGHT else range(220, 300)
PINHOLE = {"width": 540, "height": 360, "fx": 495.5677570093, "fy": 495.4819626168, "cx": 269.5028971963, "cy": 169.1941121495}
SIZE = (480, 320)
AXIS = (239.5, 151.5)
FISHEYE = {"k1": 0.03, "k2": -0.02, "k3": 0.01, "k4": -0.004}
RATIONAL = {"k1": 0.6, "k2": 0.2, "p1": 0, "p2": 0, "k3": 0, "k4": 0.9, "k5": 0.3, "k6": 0.05}
DEPTH = {"depth_units_per_m": 1000, "min_depth_m": 0.2, "max_depth_m": 6.0, "depth_noise_constant_m": 0.008,
         "depth_noise_quadratic_per_m": 0.0015}  # fmt: skip


def fisheye_radius(tangent):
    angle = np.arctan(tangent)
    return angle * (1 + sum(k * angle ** (2 * i + 2) for i, k in enumerate(FISHEYE.values())))


def rational_radius(tangent):
    k, powers = RATIONAL, tangent ** np.array([[2], [4], [6]])
    upper = 1 + np.array([k["k1"], k["k2"], k["k3"]]) @ powers
    return tangent * upper / (1 + np.array([k["k4"], k["k5"], k["k6"]]) @ powers)


LENSES = {"pinhole": (lambda tangent: tangent, {}), "fisheye": (fisheye_radius, {"lens": '"fisheye"'} | FISHEYE),
          "rational": (rational_radius, RATIONAL)}  # fmt: skip


def pixels_of_pinhole(radius_of):
    """Columns and rows of PINHOLE that the pixels of the lens show."""
    x, y = np.meshgrid(*(np.arange(size) - axis for size, axis in zip(SIZE, AXIS, strict=True)))
    x, y = x / PINHOLE["fx"], y / PINHOLE["fy"]
    radius = np.maximum(np.hypot(x, y), 1e-9)
    tangents = np.linspace(0, 1.2, 20001)
    stretch = np.interp(radius, radius_of(tangents), tangents) / radius
    return x * stretch * PINHOLE["fx"] + PINHOLE["cx"], y * stretch * PINHOLE["fy"] + PINHOLE["cy"]


def nearest(picture, columns, rows):
    columns, rows = np.rint(columns).astype(int), np.rint(rows).astype(int)
    inside = (columns >= 0) & (rows >= 0) & (columns < PINHOLE["width"]) & (rows < PINHOLE["height"])
    return np.where(inside, picture[rows.clip(0, PINHOLE["height"] - 1), columns.clip(0, PINHOLE["width"] - 1)], 0)


def between(picture, columns, rows):
    """Colors by linear interpolation."""
    left, top = (np.floor(value).astype(int).clip(0, PINHOLE[side] - 2) for value, side in ((columns, "width"), (rows, "height")))
    right, down = ((value - first).clip(0, 1)[..., None] for value, first in ((columns, left), (rows, top)))
    upper = (1 - right) * picture[top, left] + right * picture[top, left + 1]
    lower = (1 - right) * picture[top + 1, left] + right * picture[top + 1, left + 1]
    return np.rint((1 - down) * upper + down * lower).astype(np.uint8)


class LensesTest(unittest.TestCase):
    def setUp(self):
        real("hololens_office")
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="nightmap-lenses-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def write(self, name):
        radius_of, coefficients = LENSES[name]
        at = pixels_of_pinhole(radius_of)
        data = self.folder / "data" / name
        for kind, sample in (("rgb", between), ("depth", nearest)):
            (data / kind).mkdir(parents=True)
            lines = [line for line in (DATA / "hololens_office" / f"{kind}.txt").read_text().splitlines() if line[0] != "#"]
            with open(data / f"{kind}.txt", "w", encoding="utf-8") as out:
                for i in FRAMES:
                    time, file = lines[i].split()
                    picture = np.array(Image.open(DATA / "hololens_office" / file))
                    if kind == "depth":
                        picture = picture.astype(np.uint16)
                    Image.fromarray(sample(picture, *at)).save(data / kind / f"{i}.png", compress_level=1)
                    out.write(f"{time} {kind}/{i}.png\n")
        shutil.copy(DATA / "hololens_office" / "groundtruth.txt", data)
        camera = {"id": '"c"', "width": SIZE[0], "height": SIZE[1], "fx": PINHOLE["fx"], "fy": PINHOLE["fy"], "cx": AXIS[0], "cy": AXIS[1]}
        table = "".join(f"{key} = {value}\n" for key, value in (camera | DEPTH | coefficients).items())
        (self.folder / "sites").mkdir(exist_ok=True)
        (self.folder / "sites" / f"{name}.toml").write_text(
            f'root = "{name}"\n[[camera]]\n{table}[[sequence]]\nlayout = "tum"\nfolder = "."\ncamera = "c"\n'
            'ground_truth = "groundtruth.txt"\n', encoding="utf-8")  # fmt: skip

    def error_m(self, name):
        self.write(name)
        folders = (f"{key}={self.folder / key.lower()}" for key in ("SITES", "DATA", "MAPS"))
        said_by(["make", "--no-print-directory", f"SITE={name}", f"BUILD={BUILD}", *folders, "check", "map", "evaluate"])
        results = self.folder / "maps" / name
        verdict = json.loads((results / "verdict" / "verdict.json").read_text())
        self.assertEqual(verdict["verdict"], "good", verdict)
        return metrics_of(results)["trajectory"]["se3"]["ate_rmse_m"]

    def test_each_lens_makes_the_map_of_the_pinhole(self):
        pinhole_m = self.error_m("pinhole")
        models = {"fisheye": "OPENCV_FISHEYE"} | ({"rational": "FULL_OPENCV"} if IS_NIGHT else {})
        for name, model in models.items():
            with self.subTest(name):
                self.assertLess(self.error_m(name), 1.25 * pinhole_m)
                self.assertIn(f"1 {model} 480 320", (self.folder / "maps" / name / "landmarks" / "colmap" / "cameras.txt").read_text())
