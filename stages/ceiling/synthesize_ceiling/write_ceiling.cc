// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/write_ceiling.h"

#include <fmt/format.h>

#include <cmath>

#include "pipeline/io/trajectory_io.h"

namespace nightmap {

namespace {

const char* NameOfFinish(CeilingFinish finish) {
  switch (finish) {
    case CeilingFinish::kMineral:
      return "mineral";
    case CeilingFinish::kRepeated:
      return "repeated";
    case CeilingFinish::kPlaster:
      return "plaster";
    case CeilingFinish::kBlank:
      return "blank";
    case CeilingFinish::kPaint:
      return "paint";
  }
  return "";
}

const char* NameOfFitting(FittingKind kind) {
  switch (kind) {
    case FittingKind::kLamp:
      return "lamp";
    case FittingKind::kVent:
      return "vent";
    case FittingKind::kSprinkler:
      return "sprinkler";
    case FittingKind::kSmokeDetector:
      return "smoke_detector";
    case FittingKind::kPipe:
      return "pipe";
  }
  return "";
}

nlohmann::ordered_json RectJson(const Rect2& rect) {
  return {{"x0", rect.x0}, {"y0", rect.y0}, {"x1", rect.x1}, {"y1", rect.y1}};
}

}  // namespace

std::vector<RecordingFile> CeilingListsAndTruth(const CeilingRecording& recording) {
  const std::string columns = "; time_s tx ty tz qx qy qz qw";
  return {{"rgb.txt", FileList(recording.building_from_robot, "rgb", "jpg")},
          {"odometry.csv", CeilingOdometryCsv(recording.odometry)},
          {"robot_groundtruth.txt",
           TrajectoryToTum(recording.building_from_robot, "building_from_robot" + columns)},
          {"camera_groundtruth.txt",
           TrajectoryToTum(recording.building_from_camera, "building_from_camera" + columns)},
          {"truth/ceiling.json", TrueCeilingJson(recording.world.plan)}};
}

std::string CeilingOdometryCsv(const WheelOdometry& odometry) {
  std::string csv = "time_s,x_m,y_m,heading_rad\n";
  for (std::size_t i = 0; i < odometry.Samples().size(); ++i) {
    const Eigen::Vector3d& pose = odometry.Samples()[i];
    const std::int64_t time_ns = kFirstCeilingFrame_ns + std::llround(odometry.TimeOf_s(i) * 1e9);
    csv += fmt::format(
        "{},{:.6f},{:.6f},{:.7f}\n", TimeToString(time_ns), pose.x(), pose.y(), pose.z());
  }
  return csv;
}

std::string TrueCeilingJson(const CeilingPlan& plan) {
  nlohmann::ordered_json json;
  json["format"] = "nightmap_true_ceiling";
  json["version"] = 1;
  json["units"] = "metres; building frame: z up, floor z = 0";
  json["rectangles"] = nlohmann::ordered_json::array();
  for (const CeilingRect& rect : plan.rects) {
    nlohmann::ordered_json item = RectJson(rect.area);
    item["height_m"] = rect.height_m;
    item["finish"] = NameOfFinish(rect.finish);
    json["rectangles"].push_back(item);
  }
  json["fittings"] = nlohmann::ordered_json::array();
  for (const CeilingFitting& fitting : plan.fittings) {
    nlohmann::ordered_json item = {{"kind", NameOfFitting(fitting.kind)}};
    item.update(RectJson(fitting.area));
    json["fittings"].push_back(item);
  }
  json["blank"] = nullptr;
  if (plan.blank.Area() > 0) json["blank"] = RectJson(plan.blank);
  return json.dump(1) + "\n";
}

void ClearCeilingRecording(const std::filesystem::path& summary) {
  const std::filesystem::path pictures = summary.parent_path() / "rgb";
  TakeRecordingFolder(summary, std::filesystem::exists(pictures));
  std::filesystem::remove_all(pictures);
  std::filesystem::create_directories(pictures);
}

void RenderCeilingInto(const std::filesystem::path& folder,
                       const SynthesizeCeilingOptions& options,
                       const CeilingRecording& recording,
                       Progress& progress,
                       int num_threads) {
  const WritingFolder writing(folder);
  const auto sink = [&](std::size_t idx, const ColorImage& picture) {
    WriteAtomically(folder / "rgb" / fmt::format("{:06}.jpg", idx),
                    writing,
                    [&](const std::filesystem::path& path) { WriteJpeg(path, picture); });
  };
  RunSynthesizeCeiling(options, recording, sink, progress, num_threads);
}

}  // namespace nightmap
