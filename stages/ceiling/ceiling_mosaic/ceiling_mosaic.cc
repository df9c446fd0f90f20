// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/ceiling_mosaic/ceiling_mosaic.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/base/parallel.h"
#include "pipeline/io/frame_failure.h"
#include "stages/ceiling/ceiling_mosaic/ceiling_heights.h"
#include "stages/ceiling/ceiling_mosaic/counted_median.h"
#include "stages/ceiling/ceiling_mosaic/weighted_color.h"

namespace nightmap {
namespace {

constexpr double kHeightRadius_m = 0.6;  // landmarks so near tell the height of the ceiling
constexpr int kBlock_px = 512;
// A view's weight falls with the distance from its middle as a Gaussian of this share of its half
// height, so that the nearest views decide.
constexpr double kWeightShare = 0.4;
constexpr double kMinWeight = 1e-3;
constexpr double kMaxAngle_rad = 1.3;  // between the up direction and the border of a view

struct Block {
  int x = 0, y = 0, width = 0, height = 0;  // px
};

// Bilinear; `pixel` is within the image.
Rgb Interpolate(const ColorImage& image, const Eigen::Vector2d& pixel) {
  Rgb color;
  const int x = std::min(static_cast<int>(pixel.x()), image.width - 2);
  const int y = std::min(static_cast<int>(pixel.y()), image.height - 2);
  const double right = pixel.x() - x, down = pixel.y() - y;
  for (int channel = 0; channel < 3; ++channel) {
    const double top = (1 - right) * image.At(x, y, channel) + right * image.At(x + 1, y, channel);
    const double bottom =
        (1 - right) * image.At(x, y + 1, channel) + right * image.At(x + 1, y + 1, channel);
    color[static_cast<std::size_t>(channel)] = (1 - down) * top + down * bottom;
  }
  return color;
}

// How far from below its camera a view shows the ceiling.
double Reach_m(const Camera& camera, double height_m) {
  double reach = 0;
  for (const double x : {0.0, camera.width - 1.0}) {
    for (const double y : {0.0, camera.height - 1.0}) {
      reach = std::max(reach, camera.Normalize({x, y}).norm());
    }
  }
  return std::min(reach, std::tan(kMaxAngle_rad)) * height_m;
}

class MosaicMaker {
 public:
  MosaicMaker(const CeilingMosaicOptions& options, const CeilingMosaicInput& input)
      : input_(input), resolution_m_(options.resolution_m) {
    double highest_m = 0, lowest_camera_m = 1e9;
    for (const auto& landmark : input.landmarks) highest_m = std::max(highest_m, landmark.z());
    for (const CeilingView& view : input.views) {
      lowest_camera_m = std::min(lowest_camera_m, view.map_from_camera.translation.z());
    }
    if (highest_m <= lowest_camera_m) {
      throw InputError({{"map"}},
                       InputError::Remedy::kInText,
                       "no landmark is above the camera: correct robot_from_camera of the "
                       "[[camera]] in the site config");
    }
    reach_m_ = Reach_m(input.camera, highest_m - lowest_camera_m);
    Eigen::Array2d low = Eigen::Array2d::Constant(1e9), high = -low;
    for (const CeilingView& view : input.views) {
      const Eigen::Array2d place = view.map_from_camera.translation.head<2>().array();
      low = low.min(place - reach_m_);
      high = high.max(place + reach_m_);
    }
    FitResolution(options, (high - low).maxCoeff());
    mosaic_.resolution_m = resolution_m_;
    mosaic_.origin = ((low / resolution_m_).floor() * resolution_m_).matrix();
    const Eigen::Array2d size = ((high - mosaic_.origin.array()) / resolution_m_).ceil();
    mosaic_.picture = {static_cast<int>(size.x()), static_cast<int>(size.y()), 3, {}};
    mosaic_.picture.pixels.assign(
        static_cast<std::size_t>(size.x()) * static_cast<std::size_t>(size.y()) * 3, 0);
    heights_ = std::make_unique<CeilingHeights>(
        input.landmarks, kHeightRadius_m, low.matrix(), high.matrix());
  }

  CeilingMosaic Make(Progress& progress, int num_threads) {
    const std::vector<Block> blocks = Blocks();
    std::vector<CountedMedian> deviations(blocks.size());
    std::vector<std::size_t> num_covered(blocks.size());
    std::vector<std::map<std::size_t, std::string>> failures(blocks.size());
    progress.Start(blocks.size());
    ParallelFor(blocks.size(), num_threads, [&](std::size_t i) {
      num_covered[i] = Draw(blocks[i], &deviations[i], &failures[i]);
      progress.Advance();
    });
    progress.Finish();
    CountedMedian all;
    std::map<std::size_t, std::string> failed;  // by view
    std::size_t covered = 0;
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      all.Add(deviations[i]);
      covered += num_covered[i];
      failed.merge(failures[i]);
    }
    for (const auto& [view, failure] : failed) mosaic_.skipped.push_back(failure);
    mosaic_.covered_m2 = static_cast<double>(covered) * resolution_m_ * resolution_m_;
    mosaic_.median_deviation = all.Get();
    return std::move(mosaic_);
  }

 private:
  // A night does not end because its ceiling is wide. The corner of the picture is rounded down to
  // a pixel.
  void FitResolution(const CeilingMosaicOptions& options, double widest_m) {
    const double finest_m = widest_m / (options.max_edge_px - 1);
    if (resolution_m_ >= finest_m) return;
    resolution_m_ = finest_m;
    spdlog::warn(
        "a ceiling {:.0f} m wide has more than ceiling_mosaic.max_edge_px = {} pixels of {} m: its "
        "picture has pixels of {:.4f} m",
        widest_m,
        options.max_edge_px,
        options.resolution_m,
        resolution_m_);
  }

