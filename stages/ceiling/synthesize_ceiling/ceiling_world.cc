// SPDX-License-Identifier: Apache-2.0
#include "stages/ceiling/synthesize_ceiling/ceiling_world.h"

#include <utility>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kTintStream = 703;

Eigen::Vector3f TintOf(const CeilingRect& rect, int face, int seed) {
  const float strength = face == kCeilingFace ? 0.03F : 0.12F;
  if (rect.finish == CeilingFinish::kBlank) return Eigen::Vector3f::Ones();
  // All walls of a rectangle have one paint.
  const auto stream = static_cast<std::uint64_t>(2 * rect.look + (face == kCeilingFace ? 1 : 0));
  Random random(static_cast<std::uint64_t>(seed), kTintStream, stream);
  Eigen::Vector3f tint;
  for (float& channel : tint) channel = 1 - strength * static_cast<float>(random.Uniform());
  return tint;
}

}  // namespace

CeilingWorld PaintCeilingWorld(CeilingPlan plan, int seed, int num_threads) {
  CeilingWalk walk(plan);
  std::vector<CeilingFaceLook> faces(plan.rects.size() * kNumFaces);
  ParallelFor(faces.size(), num_threads, [&](std::size_t i) {
    const int face = static_cast<int>(i % kNumFaces);
    const int rect_idx = static_cast<int>(i / kNumFaces);
    const CeilingRect& rect = plan.rects[i / kNumFaces];
    faces[i].raster =
        face == kCeilingFace ? PaintCeiling(plan, rect_idx, seed) : PaintWall(rect, face, seed);
    faces[i].raster.Finish();
    faces[i].tint = TintOf(rect, face, seed);
  });
  return {std::move(plan), std::move(walk), std::move(faces)};
}

}  // namespace nightmap
