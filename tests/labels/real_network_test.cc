// SPDX-License-Identifier: Apache-2.0
// The network that nightmap is tested with, on photographs with true labels.
#include <algorithm>
#include <opencv2/core/utility.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/text_file.h"
#include "pipeline/labels/segmenter.h"
#include "tests/test_data.h"

namespace nightmap::real_network_test {

constexpr const char* kNetwork = "../models/deeplabv3_voc/deeplabv3_257_mv.onnx";
constexpr const char* kClasses = "../models/deeplabv3_voc/classes.txt";

SegmentationModel Model(int size_px) {
  std::string classes;
  VisitWordLines(TestDataPath(kClasses), [&](const std::vector<std::string_view>& words) {
    classes += "\"" + std::string(words[0]) + "\", ";
  });
  const std::string size = std::to_string(size_px);
  return ParseSegmentationModel(
      "network = \"" + TestDataPath(kNetwork).filename().string() + "\"\ninput_width_px = " + size +
          "\ninput_height_px = " + size +
          "\nmean = [127.5, 127.5, 127.5]\nscale = [127.5, 127.5, 127.5]\nclasses = [" + classes +
          "]\nmoving = [\"person\"]\n",
      "deeplab.toml",
      TestDataPath(kNetwork).parent_path());
}

// Pixels of people in both, and in either; those that the truth leaves open do not count.
struct Overlap {
  int both = 0;
  int either = 0;
};

Overlap OverlapOfPeople(const Segmenter& segmenter, const std::filesystem::path& stem) {
  const ColorImage color = ReadColorImage(stem.string() + ".jpg");
  const ColorImage truth = ReadColorImage(stem.string() + "_label.png");
  const LabelImage labels = segmenter.Segment(color, {}).labels;
  Overlap overlap;
  for (std::size_t i = 0; i < labels.pixels.size(); ++i) {
    const std::uint8_t* rgb = &truth.pixels[3 * i];
    if (rgb[0] == 224 && rgb[1] == 224 && rgb[2] == 192) continue;
    const bool is_true = rgb[0] == 192 && rgb[1] == 128 && rgb[2] == 128;
    const bool is_found = labels.pixels[i] == 15;
    overlap.both += is_true && is_found;
    overlap.either += is_true || is_found;
  }
  return overlap;
}

TEST(RealNetwork, FindsPeopleInPhotographs) {
  NIGHTMAP_REQUIRE_DATA("voc_people");
  NIGHTMAP_REQUIRE_DATA(kNetwork);
  cv::setNumThreads(1);
  const Segmenter segmenter(Model(257));
  Overlap sum;
  for (const char* name : {"2011_000003", "2011_000006", "2011_000025"}) {
    const Overlap overlap = OverlapOfPeople(segmenter, TestDataPath("voc_people") / name);
    sum.both += overlap.both;
    sum.either += overlap.either;
  }
  const double iou = static_cast<double>(sum.both) / sum.either;
  RecordProperty("person_iou", std::to_string(iou));
  EXPECT_GT(iou, 0.75);
}

TEST(RealNetwork, AnotherInputSizeIsRefused) {
  NIGHTMAP_REQUIRE_DATA(kNetwork);
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        Segmenter(Model(300)),
                        "does not take one picture of 3 channels, 300 x 300 pixels");
}

TEST(RealNetwork, EachNumberOfConcurrentCallsGivesTheSameLabels) {
  NIGHTMAP_REQUIRE_DATA("voc_people");
  NIGHTMAP_REQUIRE_DATA(kNetwork);
  cv::setNumThreads(1);  // with more, OpenCV's convolutions add in another order
  const std::array<const char*, 2> names = {"2011_000003.jpg", "2011_000006.jpg"};
  std::vector<ColorImage> pictures;
  for (const char* name : names) {
    pictures.push_back(ReadColorImage(TestDataPath("voc_people") / name));
  }
  std::vector<Segmentation> first;
  for (const int num_threads : {1, 2, 4}) {
    const Segmenter segmenter(Model(257));
    std::vector<Segmentation> results(6);
    ParallelFor(results.size(), num_threads, [&](std::size_t i) {
      results[i] = segmenter.Segment(pictures[i % 2], {});
    });
    if (first.empty()) first = results;
    for (std::size_t i = 0; i < results.size(); ++i) {
      EXPECT_TRUE(results[i].labels.pixels == first[i % 2].labels.pixels);
      EXPECT_TRUE(results[i].confidences.pixels == first[i % 2].confidences.pixels);
    }
  }
}

}  // namespace nightmap::real_network_test
