// SPDX-License-Identifier: Apache-2.0
#include "stages/localize/describe_picture.h"

#include <algorithm>
#include <utility>

#include "pipeline/base/median.h"
#include "pipeline/features/resize_picture.h"
#include "pipeline/io/frame_failure.h"

namespace nightmap {
namespace {

// Median of the cameras' focal lengths; 0 without any camera.
double MedianFocal_px(const std::vector<RgbdCamera>& cameras) {
  std::vector<double> focals_px;
  for (const RgbdCamera& camera : cameras) focals_px.push_back(camera.color.fx);
  return Median(std::move(focals_px));
}

// Scales a picture that is much finer than the map's down to the map's.
CameraPicture FitToMap(CameraPicture picture,
                       const std::vector<RgbdCamera>& map_cameras,
                       double max_focal_ratio) {
  const double focal_px = MedianFocal_px(map_cameras);
  if (focal_px == 0 || picture.camera.fx <= max_focal_ratio * focal_px) return picture;
  return ShrinkPicture(picture.color, picture.camera, focal_px / picture.camera.fx);
}

}  // namespace

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
