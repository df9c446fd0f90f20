// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_tracks/new_corners.h"

#include <algorithm>
#include <array>

#include "pipeline/camera/pixel_grid.h"

namespace nightmap {
namespace {

constexpr int kColumns = 8, kRows = 6;

// The tracks of a picture, old and new, by cell.
class Cover {
 public:
  Cover(const Camera& camera, double min_distance_px)
      : camera_(camera), min_distance_px_(min_distance_px), near_(camera, min_distance_px) {}

  void Add(const Eigen::Vector2f& pixel) {
    near_.Add(pixel.cast<double>(), static_cast<int>(pixels_.size()));
    pixels_.push_back(pixel);
    ++num_of_cell_[CellOf(pixel)];
  }
  int NumTracks() const { return static_cast<int>(pixels_.size()); }
  int NumInCellOf(const Eigen::Vector2f& pixel) const { return num_of_cell_[CellOf(pixel)]; }
  bool IsFree(const Eigen::Vector2f& pixel) const {
    bool is_free = true;
    near_.ForNear(pixel.cast<double>(), [&](int i) {
      const Eigen::Vector2f& other = pixels_[static_cast<std::size_t>(i)];
      is_free = is_free && static_cast<double>((other - pixel).norm()) >= min_distance_px_;
    });
    return is_free;
  }

 private:
  static int Part(float coordinate, int size, int count) {
    const float part = coordinate * static_cast<float>(count) / static_cast<float>(size);
    return static_cast<int>(std::clamp(part, 0.0F, static_cast<float>(count - 1)));
  }
  std::size_t CellOf(const Eigen::Vector2f& pixel) const {
    return static_cast<std::size_t>(Part(pixel.y(), camera_.height, kRows) * kColumns +
                                    Part(pixel.x(), camera_.width, kColumns));
  }

  const Camera& camera_;
  double min_distance_px_;
  PixelGrid near_;
  std::vector<Eigen::Vector2f> pixels_;
  std::array<int, static_cast<std::size_t>(kColumns* kRows)> num_of_cell_{};
};

}  // namespace

std::vector<int> ChooseNewCorners(const std::vector<Eigen::Vector2f>& corners,
                                  const std::vector<Eigen::Vector2f>& tracks,
                                  const Camera& camera,
                                  const NewCornerOptions& options) {
  Cover cover(camera, options.min_distance_px);
  for (const Eigen::Vector2f& pixel : tracks) cover.Add(pixel);
  const bool is_redetected = cover.NumTracks() < options.min_tracks;
  std::vector<int> chosen;
  std::vector<bool> is_tried(corners.size());
  std::size_t num_tried = 0;
  for (int in_cell = 0; num_tried < corners.size() && (in_cell == 0 || is_redetected); ++in_cell) {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      if (cover.NumTracks() >= options.max_tracks) break;
      if (is_tried[i] || cover.NumInCellOf(corners[i]) > in_cell) continue;
      is_tried[i] = true;
      ++num_tried;
      if (!cover.IsFree(corners[i])) continue;
      cover.Add(corners[i]);
      chosen.push_back(static_cast<int>(i));
    }
    if (cover.NumTracks() >= options.max_tracks) break;
  }
  std::ranges::sort(chosen);
  return chosen;
}

}  // namespace nightmap
