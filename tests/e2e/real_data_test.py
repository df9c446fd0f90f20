# SPDX-License-Identifier: Apache-2.0
"""Accuracy on real recordings: maps without the frames that are located in them, and at night maps of all frames."""

from PIL import Image, ImageOps

from accuracy import FOLDER, Bars, calibration_of, make, metrics_of, real
from workspace import read_csv
from nightly import nightly


class RealDataTest(Bars):
    @nightly
    def test_fr1_xyz(self):
        data = real("tum_fr1_xyz_15hz")
        self.check_trajectory(metrics_of(make("tum_fr1_xyz_15hz", data, "map", "evaluate")), 0.009, 399)

    def test_fr1_xyz_queries(self):
        data = real("tum_fr1_xyz_15hz")
        site_dir = make("tum_fr1_xyz_15hz_queries", data, "map", "localize", "evaluate")
        metrics = metrics_of(site_dir)
        self.check_trajectory(metrics, 0.009, 320)
        self.check_queries(metrics["queries"], 1.0, 0.6)
        # A Kinect reads its rows one after the other, from the top, in most of the 33 ms of a frame.
        readout_s = calibration_of(site_dir)["rolling_shutter_readout_s"]
        self.assertTrue(0.015 < readout_s < 0.034, readout_s)

    def test_mirrored_pictures_of_fr1_xyz(self):
        """As a phone's front camera stores them: of the frames that the map does not have, none is located."""
        data = real("tum_fr1_xyz_15hz")
        site_dir = make("tum_fr1_xyz_15hz_queries", data, "map")
        folder = FOLDER / "mirrored"
        folder.mkdir(parents=True, exist_ok=True)
        paths = [data / row["color_path"] for row in read_csv(site_dir / "frames/held_out.csv")][16:32:2]
        for path in paths:
            ImageOps.mirror(Image.open(path)).save(folder / path.name, quality=95)
        make("tum_fr1_xyz_15hz_queries", data, "localize", f"QUERY={folder}", "CAMERA=kinect")
        rows = [row for row in read_csv(site_dir / "localize/queries.csv") if "mirrored/" in row["color_path"]]
        self.assertEqual([(row["status"], row["reason"]) for row in rows], [("not_in_map", "mirrored")] * len(paths))

    @nightly
    def test_hololens_office(self):
        data = real("hololens_office")
        self.check_trajectory(metrics_of(make("hololens_office", data, "map", "evaluate")), 0.045, 373)

    def test_hololens_office_queries(self):
        data = real("hololens_office")
        site_dir = make("hololens_office_queries", data, "map", "localize", "plan", "evaluate")
        metrics = metrics_of(site_dir)
        self.check_trajectory(metrics, 0.03, 299)
        queries = metrics["queries"]
        self.check_queries(queries, 1.2, 0.3)
        self.assertGreaterEqual(queries["local"]["recall_5cm_5deg_percent"], 97)
        self.assertGreaterEqual(queries["global"]["recall_5cm_5deg_percent"], 85)
        self.check_path_between_pictures(site_dir)
