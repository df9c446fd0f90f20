// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/texture_mesh/find_views.h"

#include <algorithm>
#include <cmath>

namespace nightmap {
namespace {

constexpr double kSigmas = 3;
constexpr double kMinCosine = 0.2;      // to the normal: a view at 78 degrees
constexpr float kEndOfSurface = 0.01F;  // times the score
constexpr double kBorder_px = 1;        // the pixels beside a corner are in the picture

struct Facet {
  Eigen::Vector3d centre_in_map, normal_in_map;
  double half_edge_m = 0;
};

Facet FacetOf(const TileMesh& mesh, const Triangle& triangle) {
  std::array<Eigen::Vector3d, 3> corners;
  for (std::size_t i = 0; i < 3; ++i) {
    corners[i] = mesh.vertices[triangle[i]].position_in_map.cast<double>();
  }
  const auto& [a, b, c] = corners;
  const double edge_m = std::max({(b - a).norm(), (c - b).norm(), (a - c).norm()});
  return {(a + b + c) / 3, (b - a).cross(c - a).normalized(), edge_m / 2};
}

enum class Sight { kHidden, kBehind, kSurface };

class View {
 public:
  View(const RgbdCamera& camera, const Rigid3& map_from_camera, const DepthImage& depth)
      : camera_(camera),
        depth_(depth),
        centre_in_map_(map_from_camera.translation),
        rotation_(map_from_camera.rotation.conjugate().toRotationMatrix()) {}

  // The score of the triangle, 0 where it is not seen.
  float Score(const TileMesh& mesh,
              const Triangle& triangle,
              const Facet& facet,
              double max_range_m,
              double texel_m) const {
    const Eigen::Vector3d ray = facet.centre_in_map - centre_in_map_;
    const double cosine = -ray.dot(facet.normal_in_map) / ray.norm();
    if (!(cosine >= kMinCosine)) return 0;
    const Eigen::Vector3d centre = rotation_ * ray;
    if (centre.z() <= 0 || centre.z() > max_range_m) return 0;
    if (SightOf(centre, facet.half_edge_m) != Sight::kSurface) return 0;
    const double texels = std::min(1.0, texel_m * camera_.color.fx / centre.z());
    auto score = static_cast<float>(cosine * texels * texels);
    for (const std::uint32_t corner : triangle) {
      const Eigen::Vector3d position = mesh.vertices[corner].position_in_map.cast<double>();
      const Sight sight = SightOf(rotation_ * (position - centre_in_map_), facet.half_edge_m);
      if (sight == Sight::kHidden) return 0;
      if (sight == Sight::kBehind) score *= kEndOfSurface;
    }
    return score;
  }

 private:
  Sight SightOf(const Eigen::Vector3d& point, double slack_m) const {
    const auto pixel = camera_.color.Project(point);
    if (!pixel || pixel->x() < kBorder_px || pixel->y() < kBorder_px ||
        pixel->x() > camera_.color.width - 1 - kBorder_px ||
        pixel->y() > camera_.color.height - 1 - kBorder_px) {
      return Sight::kHidden;
    }
    const int at_x = static_cast<int>(std::lround(pixel->x()));
    const int at_y = static_cast<int>(std::lround(pixel->y()));
    const double tolerance_m = kSigmas * camera_.noise.Sigma_m(point.z()) + slack_m;
    Sight sight = Sight::kHidden;
    for (int y = at_y - 1; y <= at_y + 1; ++y) {
      for (int x = at_x - 1; x <= at_x + 1; ++x) {
        const double behind_m = depth_.At(x, y) - point.z();
        if (depth_.At(x, y) <= 0) continue;
        if (behind_m < -tolerance_m) return Sight::kHidden;
        sight = std::max(sight, behind_m <= tolerance_m ? Sight::kSurface : Sight::kBehind);
      }
    }
    return sight;
  }

  const RgbdCamera& camera_;
  const DepthImage& depth_;
  Eigen::Vector3d centre_in_map_;
  Eigen::Matrix3d rotation_;
};

struct Seen {
  std::uint32_t triangle = 0;
  float score = 0;
};

struct SeenInView {
  std::uint32_t view = 0;
  std::vector<Seen> triangles;
};

// Keeps the order of BestViews, when views come in the order of keyframes.
void Insert(TriangleView found, BestViews& best) {
  for (TriangleView& other : best) {
    if (found.score > other.score) std::swap(found, other);
  }
}

}  // namespace

FoundViews FindViews(const TileMesh& mesh,
                     const KeyframeSource& source,
                     double texel_m,
                     Progress& progress,
                     int num_threads) {
  std::vector<Facet> facets(mesh.triangles.size());
  for (std::size_t i = 0; i < facets.size(); ++i) facets[i] = FacetOf(mesh, mesh.triangles[i]);
  KeyframeSource depths = source;
  depths.load = [&](const Keyframe& keyframe) {
    return RgbdImages{{}, source.load_depth(keyframe)};
  };
  FoundViews found;
  found.of_triangles.resize(mesh.triangles.size());
  found.skipped = FuseKeyframes<SeenInView>(
      depths,
      progress,
      num_threads,
      [&](const Keyframe& keyframe, const RgbdImages& images) {
        const View view(source.cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)],
                        keyframe.map_from_camera,
                        images.depth);
        SeenInView seen;
        seen.view = static_cast<std::uint32_t>(&keyframe - depths.keyframes.data());
        for (std::size_t i = 0; i < facets.size(); ++i) {
          const float score =
              view.Score(mesh, mesh.triangles[i], facets[i], source.region.max_range_m, texel_m);
          if (score > 0) seen.triangles.push_back({static_cast<std::uint32_t>(i), score});
        }
        return seen;
      },
      [&](SeenInView&& seen) {
        for (const auto& [triangle, score] : seen.triangles) {
          Insert({seen.view, score}, found.of_triangles[triangle]);
        }
      });
  return found;
}

}  // namespace nightmap
