// SPDX-License-Identifier: Apache-2.0
// The eight-coefficient and the fisheye lens of camera.h, against OpenCV's.
#include <gtest/gtest.h>

#include <cmath>
#include <opencv2/calib3d.hpp>

#include "pipeline/base/random.h"
#include "pipeline/geometry/camera.h"

namespace nightmap::lenses_test {

// A lens of about 130 deg from corner to corner.
Camera Fisheye() {
  return {.width = 640,
          .height = 480,
          .fx = 350.1,
          .fy = 351.3,
          .cx = 318.6,
          .cy = 245.3,
          .k1 = -0.0075,
          .k2 = 0.0418,
          .k3 = -0.0394,
          .k4 = 0.0067,
          .lens = Lens::kFisheye};
}

// An Azure Kinect's color camera.
Camera Rational() {
  return {.width = 1280,
          .height = 720,
          .fx = 605.1,
          .fy = 604.9,
          .cx = 638.2,
          .cy = 366.4,
          .k1 = 0.513,
          .k2 = -2.714,
          .p1 = 0.0009,
          .p2 = -0.0002,
          .k3 = 1.587,
          .k4 = 0.389,
          .k5 = -2.533,
          .k6 = 1.511};
}

Camera RandomFisheye(Random* random) {
  Camera camera = Fisheye();
  camera.fx = camera.fy = random->Uniform(380, 700);
  camera.k1 = random->Uniform(-0.05, 0.05);
  camera.k2 = random->Uniform(-0.015, 0.015);
  camera.k3 = random->Uniform(-0.005, 0.005);
  camera.k4 = random->Uniform(-0.001, 0.001);
  return camera;
}

Camera RandomRational(Random* random) {
  Camera camera = Rational();
  camera.fx = camera.fy = random->Uniform(550, 1200);
  for (double Camera::*k : {&Camera::k4, &Camera::k5, &Camera::k6}) {
    camera.*k = random->Uniform(0, 0.5);
  }
  camera.k1 = camera.k4 + random->Uniform(-0.15, 0.15);
  camera.k2 = camera.k5 + random->Uniform(-0.03, 0.03);
  camera.k3 = camera.k6 + random->Uniform(-0.02, 0.02);
  camera.p1 = random->Uniform(-0.003, 0.003);
  camera.p2 = random->Uniform(-0.003, 0.003);
  return camera;
}

void ExpectRoundTripEverywhere(const Camera& camera) {
  for (int y = 0; y < camera.height; y += 12) {
    for (int x = 0; x < camera.width; x += 12) {
      const Eigen::Vector2d pixel(x, y);
      const auto again = camera.Project(camera.BackProject(pixel, 2));
      ASSERT_TRUE(again) << pixel.transpose() << " fx " << camera.fx;
      ASSERT_LT((*again - pixel).norm(), 1e-6) << pixel.transpose() << " fx " << camera.fx;
      ASSERT_TRUE(camera.Sees(pixel));
      const Eigen::Vector2d ray = camera.Normalize(pixel);
      const Eigen::Vector2d undistorted(camera.fx * ray.x() + camera.cx,
                                        camera.fy * ray.y() + camera.cy);
      ASSERT_LT((camera.Undistort(pixel) - undistorted).norm(), 1e-9);
    }
  }
}

TEST(Lenses, DistortUndoesUndistortOverThePicture) {
  Random random(1);
  ExpectRoundTripEverywhere(Fisheye());
  ExpectRoundTripEverywhere(Rational());
  for (int i = 0; i < 40; ++i) ExpectRoundTripEverywhere(RandomFisheye(&random));
  for (int i = 0; i < 40; ++i) ExpectRoundTripEverywhere(RandomRational(&random));
}

// Points of all the field that the camera sees.
std::vector<cv::Point3d> SomePoints(const Camera& camera, Random* random) {
  std::vector<cv::Point3d> points;
  for (int i = 0; i < 500; ++i) {
    const Eigen::Vector3d point = camera.BackProject(
        {random->Uniform(0, camera.width - 1), random->Uniform(0, camera.height - 1)},
        random->Uniform(0.3, 9));
    points.emplace_back(point.x(), point.y(), point.z());
  }
  return points;
}

void ExpectPixels(const Camera& camera,
                  const std::vector<cv::Point3d>& points,
                  const std::vector<cv::Point2d>& pixels) {
  ASSERT_EQ(points.size(), pixels.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto ours = camera.Project({points[i].x, points[i].y, points[i].z});
    ASSERT_TRUE(ours);
    EXPECT_LT((*ours - Eigen::Vector2d(pixels[i].x, pixels[i].y)).norm(), 1e-9);
  }
}

cv::Matx33d Matrix(const Camera& c) { return {c.fx, 0, c.cx, 0, c.fy, c.cy, 0, 0, 1}; }

TEST(Lenses, TheFisheyeIsOpenCvs) {
  Random random(2);
  for (int i = 0; i < 20; ++i) {
    const Camera camera = RandomFisheye(&random);
    const auto points = SomePoints(camera, &random);
    std::vector<cv::Point2d> undistorted, pixels;
    for (const auto& point : points) {
      undistorted.emplace_back(point.x / point.z, point.y / point.z);
    }
    cv::fisheye::distortPoints(
        undistorted, pixels, Matrix(camera), cv::Vec4d(camera.k1, camera.k2, camera.k3, camera.k4));
    ExpectPixels(camera, points, pixels);
  }
}

TEST(Lenses, TheEightCoefficientsAreOpenCvs) {
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    Camera camera = RandomRational(&random);
    const auto points = SomePoints(camera, &random);
    std::vector<cv::Point2d> pixels;
    const std::vector<double> distortion = {
        camera.k1, camera.k2, camera.p1, camera.p2, camera.k3, camera.k4, camera.k5, camera.k6};
    const cv::Vec3d none(0, 0, 0);
    cv::projectPoints(points, none, none, Matrix(camera), distortion, pixels);
    ExpectPixels(camera, points, pixels);
  }
}

