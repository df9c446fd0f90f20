// SPDX-License-Identifier: Apache-2.0
#include "stages/world/synthesize/mislabel_things.h"

#include <algorithm>

#include "pipeline/base/random.h"
#include "pipeline/world/true_things.h"

namespace nightmap {

namespace {

constexpr std::uint64_t kMislabelStream = 403;

SurfaceLabel LabelInPicture(const Surface& surface,
                            double mislabelled_ratio,
                            std::uint64_t noise_seed) {
  if (surface.piece_idx < 0 || !IsThingLabel(surface.label)) return surface.label;
  const int thing = surface.piece_idx * kNumSurfaceLabels + static_cast<int>(surface.label);
  Random random(noise_seed, kMislabelStream, static_cast<std::uint64_t>(thing));
  if (random.Uniform() >= mislabelled_ratio) return surface.label;
  std::array<SurfaceLabel, kThingLabels.size() - 1> others{};
  std::ranges::remove_copy(kThingLabels, others.begin(), surface.label);
  return others[random.Index(others.size())];
}

}  // namespace

void MislabelThings(const Scene& scene,
                    double mislabelled_ratio,
                    std::uint64_t noise_seed,
                    RenderedFrame& frame) {
  if (mislabelled_ratio <= 0) return;
  for (std::size_t i = 0; i < frame.labels.pixels.size(); ++i) {
    const std::int32_t surface_idx = frame.surface_idx.pixels[i];
    if (surface_idx < 0) continue;
    const Surface& surface = scene.surfaces[static_cast<std::size_t>(surface_idx)];
    frame.labels.pixels[i] =
        static_cast<std::uint8_t>(LabelInPicture(surface, mislabelled_ratio, noise_seed));
  }
}

}  // namespace nightmap
