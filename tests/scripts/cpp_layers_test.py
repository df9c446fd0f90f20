# SPDX-License-Identifier: Apache-2.0
"""Rules of ARCHITECTURE.md for the C++ hold of the sources, and each finder finds a breach."""
import pathlib
import tempfile
import unittest

from cpp_sources import Sources

ROOT = pathlib.Path(__file__).resolve().parents[2]
WITHOUT_RUN = {"join_labels", "join_octrees"}
# Files of more than 250 lines, and how many. No name comes in, no number grows.
LONG = dict(absolute_pose=301, active_search_test=260, bundle_adjustment=319, bundle_adjustment_test=348,
            ceiling_adjust=257, ceiling_ekf_test=274, ceiling_mosaic=257, choose_floor_test=273, drive_test=312,
            endpoints=381, features_test=311, ground=252, hdf5_hostile_test=268, landmark_keeper=283,
            localize_test=359, match_scan_test=252, moving_test=264, octree_io_test=414, odometry_test=261,
            options=251, picture_file_test=275, pictures_test=383, plan_test=682, published_test=317,
            read_sequence_test=605, read_signals_test=655, render=270, robot_test=427, scan_loops_test=257,
            scan_match_test=289, schur_system=262, search_pose_test=286, shell=268, site_config=256,
            site_config_test=458, stage_main_test=561, synthesize_test=341, thin_walls_test=395, thing_ends_test=316,
            world_test=283)  # fmt: skip
CMAKE = """nightmap_library(base LINK fmt::fmt)
nightmap_library(io LINK nightmap_base)
"""
LINKS = {"CMakeLists.txt": CMAKE, "pipeline/dense/links.cmake": "nightmap_library(dense LINK nightmap_io)\n",
         "stages/wing/links.cmake": "target_link_libraries(stage_${stage} PUBLIC nightmap_io)\n",
         "stages/wide/links.cmake": "target_link_libraries(stage_${stage} PUBLIC nightmap_io nightmap_dense)\n"}  # fmt: skip
MAIN = "int main();\n"


class CppRulesTest(unittest.TestCase):
    def setUp(self):
        self.sources = Sources(ROOT)

    def planted(self, texts):
        """Sources of these files beside those of two stages."""
        with tempfile.TemporaryDirectory() as folder:
            for name, text in ({"stages/wing/grid/main.cc": MAIN, "stages/wide/tiles/main.cc": MAIN} | LINKS | texts).items():
                path = pathlib.Path(folder, name)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            return Sources(pathlib.Path(folder))

    def test_includes_point_down(self):
        self.assertEqual(self.sources.wrong_includes(), [])
        self.assertEqual(self.sources.below["io"], {"base", "program", "geometry"})
        up, down = '#include "pipeline/dense/points.h"\n', '#include "pipeline/io/grid_io.h"\n#include "pipeline/base/files.h"\n'
        found = self.planted({"pipeline/io/deep/grid_io.h": up, "pipeline/dense/points.cc": down + up, "stages/wide/tiles/tiles.cc": up,
                              "stages/wing/grid/grid.cc": down + up}).wrong_includes()  # fmt: skip
        self.assertEqual(found, [f"{name}: pipeline/dense/points.h" for name in ("pipeline/io/deep/grid_io.h", "stages/wing/grid/grid.cc")])

    def test_no_stage_includes_another(self):
        other, own = '#include "stages/wide/tiles/tiles.h"\n', '#include "stages/wing/grid/grid.h"\n'
        found = self.planted({"stages/wing/grid/grid.cc": own + other, "pipeline/io/grid_io.h": own}).wrong_includes()
        self.assertEqual(found, ["pipeline/io/grid_io.h: stages/wing/grid/grid.h", "stages/wing/grid/grid.cc: stages/wide/tiles/tiles.h"])

    def test_headers_name_no_third_party(self):
        self.assertEqual(self.sources.third_party_in_headers(), [])
        use = '#include "pipeline/io/inner.h"\n'
        for text, name in (("#include <opencv2/core.hpp>\n", "opencv2/core.hpp"), ("// cv::\ncv::Mat Load();\n", "cv::")):
            planted = {"pipeline/io/inner.h": text, "pipeline/io/inner.cc": use}
            self.assertEqual(self.planted(planted).third_party_in_headers(), [])  # a source of its library alone includes it
            for user in ("pipeline/io/outer.h", "stages/wide/tiles/tiles.cc"):
                self.assertEqual(self.planted(planted | {user: use}).third_party_in_headers(), [f"pipeline/io/inner.h: {name}"])

    def test_files_are_short(self):
        self.assertEqual(self.sources.long_mains(), [])
        lengths = self.sources.long_files()
        self.assertEqual({name: length for name, length in lengths.items() if length > LONG.get(name, 0)}, {}, "too long")
        there = {path.name.removesuffix(".cc") for path in self.sources.texts}
        self.assertEqual(sorted(LONG.keys() & there - lengths.keys()), [], "no longer too long: take it out of LONG")
        found = self.planted({"stages/wide/tiles/main.cc": 61 * MAIN, "tests/a.cc": 251 * MAIN, "tests/b.h": 250 * MAIN})
        self.assertEqual((found.long_mains(), found.long_files()), (["stages/wide/tiles"], {"a": 251}))

    def test_run_takes_options_inputs_progress_and_threads(self):
        self.assertEqual(self.sources.runs_out_of_order(), [])
        with_run = {self.sources.owner(header) for header, *_ in self.sources.runs()}
        self.assertEqual({stage.name for stage in self.sources.stages - with_run}, WITHOUT_RUN)
        for order in ("const In& a, const Options& b", "Progress& progress, const std::map<int, int>& a", "int num_threads,\n    Progress& progress"):
            found = self.planted({"stages/wide/tiles/tiles.h": f"Tiles RunTiles({order});\n"})
            self.assertEqual(found.runs_out_of_order(), ["stages/wide/tiles/tiles.h: RunTiles"], order)

    def test_run_names_no_file(self):
        self.assertEqual(self.sources.runs_of_files(), [])
        for parameter in ("const std::string& file", "const std::filesystem::path& root"):
            found = self.planted({"stages/wide/tiles/tiles.h": f"Tiles RunTiles(int a, {parameter});\n"})
            self.assertEqual(found.runs_of_files(), [f"stages/wide/tiles/tiles.h: RunTiles({parameter})"])
        names = {"stages/wide/tiles/cut.cc": 'throw DataError("cameras.json");\n', "stages/wide/tiles/write.cc": 'Write("a.csv");\n', "stages/wide/tiles/cut.h": ""}
        found = self.planted(names | {"stages/wide/tiles/tiles.h": '#include "stages/wide/tiles/cut.h"\nTiles RunTiles();\n'})
        self.assertEqual(found.runs_of_files(), ['stages/wide/tiles/cut.cc: "cameras.json"'])