// 200 deg across: its circle of 80 deg to each side ends within the picture.
TEST(Lenses, WhatNoPinholeHoldsIsNotSeen) {
  const Camera camera{.width = 640,
                      .height = 480,
                      .fx = 180,
                      .fy = 180,
                      .cx = 320,
                      .cy = 240,
                      .lens = Lens::kFisheye};
  const double end_px = 180 * 80 * M_PI / 180;
  EXPECT_TRUE(camera.Sees({320 + end_px - 0.1, 240}));
  for (const double x : {320 + end_px + 0.1, 320 + 180 * M_PI / 2, 639.0, 1e6}) {
    EXPECT_FALSE(camera.Sees({x, 240})) << x;
    EXPECT_TRUE(camera.Undistort({x, 240}).allFinite()) << x;
    EXPECT_TRUE(camera.BackProject({x, 100}, 1).allFinite()) << x;
  }
  EXPECT_FALSE(camera.Project({std::tan(80.1 / 180 * M_PI), 0, 1}));
  EXPECT_FALSE(camera.Project({1, 0, 0}));
  EXPECT_TRUE(camera.Project({0, 0, 1}));
}

// The polynomial turns at 0.84 rad, and rises again from 1.14 rad on.
TEST(Lenses, APolynomialThatTurnsBackFoldsNothingIntoThePicture) {
  Camera camera = Fisheye();
  camera.k1 = -0.7326;
  camera.k2 = 0.2198;
  camera.k3 = camera.k4 = 0;
  const auto at = [](double angle_rad) { return Eigen::Vector3d(std::tan(angle_rad), 0, 1); };
  EXPECT_TRUE(camera.Project(at(0.8)));
  for (const double angle_rad : {0.9, 1.1, 1.2, 1.35}) {
    EXPECT_FALSE(camera.Project(at(angle_rad))) << angle_rad;
  }
  const double largest = camera.Project(at(0.83))->x();
  EXPECT_TRUE(camera.Sees({largest - 1, camera.cy}));
  EXPECT_FALSE(camera.Sees({largest + 5, camera.cy}));
  EXPECT_EQ(LargestDistortion(camera), std::numeric_limits<double>::infinity());
}

// The quotient has a pole at r = 1, and comes down from above behind it.
TEST(Lenses, AQuotientThatTurnsBackFoldsNothingIntoThePicture) {
  Camera camera = Rational();
  camera.k1 = camera.k2 = camera.k3 = camera.k5 = camera.k6 = camera.p1 = camera.p2 = 0;
  camera.k4 = -1;
  EXPECT_TRUE(camera.Project({0.5, 0, 1}));
  for (const double tangent : {1.0, 1.2, 3.0}) {
    EXPECT_FALSE(camera.Project({tangent, 0, 1})) << tangent;
  }
}

TEST(Lenses, AnotherFocalLengthKeepsTheUndistortedImage) {
  const Camera kinect{
      640, 480, 517.3, 516.5, 318.6, 255.3, 0.2624, -0.9531, -0.0054, 0.0026, 1.1633};
  for (const Camera& camera : {Fisheye(), Rational(), kinect}) {
    for (const double scale : {0.97, 1.02}) {
      const Camera scaled = camera.WithFocalScale(scale);
      EXPECT_NEAR(scaled.fx / camera.fx, scale, 1e-12);
      for (int y = 0; y < camera.height; y += 16) {
        for (int x = 0; x < camera.width; x += 16) {
          const Eigen::Vector2d pixel(x, y);
          const auto there =
              scaled.Project(scaled.BackProjectUndistorted(camera.Undistort(pixel), 1));
          ASSERT_TRUE(there);
          EXPECT_LT((*there - pixel).norm(), 0.01) << x << ' ' << y << " scale " << scale;
        }
      }
    }
  }
}

TEST(Lenses, CoefficientsOfAnotherModelAreFarFromALens) {
  EXPECT_LT(LargestDistortion(Fisheye()), 0.05);
  EXPECT_LT(LargestDistortion(Rational()), 0.1);
  Camera pinholes = Fisheye();  // k1 k2 p1 p2 of a pinhole read as a fisheye's
  pinholes.k1 = 0.2624;
  pinholes.k2 = -0.9531;
  pinholes.k3 = -0.0054;
  pinholes.k4 = 0.0026;
  EXPECT_GT(LargestDistortion(pinholes), 0.5);
}

}  // namespace nightmap::lenses_test
