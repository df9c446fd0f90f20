# SPDX-License-Identifier: Apache-2.0
"""Plain pictures as queries: other sizes and lenses than the map's, from anywhere, straight to a path."""
import json
import math
import os

import numpy as np
from PIL import Image

from opened_files import OpenedFiles
from workspace import CAMERA, SITE, CopiedSiteTest, read_csv, write_black

GOALS = ("map", "localize")
WIDTH, HEIGHT = CAMERA["width"], CAMERA["height"]
FOV_DEG = math.degrees(2 * math.atan(WIDTH / 2 / CAMERA["fx"]))
EXIF_IFD, ORIENTATION, FOCAL_35MM = 0x8769, 0x0112, 0xA405
# The middle of a picture: 284 of 320 columns have the field of view of a "32 mm" lens.
MIDDLE, FOCAL_35MM_OF_MIDDLE = (18, 13.5, 302, 226.5), 32
CSV_HEADER = "picture,width,height,fx,fy,cx,cy,k1,k2,p1,p2,k3\n"


def position_m(row):
    return np.array([float(row[name]) for name in ("tx_m", "ty_m", "tz_m")])


def view_direction(row):
    """The camera's z axis in the map."""
    x, y, z, w = (float(row[name]) for name in ("qx", "qy", "qz", "qw"))
    return np.array([2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y)])


def save_with_exif(image, path, orientation=1):
    exif = Image.Exif()
    exif[ORIENTATION] = orientation
    exif[EXIF_IFD] = {FOCAL_35MM: FOCAL_35MM_OF_MIDDLE}
    image.save(path, quality=95, exif=exif)


