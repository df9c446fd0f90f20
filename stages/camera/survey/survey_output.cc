// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/survey_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <set>

namespace nightmap {
namespace {

constexpr int kMaskMargin_px = 1;  // of reduced pixels

std::string DepthFields(const FrameMeasures& own, const FrameRecord& frame) {
  if (frame.depth.path.empty()) return ",,,,,";
  if (own.measured_share == 0) return "0,,,,,";
  return fmt::format("{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}",
                     own.measured_share,
                     own.depth_p10_m,
                     own.depth_median_m,
                     own.depth_p90_m,
                     own.planar.as_declared,
                     own.planar.otherwise);
}

std::string PairFields(const PairMeasures& pair) {
  if (!pair.has_previous) return ",,,,";
  return fmt::format("{},{},{:.4f},{:.2f},{:.4f}",
                     pair.same_color ? 1 : 0,
                     pair.same_depth ? 1 : 0,
                     pair.tracked_share,
                     pair.flow_px,
                     pair.gain);
}

std::string MaskFileName(std::size_t camera_idx) { return fmt::format("mask_{}.png", camera_idx); }

nlohmann::json FixedPartsJson(const std::vector<FixedParts>& all,
                              const std::vector<RgbdCamera>& cameras) {
  nlohmann::json list = nlohmann::json::array();
  for (std::size_t i = 0; i < all.size(); ++i) {
    const auto& pixels = all[i].mask.pixels;
    const auto num_fixed = static_cast<double>(std::ranges::count(pixels, 255));
    nlohmann::json parts = {
        {"camera_id", cameras[i].camera_id},
        {"num_views", all[i].num_views},
        {"share", pixels.empty() ? 0 : num_fixed / static_cast<double>(pixels.size())}};
    if (!pixels.empty()) parts["mask"] = MaskFileName(i);
    list.push_back(std::move(parts));
  }
  return list;
}

}  // namespace

std::string SurveyToCsv(const SurveyResult& result, const std::vector<FrameRecord>& frames) {
  std::string text =
      "frame_idx,time_ns,sequence_idx,brightness,dark_share,bright_share,blur_px,textured_share,"
      "measured_share,depth_p10_m,depth_median_m,depth_p90_m,planar_share,planar_share_otherwise,"
      "same_color,same_depth,tracked_share,"
      "flow_px,gain\n";
  for (const SurveyedFrame& surveyed : result.frames) {
    const FrameRecord& frame = frames[surveyed.frame];
    text += fmt::format("{},{},{},{:.2f},{:.4f},{:.4f},{:.3f},{:.4f},{},{}\n",
                        frame.frame_idx,
                        frame.time_ns,
                        frame.sequence_idx,
                        surveyed.own.brightness,
                        surveyed.own.dark_share,
                        surveyed.own.bright_share,
                        surveyed.own.blur_px,
                        surveyed.own.textured_share,
                        DepthFields(surveyed.own, frame),
                        PairFields(surveyed.to_previous));
  }
  return text;
}

void WriteMasks(const std::vector<FixedParts>& fixed_parts,
                const std::vector<RgbdCamera>& cameras,
                StageContext& context) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < fixed_parts.size(); ++i) {
    const GrayImage& mask = fixed_parts[i].mask;
    if (mask.pixels.empty()) continue;
    const Camera camera = cameras[i].Picture();
    names.insert(MaskFileName(i));
    WritePng(context.OutputBeside("frames", MaskFileName(i)),
             EnlargeMask(mask, camera.width, camera.height, kMaskMargin_px));
  }
  const auto folder = std::filesystem::absolute(context.FinalPath("frames")).parent_path();
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    const bool is_mask = name.starts_with("mask_") && name.ends_with(".png");
    if (is_mask && !names.contains(name)) std::filesystem::remove(entry.path());
  }
}

nlohmann::json Summarize(const SurveyResult& result,
                         const std::vector<FrameRecord>& frames,
                         const std::vector<RgbdCamera>& cameras) {
  nlohmann::json windows = nlohmann::json::array();
  const BestShift best = FindBestShift(result.alignments);
  for (std::size_t i = 0; i < result.alignments.size(); ++i) {
    const DepthAlignment& window = result.alignments[i];
    windows.push_back({{"first_frame_idx", frames[window.first_frame].frame_idx},
                       {"num_edges", window.num_edges},
                       {"by_frame_offset", window.by_frame_offset},
                       {"at_best_shift", best.at_best[i]},
                       {"at_no_shift", best.at_zero[i]}});
  }
  return {{"num_frames", frames.size()},
          {"num_frames_surveyed", result.frames.size()},
          {"alignment",
           {{"best_shift_x", best.shift.x / kSmallWidth_px},
            {"best_shift_y", best.shift.y / kSmallWidth_px},
            {"windows", std::move(windows)}}},
          {"fixed_parts", FixedPartsJson(result.fixed_parts, cameras)}};
}

}  // namespace nightmap
