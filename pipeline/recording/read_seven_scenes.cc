// SPDX-License-Identifier: Apache-2.0
// 7-Scenes layout: frame-NNNNNN.color.png, .depth.png and .pose.txt (4x4 world_from_camera) in one
// folder. It records no times, so they are NNNNNN / frame rate.
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/text_file.h"
#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/recording_bounds.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kPrefix = "frame-";
constexpr std::array<std::string_view, 2> kColorSuffixes = {".color.png", ".color.jpg"};
constexpr double kFrameRate_hz = 30;
constexpr double kMaxPosition_m = 1e9;      // a larger position is damage
constexpr double kMaxRotationError = 0.02;  // of R^T R against I, because poses are printed rounded

// A color file `frame-NNNNNN.color.png` with its number and its name up to the number.
struct NumberedFile {
  std::int64_t number;
  std::string stem;  // frame-NNNNNN
  std::string name;
};

std::optional<NumberedFile> ParseName(const std::string& name) {
  if (!name.starts_with(kPrefix)) return std::nullopt;
  for (const std::string_view suffix : kColorSuffixes) {
    if (!name.ends_with(suffix)) continue;
    const std::string stem = name.substr(0, name.size() - suffix.size());
    const auto number = ParseInteger(std::string_view(stem).substr(kPrefix.size()));
    if (number && *number >= 0) return NumberedFile{*number, stem, name};
  }
  return std::nullopt;
}

std::vector<NumberedFile> ListColorFiles(const fs::path& folder) {
  std::vector<NumberedFile> files;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (auto file = ParseName(entry.path().filename().string())) files.push_back(std::move(*file));
  }
  std::ranges::sort(files, {}, [](const NumberedFile& f) { return std::tie(f.number, f.name); });
  const auto twin = std::ranges::adjacent_find(files, {}, &NumberedFile::number);
  if (twin != files.end()) {
    throw DataError("{}: '{}' and '{}' have the same number: remove one",
                    folder.string(),
                    twin->name,
                    std::next(twin)->name);
  }
  return files;
}

// Nothing where tracking was lost, which the recorders write as infinite or NaN.
std::optional<Rigid3> ReadPose(const fs::path& path) {
  std::vector<double> values;
  bool lost = false;
  VisitWordLines(path, [&](const std::vector<std::string_view>& words) {
    for (const std::string_view word : words) {
      lost = lost || word.find("inf") != std::string::npos ||
             word.find("INF") != std::string::npos || word.find("nan") != std::string::npos ||
             word.find("NaN") != std::string::npos;
      values.push_back(lost ? 0 : RealWord(word));
    }
  });
  if (values.size() != 16) {
    throw DataError("{}: {} numbers, expected a 4x4 matrix", path.string(), values.size());
  }
  if (lost) return std::nullopt;
  const Eigen::Matrix4d matrix =
      Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(values.data());
  const Eigen::Matrix3d rotation = matrix.topLeftCorner<3, 3>();
  const Eigen::Matrix3d error = rotation.transpose() * rotation - Eigen::Matrix3d::Identity();
  if (error.cwiseAbs().maxCoeff() > kMaxRotationError || rotation.determinant() < 0 ||
      matrix.topRightCorner<3, 1>().cwiseAbs().maxCoeff() > kMaxPosition_m) {
    throw DataError("{}: not a rigid transform", path.string());
  }
  return Rigid3{Eigen::Quaterniond(rotation).normalized(), matrix.topRightCorner<3, 1>()};
}

}  // namespace

RawSequence ReadSevenScenesFolder(const SequenceFolder& folder) {
  const fs::path absolute = folder.Absolute();
  const double rate_hz =
      folder.config.frame_rate_hz > 0 ? folder.config.frame_rate_hz : kFrameRate_hz;
  RecordingBounds bounds(folder);
  RawSequence sequence;
  for (const NumberedFile& file : ListColorFiles(absolute)) {
    RawFrame frame;
    frame.time_ns = TimeOfFrame_ns(file.number, rate_hz);
    frame.color.path = folder.Relative(file.name);
    const std::string depth = file.stem + ".depth.png", pose = file.stem + ".pose.txt";
    std::error_code missing;
    if (folder.TakesDepth() && fs::exists(absolute / depth, missing)) {
      frame.depth.path = folder.Relative(depth);
    } else if (folder.NeedsDepth()) {
      frame.depth_problem = fmt::format("{}: {} is missing", frame.color.path, depth);
    }
    if (fs::exists(absolute / pose, missing)) {
      bounds.Check(folder.Relative(pose));
      if (const auto truth = ReadPose(absolute / pose)) {
        sequence.ground_truth.push_back({frame.time_ns, *truth});
      }
    }
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace nightmap
