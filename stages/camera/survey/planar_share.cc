// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/survey/planar_share.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "pipeline/base/random.h"

namespace nightmap {
namespace {

constexpr int kColumns = 54;                            // of the sampled grid
constexpr float kNearest_m = 0.4F, kFarthest_m = 6.0F;  // beyond, noise bends surfaces
constexpr std::size_t kMinSamples = 200;
constexpr int kTriples = 150;

struct Samples {
  std::vector<Eigen::Vector3d> rays;  // x, y, 1
  std::vector<double> inverse_per_m;  // of z
};

Samples SamplesOf(const DepthImage& depth, const Camera& camera) {
  Samples samples;
  const int step = std::max(1, depth.width / kColumns);
  for (int y = step / 2; y < depth.height; y += step) {
    for (int x = step / 2; x < depth.width; x += step) {
      const float z = depth.At(x, y);
      if (z < kNearest_m || z > kFarthest_m) continue;
      samples.rays.push_back(camera.BackProject(Eigen::Vector2d(x, y), 1));
      samples.inverse_per_m.push_back(1 / z);
    }
  }
  return samples;
}

// Tolerance for a depth sensor's noise and a surface's unevenness: 1 % and 3 mm per m.
double Tolerance(double inverse_per_m) { return 0.01 * inverse_per_m + 0.003; }

bool IsOn(const Samples& samples, std::size_t i, const Eigen::Vector3d& plane) {
  return std::abs(plane.dot(samples.rays[i]) - samples.inverse_per_m[i]) <
         Tolerance(samples.inverse_per_m[i]);
}

int CountOn(const Samples& samples, const Eigen::Vector3d& plane) {
  int count = 0;
  for (std::size_t i = 0; i < samples.rays.size(); ++i) count += IsOn(samples, i, plane) ? 1 : 0;
  return count;
}

Eigen::Vector3d Refit(const Samples& samples, const Eigen::Vector3d& plane) {
  Eigen::Matrix3d normal = 1e-9 * Eigen::Matrix3d::Identity();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (std::size_t i = 0; i < samples.rays.size(); ++i) {
    if (!IsOn(samples, i, plane)) continue;
    const double weight = std::pow(Tolerance(samples.inverse_per_m[i]), -2);
    normal += weight * samples.rays[i] * samples.rays[i].transpose();
    right += weight * samples.inverse_per_m[i] * samples.rays[i];
  }
  return normal.ldlt().solve(right);
}

using Triple = std::array<std::size_t, 3>;

double ShareOnBestPlane(const Samples& samples, const std::vector<Triple>& triples) {
  int most = 0;
  Eigen::Vector3d best = Eigen::Vector3d::Zero();
  for (const Triple& triple : triples) {
    Eigen::Matrix3d rays;
    Eigen::Vector3d inverse;
    for (int i = 0; i < 3; ++i) {
      rays.row(i) = samples.rays[triple[static_cast<std::size_t>(i)]];
      inverse[i] = samples.inverse_per_m[triple[static_cast<std::size_t>(i)]];
    }
    if (std::abs(rays.determinant()) < 1e-3) continue;
    const Eigen::Vector3d plane = rays.inverse() * inverse;
    const int count = CountOn(samples, plane);
    if (count <= most) continue;
    most = count;
    best = plane;
  }
  for (int round = 0; round < 3; ++round) best = Refit(samples, best);
  return std::max(most, CountOn(samples, best)) / static_cast<double>(samples.rays.size());
}

}  // namespace

PlanarShares MeasurePlanarShares(const DepthImage& depth,
                                 const Camera& camera,
                                 bool is_along_ray,
                                 std::uint64_t seed) {
  const Samples declared = SamplesOf(depth, camera);
  if (declared.rays.size() < kMinSamples) return {};
  Samples other = declared;
  for (std::size_t i = 0; i < other.rays.size(); ++i) {
    const double length = other.rays[i].norm();
    other.inverse_per_m[i] *= is_along_ray ? 1 / length : length;
  }
  Random random(seed);
  std::vector<Triple> triples(kTriples);
  for (Triple& triple : triples) {
    for (std::size_t& i : triple) i = random.Index(declared.rays.size());
  }
  return {ShareOnBestPlane(declared, triples), ShareOnBestPlane(other, triples)};
}

}  // namespace nightmap
