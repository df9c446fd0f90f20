# SPDX-License-Identifier: Apache-2.0
"""A detector, a layout of recordings and a kind of sensor take the edits that docs/extending.md says. A copy of the tree gets one of
each; then frames lists a recording of that layout with that sensor, features finds that detector's keypoints, and the tests that
hold the tables together pass. By day: the page names the files, and each place to edit is there once."""
import dataclasses
import json
import shutil
import unittest

import h5py
import numpy as np
from add_wing_test import build_stage, copy_of_the_tree
from nightly import nightly
from PIL import Image
from workspace import CAMERA, REPOSITORY, read_pipeline, said_by, write_gray16

PAGE = "docs/extending.md"
NUM_FRAMES = 4


@dataclasses.dataclass(frozen=True)
class Edit:
    """Text that goes before and after a text which its file has once."""

    file: str
    anchor: str
    before: str = ""
    after: str = ""

    def make_in(self, folder):
        path = folder / self.file
        path.write_text(path.read_text().replace(self.anchor, self.before + self.anchor + self.after))


CORNERS = """\
std::vector<cv::KeyPoint> AgastCorners(const GrayImage& gray, const ExtractionOptions& options) {
  std::vector<cv::KeyPoint> corners;
  cv::AGAST(MatOf(gray), corners, options.fast_threshold, true, cv::AgastFeatureDetector::OAST_9_16);
  for (cv::KeyPoint& corner : corners) corner = {corner.pt, kOrbPatch_px, 0, corner.response, 0};
  return corners;
}

"""
READER = """\
// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "pipeline/recording/read_sequence.h"

namespace nightmap {

RawSequence ReadPairsFolder(const SequenceFolder& folder) {
  std::vector<std::string> numbers;
  for (const auto& entry : std::filesystem::directory_iterator(folder.Absolute())) {
    const std::string name = entry.path().filename().string();
    if (name.ends_with("_color.png")) numbers.push_back(name.substr(0, name.find('_')));
  }
  std::ranges::sort(numbers);
  RawSequence sequence;
  for (const std::string& number : numbers) {
    RawFrame& frame = sequence.frames.emplace_back();
    frame.time_ns = TimeOfFrame_ns(std::stoll(number), 10);
    frame.color.path = folder.Relative(number + "_color.png");
    frame.depth.path = folder.Relative(number + "_depth.png");
  }
  return sequence;
}

}  // namespace nightmap
"""
COUNT = """\
def _num_pairs(folder, _sequence):
    return sum(name.endswith("_color.png") for name in os.listdir(folder))


"""
KIND = """
      {.kind = SignalKind::kMagnetic,
       .name = "magnetic",
       .file = "magnetic.h5",
       .values = {{{"mx", "uT"}, {"my", "uT"}, {"mz", "uT"}}},
       .max_step_s = 2,
       .max_value = 1e4,
       .a_value = "a magnetic field, which is in uT,"},"""
DETECTORS = [
    Edit("pipeline/camera/extract_features.cc", "const std::vector<Detector>& Detectors() {", before=CORNERS),
    Edit("pipeline/camera/extract_features.cc", "static const std::vector<Detector> detectors = {",
         after='\n      {"agast_orb", DescriptorKind::kOrb, MakeOrb<kOrbPatch_px>, AgastCorners},'),
    Edit("tests/camera/extract_features_test.cc", "constexpr std::array kDetectors = {", after='"agast_orb", '),
]  # fmt: skip
LAYOUTS = [
    Edit("pipeline/recording/read_sequence.h", "RawSequence ReadPictures(", before="RawSequence ReadPairsFolder(const SequenceFolder& folder);\n"),
    Edit("pipeline/recording/layouts.cc", "static const std::vector<Layout> layouts = {",
         after='\n      {.name = "pairs", .read = ReadPairsFolder, .required = {"folder", "camera"}},'),
    Edit("scripts/nightmap_make/input_files.py", "COUNTS = {", before=COUNT, after='"pairs": _num_pairs, '),
]  # fmt: skip
KINDS = [
    Edit("pipeline/recording/signal_kinds.h", "enum class SignalKind { ", after="kMagnetic, "),
    Edit("pipeline/recording/signal_kinds.cc", "static const std::vector<SignalKindRow> kinds = {", after=KIND),
    Edit("configs/recording/pipeline.toml", 'beside.scans = "scans.h5"\n', after='beside.magnetic = "magnetic.h5"\n'),
    Edit("docs/formats.md", "`frames/acceleration.h5`, ", after="`magnetic.h5`, "),
]
EDITS = [*DETECTORS, *LAYOUTS, *KINDS]
ROWS_TESTS = ["detectors_test.DetectorsTest.test_the_unit_tests_try_every_row", "site_configs_test.TablesTest",
              "docs_test.DocsTest.test_every_artifact_is_described", "docs_test.DocsTest.test_the_table_of_the_pipeline_is_the_declaration"]  # fmt: skip

