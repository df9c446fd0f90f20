// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/query_cameras.h"

#include <gtest/gtest.h>

#include "pipeline/base/error.h"

namespace nightmap::query_cameras_test {

RgbdCamera WithFocalLength(double focal_px) {
  RgbdCamera camera;
  camera.color = {640, 480, focal_px, focal_px, 319.5, 239.5};
  return camera;
}

TEST(QueryCameras, ACameraOfTheMapTakesItsCalibrationOthersStay) {
  const std::vector<RgbdCamera> configured = {WithFocalLength(500), WithFocalLength(600)};
  const std::vector<RgbdCamera> calibrated = {WithFocalLength(503), WithFocalLength(595)};
  const auto cameras = WithCalibration(
      {WithFocalLength(600), WithFocalLength(501), WithFocalLength(500)}, configured, calibrated);
  ASSERT_EQ(cameras.size(), 3U);
  EXPECT_EQ(cameras[0].color.fx, 595);
  EXPECT_EQ(cameras[1].color.fx, 501);
  EXPECT_EQ(cameras[2].color.fx, 503);
}

TEST(QueryCameras, RefusesCamerasOfTwoMaps) {
  EXPECT_THROW(WithCalibration({}, {WithFocalLength(500)}, {}), DataError);
}

}  // namespace nightmap::query_cameras_test
