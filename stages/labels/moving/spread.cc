// SPDX-License-Identifier: Apache-2.0
#include "stages/labels/moving/spread.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace nightmap {

float Bond(float depth_a_m, float depth_b_m, double max_step) {
  if (depth_a_m <= 0 || depth_b_m <= 0) return 0.1F;
  const float nearer_m = std::min(depth_a_m, depth_b_m);
  return std::abs(depth_a_m - depth_b_m) < static_cast<float>(max_step) * nearer_m ? 1.0F : 0.0F;
}

Image<float> SpreadEvidence(const SpreadOptions& options,
                            const Evidence& evidence,
                            const DepthImage& depth,
                            const Image<float>& decided) {
  constexpr float kDecided = 6;  // against one frame's evidence: as if all frames said so
  const int width = depth.width;
  const int height = depth.height;
  Image<float> own = ZerosLike(depth);     // weighted sum of the pixel's own evidence
  Image<float> weight = ZerosLike(depth);  // of it
  Image<float> right = ZerosLike(depth);   // bonds to the next pixel
  Image<float> below = ZerosLike(depth);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const float stays = static_cast<float>(options.stays_weight) * evidence.stays.At(x, y);
      const float prior = static_cast<float>(options.prior);
      if (!decided.pixels.empty() && decided.At(x, y) != 0) {
        own.At(x, y) = kDecided * decided.At(x, y);
        weight.At(x, y) = kDecided;
      } else {
        own.At(x, y) = evidence.gone.At(x, y) - stays - prior;
        weight.At(x, y) = evidence.gone.At(x, y) + stays + prior;
      }
      if (x + 1 < width) {
        right.At(x, y) = Bond(depth.At(x, y), depth.At(x + 1, y), options.max_depth_step);
      }
      if (y + 1 < height) {
        below.At(x, y) = Bond(depth.At(x, y), depth.At(x, y + 1), options.max_depth_step);
      }
    }
  }
  constexpr float kTogether = 10;  // of neighbours, against one frame's evidence
  Image<float> spread = ZerosLike(depth);
  for (int round = 0; round < options.num_rounds; ++round) {
    Image<float> next = ZerosLike(depth);
    for (int y = 0; y < height; ++y) {
      for (int x = 0; x < width; ++x) {
        float sum = own.At(x, y);
        float total = weight.At(x, y);
        const auto add = [&](float bond, int to_x, int to_y) {
          sum += kTogether * bond * spread.At(to_x, to_y);
          total += kTogether * bond;
        };
        if (x > 0) add(right.At(x - 1, y), x - 1, y);
        if (x + 1 < width) add(right.At(x, y), x + 1, y);
        if (y > 0) add(below.At(x, y - 1), x, y - 1);
        if (y + 1 < height) add(below.At(x, y), x, y + 1);
        next.At(x, y) = total > 0 ? sum / total : 0;
      }
    }
    spread = std::move(next);
  }
  return spread;
}

}  // namespace nightmap