SITE = f"""\
root = "pairs"
[[camera]]
id = "color"
{"".join(f"{key} = {value}" + chr(10) for key, value in CAMERA.items())}depth_units_per_m = 5000
[[sequence]]
layout = "pairs"
folder = "."
camera = "color"
[[sensor]]
id = "compass"
kind = "magnetic"
[[signal]]
sensor = "compass"
format = "text"
file = "compass.txt"
"""


def write_recording(folder):
    """A wall of gray blocks, from which the camera moves, and a compass that turns."""
    blocks = np.random.default_rng(0).integers(0, 256, (60, 60), np.uint8).repeat(8, 0).repeat(8, 1)
    for number in range(NUM_FRAMES):
        view = blocks[: CAMERA["height"], 5 * number :][:, : CAMERA["width"]]
        Image.fromarray(np.dstack([view] * 3)).save(folder / f"{number:04}_color.png")
        write_gray16(folder / f"{number:04}_depth.png", CAMERA["width"], CAMERA["height"], 10000)
    (folder / "compass.txt").write_text("".join(f"{0.1 * i:.1f} {20 + i} 0 -40\n" for i in range(10)) + "1.0 20000 0 0\n")


class PlacesTest(unittest.TestCase):
    def test_the_page_names_the_files_and_each_place_is_there_once(self):
        page = (REPOSITORY / PAGE).read_text(encoding="utf-8")
        for edit in EDITS:
            with self.subTest(edit.anchor):
                self.assertIn(f"({edit.file.removeprefix('docs/')})" if edit.file.startswith("docs/") else f"`{edit.file}`", page)
                self.assertEqual((REPOSITORY / edit.file).read_text(encoding="utf-8").count(edit.anchor), 1)


@nightly
class ExtendTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = copy_of_the_tree()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        for edit in EDITS:
            edit.make_in(cls.folder)
        (cls.folder / "pipeline/recording/read_pairs.cc").write_text(READER)
        cls.run_script("scripts/describe_pipeline.py", "--write")
        build_stage(cls.folder, "frames", "features", "inspect")
        (cls.folder / "data/pairs").mkdir(parents=True)
        write_recording(cls.folder / "data/pairs")
        (cls.folder / "site.toml").write_text(SITE)
        cls.of_site = ("--in", "site=site.toml", "--in", "data=data")
        cls.run_program("frames", *cls.of_site, "--out", "shards=frames/shards.txt", "--out", "report=frames/report.json")

    @classmethod
    def run_in_copy(cls, *command, cwd=".", **variables):
        return said_by(command, cls.folder / cwd, **variables)

    @classmethod
    def run_script(cls, *arguments, **options):
        return cls.run_in_copy("/usr/bin/python3", *arguments, **options)

    @classmethod
    def run_program(cls, name, *arguments):
        return cls.run_in_copy(cls.folder / "build/bin" / name, *arguments)

    def test_frames_lists_the_recording_of_the_layout(self):
        report = json.loads((self.folder / "frames/report.json").read_text())
        self.assertEqual((report["num_frames"], report["num_frames_with_depth"]), (NUM_FRAMES, NUM_FRAMES))
        counted = self.run_script("-c", "from nightmap_make.input_files import num_recorded_frames as n\n"
                                  "print(n({'root': 'pairs', 'sequence': [{'layout': 'pairs'}]}, '../data'))", cwd="scripts")  # fmt: skip
        self.assertEqual(int(counted), NUM_FRAMES)

    def test_frames_writes_the_samples_of_the_kind(self):
        declared = read_pipeline(str(self.folder / "configs")).jobs["frames"].beside["magnetic"]
        with h5py.File(self.folder / "frames" / declared) as file:
            self.assertEqual(file["value"][:].tolist(), [[20 + i, 0, -40] for i in range(10)])
        self.assertIn("compass.txt:11: a magnetic field, which is in uT, is 20000, beyond 10000", (self.folder / "frames/report.json").read_text())

    def test_inspect_shows_names_and_units_of_the_kind(self):
        self.assertRegex(self.run_program("inspect", *self.of_site), r"compass +magnetic +10 .* mx 20 to 29 uT, my 0 to 0 uT, mz -40 to -40 uT")

    def test_features_finds_keypoints_of_the_detector(self):
        (self.folder / "features.toml").write_text('detector = "agast_orb"\n')
        self.run_program("features", "--config", "features.toml", "--in", "frames=frames/shard_0000.csv", "--in", "cameras=frames/cameras.json",
                         "--in", "data=data", "--out", "features=features.h5")  # fmt: skip
        with h5py.File(self.folder / "features.h5") as file:
            self.assertIn(b'detector = "agast_orb"', file.attrs["extraction"])
            self.assertEqual(file["descriptor"].shape[1], 32)  # bytes of ORB
            self.assertGreater(len(file["descriptor"]), 100)

    def test_the_tests_of_the_tables_know_the_rows(self):
        self.run_script("-m", "unittest", *ROWS_TESTS, cwd="tests/scripts")