  std::vector<Block> Blocks() const {
    const ColorImage& picture = mosaic_.picture;
    std::vector<Block> blocks;
    for (int y = 0; y < picture.height; y += kBlock_px) {
      for (int x = 0; x < picture.width; x += kBlock_px) {
        blocks.push_back({x,
                          y,
                          std::min(kBlock_px, picture.width - x),
                          std::min(kBlock_px, picture.height - y)});
      }
    }
    return blocks;
  }

  Eigen::Vector2d PlaceOf(int x, int y) const {
    return mosaic_.origin +
           resolution_m_ * Eigen::Vector2d(x + 0.5, mosaic_.picture.height - y - 0.5);
  }

  bool Reaches(const CeilingView& view, const Block& block) const {
    const Eigen::Vector2d low = PlaceOf(block.x, block.y + block.height - 1);
    const Eigen::Vector2d high = PlaceOf(block.x + block.width - 1, block.y);
    const Eigen::Vector2d place = view.map_from_camera.translation.head<2>();
    return (place - place.cwiseMax(low).cwiseMin(high)).norm() <= reach_m_;
  }

  // The part of a block, from its corner, that a view may show.
  Block Reached(const CeilingView& view, const Block& block) const {
    const Eigen::Vector2d away_m =
        view.map_from_camera.translation.head<2>() - PlaceOf(block.x, block.y);
    const auto pixel = [&](double offset_m, int size) {
      return static_cast<int>(std::clamp(offset_m / resolution_m_, 0.0, static_cast<double>(size)));
    };
    Block reached;
    reached.x = pixel(away_m.x() - reach_m_, block.width);
    reached.y = pixel(-away_m.y() - reach_m_, block.height);
    reached.width = pixel(away_m.x() + reach_m_ + resolution_m_, block.width) - reached.x;
    reached.height = pixel(-away_m.y() + reach_m_ + resolution_m_, block.height) - reached.y;
    return reached;
  }

  void AddView(const CeilingView& view,
               const ColorImage& image,
               const Block& block,
               std::vector<WeightedColor>* sums) const {
    const Rigid3 camera_from_map = view.map_from_camera.Inverse();
    const Camera& camera = input_.camera;
    const double sigma_px = kWeightShare * 0.5 * camera.height;
    const double max_z = std::cos(kMaxAngle_rad);
    const Block reached = Reached(view, block);
    for (int y = reached.y; y < reached.y + reached.height; ++y) {
      for (int x = reached.x; x < reached.x + reached.width; ++x) {
        const Eigen::Vector2d place = PlaceOf(block.x + x, block.y + y);
        const Eigen::Vector3d point =
            camera_from_map * Eigen::Vector3d(place.x(), place.y(), heights_->At_m(place));
        if (point.z() < max_z * point.norm()) continue;
        const auto pixel = camera.Project(point);
        if (!pixel || !camera.Contains(*pixel)) continue;
        const double away_px = std::hypot(pixel->x() - camera.cx, pixel->y() - camera.cy);
        const double weight = kMinWeight + std::exp(-0.5 * std::pow(away_px / sigma_px, 2));
        (*sums)[static_cast<std::size_t>(y * block.width + x)].Add(weight,
                                                                   Interpolate(image, *pixel));
      }
    }
  }

  // The number of pixels that a view saw, and the deviations of those that several saw.
  std::size_t Draw(const Block& block,
                   CountedMedian* deviations,
                   std::map<std::size_t, std::string>* failures) {
    std::vector<WeightedColor> sums(static_cast<std::size_t>(block.width) *
                                    static_cast<std::size_t>(block.height));
    for (std::size_t i = 0; i < input_.views.size(); ++i) {
      const CeilingView& view = input_.views[i];
      if (!Reaches(view, block)) continue;
      ColorImage image;
      const std::string failure = FrameFailure(fmt::format("frame {}", view.frame),
                                               [&] { image = input_.load(view.frame); });
      if (failure.empty()) {
        AddView(view, image, block, &sums);
      } else {
        failures->emplace(i, failure);
      }
    }
    std::size_t num_covered = 0;
    for (int y = 0; y < block.height; ++y) {
      for (int x = 0; x < block.width; ++x) {
        const WeightedColor& sum = sums[static_cast<std::size_t>(y * block.width + x)];
        if (sum.NumViews() == 0) continue;
        ++num_covered;
        const Rgb mean = sum.Mean();
        for (int channel = 0; channel < 3; ++channel) {
          mosaic_.picture.At(block.x + x, block.y + y, channel) = static_cast<std::uint8_t>(
              std::lround(std::clamp(mean[static_cast<std::size_t>(channel)], 0.0, 255.0)));
        }
        if (sum.NumViews() > 1) deviations->Add(sum.Deviation());
      }
    }
    return num_covered;
  }

  const CeilingMosaicInput& input_;
  double resolution_m_;
  double reach_m_ = 0;
  std::unique_ptr<CeilingHeights> heights_;
  CeilingMosaic mosaic_;
};

}  // namespace

CeilingMosaic RunCeilingMosaic(const CeilingMosaicOptions& options,
                               const CeilingMosaicInput& input,
                               Progress& progress,
                               int num_threads) {
  if (input.landmarks.empty() || input.views.empty()) {
    throw InputError(
        {{"map"}}, InputError::Remedy::kInText, "has no landmark: the ceiling's height is unknown");
  }
  return MosaicMaker(options, input).Make(progress, num_threads);
}

}  // namespace nightmap
