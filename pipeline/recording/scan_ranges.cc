// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/scan_ranges.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <set>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "pipeline/recording/scan_points.h"

namespace nightmap {
namespace {

constexpr double kFarthestMedian_m = 100;
constexpr std::size_t kMinRangesToJudge = 20;
constexpr std::size_t kMaxRangesToJudge = 200'000;
constexpr double kMinCount = 100;
constexpr double kMinShare = 1e-3;        // of all beams, that have the range of no hit
constexpr double kMinDirections = 0.1;    // of the directions of beams, that have it
constexpr double kMaxShareBeyond = 0.05;  // of its beams, that are longer: hits with noise
constexpr double kNear = 0.05;            // of a range: other ranges about as large
constexpr std::size_t kTimesRarer = 10;

// A range, and how many beams have exactly that.
struct RangeCount {
  float range_m = 0;
  std::size_t count = 0;
};

// The hits of all scans, the longest first.
std::vector<RangeCount> CountRanges(const std::vector<SignalSample>& scans) {
  std::vector<float> ranges_m;
  for (const SignalSample& scan : scans) {
    for (const float range_m : scan.ranges_m) {
      if (IsHit(scan, range_m)) ranges_m.push_back(range_m);
    }
  }
  std::ranges::sort(ranges_m, std::greater<>());
  std::vector<RangeCount> counts;
  for (const float range_m : ranges_m) {
    if (counts.empty() || counts.back().range_m != range_m) counts.push_back({range_m, 0});
    ++counts.back().count;
  }
  return counts;
}

bool IsFarMoreFrequentThanNear(const std::vector<RangeCount>& counts, std::size_t idx) {
  return std::ranges::none_of(counts, [&](const RangeCount& other) {
    const float distance_m = std::abs(other.range_m - counts[idx].range_m);
    return distance_m > 0 && distance_m <= kNear * counts[idx].range_m &&
           kTimesRarer * other.count > counts[idx].count;
  });
}

bool IsInManyDirections(const std::vector<SignalSample>& scans, float range_m) {
  std::set<std::size_t> beams;
  std::size_t num_beams = 0;
  for (const SignalSample& scan : scans) {
    num_beams = std::max(num_beams, scan.ranges_m.size());
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      if (scan.ranges_m[i] == range_m) beams.insert(i);
    }
  }
  return static_cast<double>(beams.size()) >= kMinDirections * static_cast<double>(num_beams);
}

}  // namespace

void DemandMetres(const Signal& scans, const std::filesystem::path& path) {
  std::vector<float> ranges_m;
  for (const SignalSample& scan : scans.samples) {
    if (ranges_m.size() > kMaxRangesToJudge) break;
    std::ranges::copy_if(
        scan.ranges_m, std::back_inserter(ranges_m), [](float range_m) { return range_m > 0; });
  }
  if (ranges_m.size() < kMinRangesToJudge) return;
  std::erase(ranges_m, *std::ranges::max_element(ranges_m));
  const float median_m = Median(ranges_m);
  if (median_m < kFarthestMedian_m) return;
  throw DataError(
      "{}: half of the ranges of \"{}\" are {:.4g} or more, which are no metres: write range_unit "
      "= \"mm\" in its [[sensor]], where that is {:.3g} m, or \"cm\", where it is {:.3g} m, and "
      "max_range_m in metres",
      path.string(),
      scans.sensor_id,
      median_m,
      median_m / 1000,
      median_m / 100);
}

std::optional<float> RangeOfNoHit_m(const std::vector<SignalSample>& scans) {
  const std::vector<RangeCount> counts = CountRanges(scans);
  double num_beams = 0;
  for (const SignalSample& scan : scans) num_beams += static_cast<double>(scan.ranges_m.size());
  double num_beyond = 0;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto count = static_cast<double>(counts[i].count);
    if (count >= std::max(kMinCount, kMinShare * num_beams) &&
        num_beyond <= kMaxShareBeyond * count && IsFarMoreFrequentThanNear(counts, i) &&
        IsInManyDirections(scans, counts[i].range_m)) {
      return counts[i].range_m;
    }
    num_beyond += count;
  }
  return std::nullopt;
}

std::optional<float> LimitToHits(std::vector<SignalSample>* scans) {
  const std::optional<float> range_m = RangeOfNoHit_m(*scans);
  if (!range_m) return range_m;
  for (SignalSample& scan : *scans) scan.value[2] = *range_m;
  return range_m;
}

}  // namespace nightmap
