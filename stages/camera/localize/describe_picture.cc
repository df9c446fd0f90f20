// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/describe_picture.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pipeline/base/median.h"
#include "pipeline/io/frame_failure.h"
#include "pipeline/io/resize_picture.h"

namespace nightmap {
namespace {

// Median of the cameras' focal lengths; 0 without any camera.
double MedianFocal_px(const std::vector<RgbdCamera>& cameras) {
  std::vector<double> focals_px;
  for (const RgbdCamera& camera : cameras) focals_px.push_back(camera.color.fx);
  return Median(std::move(focals_px));
}

// Scale at which a picture has no more pixels than the map's, or than maps are made of by default.
double WorkingScale(const Camera& picture, const std::vector<RgbdCamera>& map_cameras) {
  double largest_px2 = 1e6 * kWorking_mpx;
  for (const RgbdCamera& camera : map_cameras) {
    largest_px2 = std::max(largest_px2, 1.0 * camera.color.width * camera.color.height);
  }
  return std::sqrt(largest_px2 / picture.width / picture.height);
}

// Scales a picture that is much finer than the map's down to the map's, and a larger one to the
// size at which it is described.
CameraPicture FitToMap(CameraPicture picture,
                       const std::vector<RgbdCamera>& map_cameras,
                       double max_focal_ratio) {
  const double focal_px = MedianFocal_px(map_cameras);
  const Camera& camera = picture.camera;
  double scale = WorkingScale(camera, map_cameras);
  const bool is_finer = focal_px > 0 && camera.fx > max_focal_ratio * focal_px;
  if (is_finer) scale = std::min(scale, focal_px / camera.fx);
  if (scale >= 1) return picture;
  return ShrinkPicture(picture.color, camera, scale);
}

}  // namespace

ExtractionOptions ExtractionOf(const LandmarkMap& map, const std::string& source) {
  ExtractionOptions extraction;
  RegisterOptions(extraction).ParseToml(map.extraction, source);
  return extraction;
}

DescribedPicture DescribePicture(const LocalizeOptions& options,
                                 const LocalizeInput& input,
                                 const FrameRecord& query) {
  const RgbdCamera& camera = input.cameras[static_cast<std::size_t>(query.camera_idx)];
  DescribedPicture described{{}, {camera.color, camera.focal_sigma_ratio}, ""};
  described.problem = FrameFailure(query.color.path, [&] {
    const CameraPicture picture = FitToMap({input.load_color(query, camera), camera.color},
                                           input.map_cameras,
                                           options.max_focal_ratio);
    described.features = ExtractFeatures(picture.color, picture.camera, input.extraction);
    described.lens.camera = picture.camera;
  });
  return described;
}

}  // namespace nightmap
