// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/scan_ranges.h"

#include <gtest/gtest.h>

#include <cmath>

#include "pipeline/base/random.h"

namespace nightmap::scan_ranges_test {

constexpr int kNumBeams = 90;

// Scans in a room of 6 x 8 m, of a robot that drives and turns; resolution and noise as given.
std::vector<SignalSample> Room(double resolution_m, double noise_m, bool is_driving = true) {
  Random random(1);
  std::vector<SignalSample> scans(60);
  for (std::size_t s = 0; s < scans.size(); ++s) {
    const double way = is_driving ? static_cast<double>(s) / 60 : 0;
    scans[s].value = {0, 0, 80};
    for (int i = 0; i < kNumBeams; ++i) {
      const double angle_rad = 2 * M_PI * i / kNumBeams + 4 * way;
      const double x = std::cos(angle_rad), y = std::sin(angle_rad);
      const double range_m = std::min((x > 0 ? 5 - 4 * way : 1 + 4 * way) / std::abs(x),
                                      (y > 0 ? 6 - 3 * way : 2 + 3 * way) / std::abs(y));
      const double noisy_m = range_m + noise_m * random.Gaussian();
      scans[s].ranges_m.push_back(
          static_cast<float>(std::round(noisy_m / resolution_m) * resolution_m));
    }
  }
  return scans;
}

// Writes `written_m` where a scanner of that reach hits nothing.
std::vector<SignalSample> Cut(std::vector<SignalSample> scans, float reach_m, float written_m) {
  for (SignalSample& scan : scans) {
    for (float& range_m : scan.ranges_m) {
      if (range_m >= reach_m) range_m = written_m;
    }
  }
  return scans;
}

TEST(ScanRanges, WallsAreNoRangeOfNoHit) {
  for (const double resolution_m : {0.001, 0.01, 0.05}) {
    for (const double noise_m : {0.0, 0.003, 0.02}) {
      for (const bool is_driving : {true, false}) {
        EXPECT_EQ(RangeOfNoHit_m(Room(resolution_m, noise_m, is_driving)), std::nullopt)
            << resolution_m << ' ' << noise_m << ' ' << is_driving;
      }
    }
  }
}

TEST(ScanRanges, TheRangeOfNoHitIsFoundAtTheReachAndBeyondIt) {
  for (const double resolution_m : {0.001, 0.01}) {
    for (const float written_m : {4.0F, 4.095F, 30.0F, 79.0F}) {
      const auto scans = Cut(Room(resolution_m, 0.01), 4, written_m);
      EXPECT_EQ(RangeOfNoHit_m(scans), written_m) << resolution_m;
    }
  }
  EXPECT_EQ(RangeOfNoHit_m(Cut(Room(0.001, 0.01), 4, 81.0F)), std::nullopt);  // no hit anyway
  EXPECT_EQ(RangeOfNoHit_m({}), std::nullopt);
}

// Noise of hits at the reach may carry them beyond it.
TEST(ScanRanges, AFewHitsMayBeBeyondTheRangeOfNoHit) {
  auto scans = Cut(Room(0.001, 0.01), 4, 4);
  for (std::size_t s = 0; s < 30; ++s)
    scans[s].ranges_m[s] = 4.001F + 0.0007F * static_cast<float>(s);
  EXPECT_EQ(RangeOfNoHit_m(scans), 4.0F);
}

// One beam always sees the same: a robot that stands, or its own body.
TEST(ScanRanges, OneDirectionIsNotEnough) {
  auto scans = Room(0.001, 0.01);
  for (SignalSample& scan : scans) scan.ranges_m[7] = 30;
  EXPECT_EQ(RangeOfNoHit_m(scans), std::nullopt);
}

}  // namespace nightmap::scan_ranges_test
