// SPDX-License-Identifier: Apache-2.0
#include "stages/world/synthesize/mislabel_things.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>
#include <vector>

#include "pipeline/world/route.h"
#include "pipeline/world/true_things.h"

namespace nightmap::mislabel_things_test {

const SyntheticWorld& World() {
  static const SyntheticWorld world = [] {
    BuildingOptions options;
    options.light_map_cell_m = 1;
    options.num_light_samples = 1;
    return BuildWorld(options, RouteOptions{}, 2);
  }();
  return world;
}

std::vector<RenderedFrame> Views() {
  SyntheticCameraOptions camera;
  camera.image_width_px = 64;
  camera.image_height_px = 48;
  camera.focal_length_px = 52;
  const std::vector<Rigid3> route = PlanRoute(World().layout, RouteOptions{}, camera);
  std::vector<RenderedFrame> views;
  for (std::size_t i = 0; i < route.size(); i += 3) {
    views.push_back(Render(World(), camera.Pinhole(), route[i], {}, 2.0, i));
  }
  return views;
}

using ThingKey = std::pair<int, SurfaceLabel>;  // piece and true label

// The labels that the picture gives to each thing in it. Expects those of all other pixels to be
// true.
std::map<ThingKey, std::set<SurfaceLabel>> LabelsOfThings(const RenderedFrame& frame) {
  std::map<ThingKey, std::set<SurfaceLabel>> labels;
  for (std::size_t i = 0; i < frame.labels.pixels.size(); ++i) {
    const auto label = static_cast<SurfaceLabel>(frame.labels.pixels[i]);
    const std::int32_t surface_idx = frame.surface_idx.pixels[i];
    if (surface_idx < 0) {
      EXPECT_EQ(label, SurfaceLabel::kNone);
      continue;
    }
    const Surface& surface = World().scene.surfaces[static_cast<std::size_t>(surface_idx)];
    if (IsThingLabel(surface.label)) {
      labels[{surface.piece_idx, surface.label}].insert(label);
    } else {
      EXPECT_EQ(label, surface.label);
    }
  }
  return labels;
}

TEST(MislabelThings, AsManyAsSaidAndAllPixelsOfAThingAlike) {
  int num_seen = 0;
  int num_wrong = 0;
  std::array<int, kThingLabels.size()> num_by_shift{};
  std::map<ThingKey, std::set<bool>> is_wrong;
  std::uint64_t seed = 0;
  for (RenderedFrame& frame : Views()) {
    const RenderedFrame before = frame;
    MislabelThings(World().scene, 0.2, ++seed, frame);
    EXPECT_EQ(frame.color.pixels, before.color.pixels);
    EXPECT_EQ(frame.depth.pixels, before.depth.pixels);
    EXPECT_EQ(frame.exact_depth.pixels, before.exact_depth.pixels);
    for (const auto& [thing, labels] : LabelsOfThings(frame)) {
      ASSERT_EQ(labels.size(), 1U);
      ASSERT_TRUE(IsThingLabel(*labels.begin()));
      const auto idx_of = [](SurfaceLabel label) {
        return static_cast<std::size_t>(std::ranges::find(kThingLabels, label) -
                                        kThingLabels.begin());
      };
      const std::size_t shift =
          (idx_of(*labels.begin()) + kThingLabels.size() - idx_of(thing.second)) %
          kThingLabels.size();
      ++num_by_shift[shift];
      ++num_seen;
      num_wrong += shift != 0 ? 1 : 0;
      is_wrong[thing].insert(shift != 0);
    }
  }
  ASSERT_GT(num_seen, 500);
  EXPECT_NEAR(static_cast<double>(num_wrong) / num_seen, 0.2, 0.04);
  for (std::size_t shift = 1; shift < num_by_shift.size(); ++shift) {
    EXPECT_NEAR(static_cast<double>(num_by_shift[shift]) / num_wrong, 0.2, 0.1) << shift;
  }
  // A thing is wrong in some pictures and right in others.
  const auto num_mixed =
      std::ranges::count_if(is_wrong, [](const auto& thing) { return thing.second.size() == 2; });
  EXPECT_GT(num_mixed, static_cast<std::ptrdiff_t>(is_wrong.size() / 2));
}

TEST(MislabelThings, NoneAtRatioZeroAndAllAtOne) {
  const std::vector<RenderedFrame> views = Views();
  for (std::size_t i = 0; i < views.size(); i += 20) {
    RenderedFrame frame = views[i];
    MislabelThings(World().scene, 0, i, frame);
    EXPECT_EQ(frame.labels.pixels, views[i].labels.pixels);
    for (const auto& [thing, labels] : LabelsOfThings(frame)) {
      EXPECT_EQ(labels, std::set{thing.second});
    }
    MislabelThings(World().scene, 1, i, frame);
    for (const auto& [thing, labels] : LabelsOfThings(frame)) {
      EXPECT_FALSE(labels.contains(thing.second));
    }
  }
}

}  // namespace nightmap::mislabel_things_test
