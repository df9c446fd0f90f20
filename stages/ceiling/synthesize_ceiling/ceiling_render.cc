// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/ceiling_render.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "pipeline/base/error.h"

namespace nightmap {

namespace {

constexpr int kEdgeSamples = 16;

// Rays of one pose, and what they show.
class CeilingView {
 public:
  CeilingView(const CeilingWorld& world, const Camera& camera, const Rigid3& pose)
      : world_(world),
        rect_(world.plan.RectAt(pose.translation.x(), pose.translation.y())),
        origin_(pose.translation),
        pixel_m_(1 / camera.fx) {
    const Eigen::Matrix3d rotation = pose.rotation.toRotationMatrix();
    per_x_ = rotation.col(0) / camera.fx;
    per_y_ = rotation.col(1) / camera.fy;
    first_ = rotation.col(2) - camera.cx * per_x_ - camera.cy * per_y_;
  }

  // Brightness before the face's tint at a place in the picture; sets the face that it shows, -1
  // for none.
  float At(double x, double y, double num_pixels, int* face) const {
    const Eigen::Vector3d direction = first_ + x * per_x_ + y * per_y_;
    const CeilingHit hit = world_.walk.Cast(rect_, origin_, direction);
    *face = hit.rect < 0 ? -1 : hit.FaceIdx();
    if (hit.rect < 0) return 0;
    // t is the depth, since z of the ray is 1 in the camera. A face at a slant is filtered as its
    // longer extent needs.
    double footprint_m = num_pixels * hit.t * pixel_m_;
    if (hit.face != kCeilingFace) {
      const double slant = std::abs(hit.face < 2 ? direction.x() : direction.y());
      footprint_m /= std::clamp(slant, 0.05, 1.0);
    }
    const CeilingFaceLook& look = world_.faces[static_cast<std::size_t>(*face)];
    return look.raster.Sample(hit.at.x(), hit.at.y(), footprint_m);
  }
  Eigen::Vector3f Tint(int face) const {
    if (face < 0) return Eigen::Vector3f::Zero();
    return world_.faces[static_cast<std::size_t>(face)].tint;
  }

 private:
  const CeilingWorld& world_;
  int rect_;
  Eigen::Vector3d origin_;
  double pixel_m_;  // width of a pixel at a depth of 1 m
  Eigen::Vector3d first_, per_x_, per_y_;
};

// Reverses the lowest bits: spreads samples over both axes (Hammersley's points).
int Reversed(int value, int count) {
  int reversed = 0;
  for (int bit = 1; bit < count; bit *= 2, value /= 2) reversed = 2 * reversed + value % 2;
  return reversed;
}

// Whether a neighbour of pixel (x, y) shows another face.
bool IsAtBorder(const std::vector<int>& faces, int width, int height, int x, int y) {
  const int* face = faces.data() + static_cast<std::ptrdiff_t>(y) * width + x;
  return (x > 0 && face[-1] != *face) || (x + 1 < width && face[1] != *face) ||
         (y > 0 && face[-width] != *face) || (y + 1 < height && face[width] != *face);
}

// Mean over the samples that time `slot` of `num_slots` has in a pixel, so that all times together
// have kEdgeSamples at different places.
Eigen::Vector3f EdgePixel(const CeilingView& view, int x, int y, int slot, int num_slots) {
  const int count = kEdgeSamples / num_slots;
  const double shift_x = (slot + 0.5) / num_slots;
  const double shift_y = (Reversed(slot, num_slots) + 0.5) / num_slots;
  Eigen::Vector3f sum = Eigen::Vector3f::Zero();
  for (int i = 0; i < count; ++i) {
    const double u = x - 0.5 + (i + shift_x) / count;
    const double v = y - 0.5 + (Reversed(i, count) + shift_y) / count;
    int face = 0;
    const float brightness = view.At(u, v, 1, &face);
    sum += brightness * view.Tint(face);
  }
  return sum / static_cast<float>(count);
}

void AddView(const CeilingView& view, int slot, int num_slots, Image<float>& image) {
  std::vector<int> faces(static_cast<std::size_t>(image.width) *
                         static_cast<std::size_t>(image.height));
  std::vector<float> brightness(faces.size());
  std::size_t i = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, ++i) brightness[i] = view.At(x, y, 1, &faces[i]);
  }
  const float weight = 1.0F / static_cast<float>(num_slots);
  float* sum = image.pixels.data();
  i = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x, ++i, sum += 3) {
      const bool is_edge = IsAtBorder(faces, image.width, image.height, x, y);
      const Eigen::Vector3f color = is_edge ? EdgePixel(view, x, y, slot, num_slots)
                                            : Eigen::Vector3f(brightness[i] * view.Tint(faces[i]));
      for (int c = 0; c < 3; ++c) sum[c] += weight * color[c];
    }
  }
}

}  // namespace

Image<float> RenderCeiling(const CeilingWorld& world,
                           const Camera& camera,
                           const std::vector<Rigid3>& building_from_camera) {
  const int num_slots = static_cast<int>(building_from_camera.size());
  if (num_slots != 1 && num_slots != 2 && num_slots != 4) {
    throw UsageError("{} times within an exposure: give 1, 2 or 4", num_slots);
  }
  Image<float> image{camera.width, camera.height, 3, {}};
  image.pixels.assign(
      3 * static_cast<std::size_t>(camera.width) * static_cast<std::size_t>(camera.height), 0.0F);
  for (int slot = 0; slot < num_slots; ++slot) {
    const Rigid3& pose = building_from_camera[static_cast<std::size_t>(slot)];
    AddView(CeilingView(world, camera, pose), slot, num_slots, image);
  }
  return image;
}

double MeterCeiling(const CeilingWorld& world, const Camera& camera, const Rigid3& pose) {
  constexpr int kColumns = 32, kRows = 24;
  constexpr float kBrightest = 900;
  const CeilingView view(world, camera, pose);
  const double step_x = static_cast<double>(camera.width) / kColumns;
  const double step_y = static_cast<double>(camera.height) / kRows;
  double sum = 0;
  for (int row = 0; row < kRows; ++row) {
    for (int column = 0; column < kColumns; ++column) {
      int face = 0;
      const double x = (column + 0.5) * step_x - 0.5;
      const double y = (row + 0.5) * step_y - 0.5;
      const float brightness = view.At(x, y, step_x, &face);
      sum += std::min(kBrightest, brightness * view.Tint(face).mean());
    }
  }
  return sum / (kColumns * kRows);
}

}  // namespace nightmap
