// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/adjust/adjust_output.h"

#include <cmath>

#include "pipeline/geometry/bundle_report.h"

namespace nightmap {

std::vector<RgbdCamera> CalibratedCameras(const AdjustInput& input, const AdjustResult& result) {
  std::vector<RgbdCamera> cameras = input.cameras;
  for (std::size_t i = 0; i < result.calibrations.size(); ++i) {
    cameras[i].color = cameras[i].color.WithFocalScale(result.calibrations[i].focal_scale);
  }
  return cameras;
}

namespace {

nlohmann::json DepthScales(const AdjustOptions& options, const AdjustResult& result) {
  if (!options.estimate_depth_scales || result.calibrations.empty()) return "not estimated";
  if (result.calibrations.size() == 1) {
    return "one camera: its depth scale and the size of the map are one unknown";
  }
  std::vector<double> scales;
  for (const auto& calibration : result.calibrations) scales.push_back(calibration.depth_scale);
  return scales;
}

nlohmann::json Calibrations(const AdjustOptions& options, const AdjustResult& result) {
  if (!options.calibrate || !options.final_adjustment || result.calibrations.empty()) {
    return "not estimated";
  }
  auto all = nlohmann::json::array();
  for (const CameraCalibration& calibration : result.calibrations) {
    all.push_back({{"focal_scale", calibration.focal_scale},
                   {"rolling_shutter_readout_s", calibration.readout_s}});
  }
  return all;
}

// Only what the pictures determine.
nlohmann::json Offsets(const DepthOffsets& found) {
  auto all = nlohmann::json::array();
  for (std::size_t i = 0; i < found.offset_m.size(); ++i) {
    if (!std::isfinite(found.sigma_m[i])) return "not estimated";
    all.push_back({{"offset_m", found.offset_m[i]}, {"sigma_m", found.sigma_m[i]}});
  }
  if (all.empty()) return "not estimated";
  return all;
}

}  // namespace

nlohmann::json Summarize(const AdjustOptions& options,
                         const AdjustInput& input,
                         const AdjustResult& result) {
  return {{"num_frames", input.frames.size()},
          {"num_keyframes", result.graph.vertices.size()},
          {"num_culled_keyframes", result.num_culled},
          {"num_edges", result.graph.edges.size()},
          {"num_bundle_observations", result.num_bundle_observations},
          {"bundle_rms_px", result.bundle_rms_px},
          {"bundle_adjustments", BundleReport(result.adjustments)},
          {"depth_scales", DepthScales(options, result)},
          {"calibrations", Calibrations(options, result)},
          {"depth_offsets", Offsets(result.depth_offsets)}};
}

}  // namespace nightmap
