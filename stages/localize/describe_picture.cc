// SPDX-License-Identifier: Apache-2.0
#include "stages/localize/describe_picture.h"

#include <algorithm>
#include <new>
#include <opencv2/core.hpp>

#include "pipeline/base/error.h"
#include "pipeline/vision/resize_picture.h"

namespace nightmap {
namespace {

// Of the cameras' focal lengths; 0 without any.
double MedianFocal_px(const std::vector<RgbdCamera>& cameras) {
  if (cameras.empty()) return 0;
  std::vector<double> focals_px;
  for (const RgbdCamera& camera : cameras) focals_px.push_back(camera.color.fx);
  const auto middle = focals_px.begin() + static_cast<std::ptrdiff_t>(focals_px.size() / 2);
  std::nth_element(focals_px.begin(), middle, focals_px.end());
  return *middle;
}

// As fine as the map's pictures, when it is much finer.
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
  std::string problem;
  try {
    const CameraPicture picture = FitToMap({input.load_color(query, camera), camera.color},
                                           input.map_cameras,
                                           options.max_focal_ratio);
    return {ExtractFeatures(picture.color, picture.camera, input.extraction), picture.camera, ""};
  } catch (const DataError& error) {
    problem = error.what();
  } catch (const cv::Exception& error) {  // as when there is no memory for so large a picture
    problem = fmt::format("{}: OpenCV: {}", query.color_path, error.err);
  } catch (const std::bad_alloc&) {
    problem = fmt::format("{}: does not fit into memory", query.color_path);
  }
  return {{}, camera.color, problem};
}

}  // namespace nightmap