class PicturesTest(CopiedSiteTest):
    made = GOALS

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        located = [row for row in read_csv(cls.base.path("localize/queries.csv")) if row["status"] == "located"]
        cls.best = max(located, key=lambda row: int(row["num_inliers"]))
        cls.other = max(located, key=lambda row: np.linalg.norm(position_m(row) - position_m(cls.best)))

    def setUp(self):
        super().setUp()
        self.photos = self.work.folder / "photos"
        self.photos.mkdir()

    def image(self, row):
        return Image.open(self.work.folder / "data" / row["color_path"]).convert("RGB")

    def zoomed(self, row):
        return self.image(row).resize((640, 480), Image.LANCZOS, box=MIDDLE)

    def reran(self, *arguments):
        before = self.work.runs()
        self.make(*arguments)
        after = self.work.runs()
        return {stage for stage in after if before.get(stage) != after[stage]}

    def located(self, name):
        """The row of a picture by its file name."""
        rows = read_csv(self.work.path("localize/queries.csv"))
        return next(row for row in rows if row["color_path"].endswith("/" + name))

    def check_same_place(self, row, expected):
        self.assertEqual(row["status"], "located", row)
        self.assertLess(np.linalg.norm(position_m(row) - position_m(expected)), 0.05, row["color_path"])
        self.assertGreater(view_direction(row) @ view_direction(expected), math.cos(math.radians(2)))

    def test_every_source_of_a_camera_locates_its_picture(self):
        image = self.image(self.best)
        save_with_exif(self.zoomed(self.best), self.photos / "zoomed.jpg")
        turned = self.zoomed(self.best).transpose(Image.ROTATE_90)
        save_with_exif(turned, self.photos / "turned.jpg", orientation=6)
        image.convert("L").save(self.photos / "gray.png")  # without EXIF: FOV_DEG
        image.crop((40, 30, WIDTH, HEIGHT)).save(self.photos / "corner.png")
        (self.photos / "cameras.csv").write_text(
            f"{CSV_HEADER}corner.png,{WIDTH - 40},{HEIGHT - 30},{CAMERA['fx']},{CAMERA['fy']},"
            f"{CAMERA['cx'] - 40},{CAMERA['cy'] - 30},0,0,0,0,0\n")
        self.assertEqual(self.reran(*GOALS, "QUERY=photos", f"FOV_DEG={FOV_DEG}"), {"queries", "localize"})
        for name in ("zoomed.jpg", "turned.jpg", "gray.png", "corner.png"):
            with self.subTest(name):
                self.check_same_place(self.located(name), self.best)
        cameras = json.loads(self.work.path("queries/query_cameras.json").read_text())["cameras"]
        sizes = [(camera["color"]["width"], camera["color"]["height"]) for camera in cameras]
        self.assertEqual(sizes, [(320, 240), (280, 210), (320, 240), (480, 640), (640, 480)])
        self.assertIn("all as written", self.make("verify"))
        # QUERY is of one run.
        self.assertEqual(self.reran(*GOALS), {"queries", "localize"})
        self.assertEqual(self.work.hashes(), self.hashes)

    def test_a_picture_of_many_pixels_is_located_as_well(self):
        """As by a phone: four times the map's pixels each way. It is scaled down before it is described."""
        image = self.image(self.best)
        image.resize((4 * WIDTH, 4 * HEIGHT), Image.BICUBIC).save(self.photos / "large.png")
        focal_px, cx, cy = (4 * CAMERA["fx"], 4 * CAMERA["cx"] + 1.5, 4 * CAMERA["cy"] + 1.5)
        (self.photos / "cameras.csv").write_text(
            f"{CSV_HEADER}large.png,{4 * WIDTH},{4 * HEIGHT},{focal_px},{focal_px},{cx},{cy},0,0,0,0,0\n")
        rows = {}
        for name, ratio in (("scaled", 1.5), ("whole", 100)):
            self.make("localize", "QUERY=photos", f"SET=localize.max_focal_ratio={ratio}")
            rows[name] = self.located("large.png")
        self.check_same_place(rows["scaled"], self.best)
        self.assertGreater(int(rows["scaled"]["num_inliers"]), 0.9 * int(self.best["num_inliers"]))
        error_px, whole_px = (float(rows[name]["reprojection_error_px"] or "inf") for name in ("scaled", "whole"))
        self.assertLess(error_px, 1.3 * float(self.best["reprojection_error_px"]))
        self.assertGreater(whole_px, 1.2 * error_px)

    def test_a_camera_of_queries_in_the_site_config_reruns_no_stage_of_the_map(self):
        folder = self.work.data() / "phone"
        folder.mkdir()
        self.zoomed(self.best).save(folder / "a.png")
        site = self.work.folder / f"configs/sites/{SITE}.toml"
        focal_px = CAMERA["fx"] * 640 / 284
        camera = (f'[[camera]]\nid = "phone"\nwidth = 640\nheight = 480\nfx = {focal_px}\nfy = {focal_px}\n'
                  'cx = 319.5\ncy = 239.5\ndepth_units_per_m = 1000\n\n')
        text = site.read_text().replace("[[camera]]", camera + "[[camera]]", 1)
        site.write_text(text + '\n[[query]]\nlayout = "pictures"\npictures = "phone"\ncamera = "phone"\n')
        self.assertEqual(self.reran(*GOALS), {"frames", "queries", "localize"})
        self.check_same_place(self.located("a.png"), self.best)
        self.assertEqual(self.work.make("-q", *GOALS).returncode, 0)

    def test_two_pictures_give_a_path(self):
        save_with_exif(self.zoomed(self.best), self.photos / "start.jpg")
        save_with_exif(self.zoomed(self.other), self.photos / "goal 1.jpg")
        self.make("plan", "QUERY=photos/start.jpg 'photos/goal 1.jpg'",
                  "START=picture:photos/start.jpg", "GOAL=picture:goal 1.jpg")
        path = read_csv(self.work.path("plan/path.csv"))
        for row, end in ((self.best, path[0]), (self.other, path[-1])):
            end_m = np.array([float(end["x_m"]), float(end["y_m"])])
            # An end that is no free cell is moved by at most snap_radius_m.
            self.assertLess(np.linalg.norm(end_m - position_m(row)[:2]), 0.05 + 1.0)
        self.check_same_place(self.located("start.jpg"), self.best)
        self.check_same_place(self.located("goal 1.jpg"), self.other)

    def test_a_plan_that_finds_no_path_leaves_a_picture_until_the_next(self):
        ends = ("START=picture:a.png", "GOAL=picture:b.png", "QUERY=photos/a.png photos/b.png", f"FOV_DEG={FOV_DEG}")
        for name, row in (("a.png", self.best), ("b.png", self.other)):
            self.image(row).save(self.photos / name)
        self.make("plan", *ends)
        path, picture = self.work.path("plan/path.csv"), self.work.path("plan/no_path.png")
        before = path.read_bytes()
        self.assertFalse(picture.exists())
        self.assertIn("no_path.png shows more", self.make("plan", *ends, "SET=plan.robot_radius_m=4", code=2))
        with Image.open(picture) as shown, Image.open(self.work.path("plan/path.png")) as drawn:
            self.assertEqual(shown.size, drawn.size)
        self.assertEqual(path.read_bytes(), before)
        self.assertIn("The last plan found no path", self.work.path("report/index.html").read_text())
        self.make("plan", *ends, "SET=plan.robot_radius_m=0.2")
        self.assertFalse(picture.exists())

    def test_a_picture_replaced_in_place_is_noticed(self):
        photo = self.photos / "a.png"
        self.image(self.best).save(photo)
        asked = (*GOALS, "QUERY=photos/a.png", f"FOV_DEG={FOV_DEG}")
        self.make(*asked)
        self.assertEqual(self.reran(*asked), set())
        photo.touch()
        self.assertEqual(self.reran(*asked), {"queries"})
        write_black(photo, WIDTH, HEIGHT)
        self.assertEqual(self.reran(*asked), {"queries", "localize"})
        self.assertEqual(self.located("a.png")["reason"], "no_features")

    def test_a_picture_is_located_without_a_look_at_the_recording(self):
        """However many frames it has: of the recording, only the pictures held out are opened, and no folder is listed."""
        self.work.as_recorded()
        self.make("map")
        self.image(self.best).save(self.photos / "new.png")
        held_out = {os.path.relpath(row["color_path"], SITE) for row in read_csv(self.work.path("frames/held_out.csv"))}
        with OpenedFiles(self.work.data()) as opened:
            self.make("localize", "QUERY=photos/new.png", f"FOV_DEG={FOV_DEG}")
        self.check_same_place(self.located("new.png"), self.best)
        self.assertEqual(opened.names - held_out, set())
        with OpenedFiles(self.work.data()) as opened:  # what looks at the recording does show
            self.make("map")
        self.assertIn("rgb", opened.names)

    def test_mistakes_are_refused_with_the_remedy(self):
        self.image(self.best).save(self.photos / "a.png")
        (self.photos / "empty.txt").write_text("# no picture\n")
        for arguments, message in [(["QUERY=photos/b.png"], "QUERY: photos/b.png does not exist"),
                                   (["QUERY=photos/a.png", "CAMERA=phone"], 'no [[camera]] has id "phone"'),
                                   (["QUERY=photos/a.png", "FOV_DEG=0"], "horizontal_fov_deg = 0.0 is out of range"),
                                   (["QUERY=photos/a.png photos"], "is a query already"),
                                   (["QUERY=photos/empty.txt"], "empty.txt: no pictures"),
                                   (["FOV_DEG=60"], "CAMERA and FOV_DEG describe the pictures of QUERY")]:
            with self.subTest(arguments):
                self.assertIn(message, self.make("localize", *arguments, code=2))

    def test_what_is_no_picture_is_a_query_without_a_pose(self):
        """Among others that have one. The log says what a video needs, whatever its name."""
        self.image(self.best).save(self.photos / "a.png")
        movie = b"\0\0\0\x18ftypisom" + bytes(500)
        for name, content in (("b.jpg", b"no picture"), ("c.jpg", movie), ("movie.mp4", movie)):
            (self.photos / name).write_bytes(content)
        (self.photos / "list.txt").write_text("movie.mp4\na.png\n")
        remedy = "is a video or an animation, no picture: extract the frames to localize as pictures"
        for query, unreadable, log in (("photos", ("b.jpg", "c.jpg"), f"photos/c.jpg: {remedy}"),
                                       ("photos/list.txt", ("movie.mp4",), f"photos/movie.mp4: {remedy}"),
                                       ("photos/movie.mp4", ("movie.mp4",), f"photos/movie.mp4: {remedy}")):
            with self.subTest(query):
                self.assertIn(log, self.make("localize", f"QUERY={query}", "CAMERA=color"))
                for name in unreadable:
                    self.assertEqual(self.located(name)["reason"], "unreadable_image")
                if query != "photos/movie.mp4":
                    self.check_same_place(self.located("a.png"), self.best)
