// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/robot_body.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "pipeline/base/median.h"
#include "pipeline/recording/scan_points.h"

namespace nightmap {
namespace {

// Scans that differ.
constexpr float kChanged_m = 0.1F;   // of a range
constexpr double kMinChanged = 0.2;  // of the directions of two scans
constexpr std::size_t kMaxJudged = 3000;
constexpr std::size_t kMaxChosen = 200;
constexpr std::size_t kMinChosen = 20;
constexpr std::size_t kMaxCompared = 360;  // directions
// Directions of the robot.
constexpr float kSame_m = 0.03F;      // of a range that stays
constexpr double kMinSame = 0.8;      // of the hits of a direction
constexpr double kMinShareHit = 0.5;  // of the scans
constexpr float kLargestBody_m = 3;
constexpr float kLeastMargin_m = 0.03F;
constexpr float kMarginSigmas = 4;
constexpr double kBeside_deg = 1;
constexpr float kSigmaOfMedian = 1.48F;  // a standard deviation by the median deviation
// A body within this range, that keeps its range in so many hits, is certainly the robot.
constexpr float kLargestCertain_m = 1;
constexpr double kMinSameIfCertain = 0.95;  // of the hits of all its directions
// Step and limit of the written range.
constexpr double kRangeStep_m = 0.05;
constexpr double kLargestMinRange_m = 1;
constexpr double kMaxLost = 1e-3;  // of the other hits, that a min_range_m takes away

constexpr float kUnseen = std::numeric_limits<float>::quiet_NaN();

// Ranges of a scan in the directions of all; kUnseen where it hit nothing.
using DirectionRanges = std::vector<float>;

DirectionRanges InDirections(const BeamFan& directions, const SignalSample& scan) {
  const BeamFan beams = FanOf(scan);
  DirectionRanges ranges_m(directions.count, kUnseen);
  for (std::size_t i = 0; i < directions.count; ++i) {
    const auto beam = beams.BeamAt(directions.Angle_rad(i));
    if (beam && IsHit(scan, scan.ranges_m[*beam])) ranges_m[i] = scan.ranges_m[*beam];
  }
  return ranges_m;
}

DirectionRanges FewOf(const DirectionRanges& ranges_m) {
  const std::size_t step = (ranges_m.size() + kMaxCompared - 1) / kMaxCompared;
  DirectionRanges few_m;
  for (std::size_t i = 0; i < ranges_m.size(); i += step) few_m.push_back(ranges_m[i]);
  return few_m;
}

// Whether a scan shows another place, or another heading.
bool Differs(const DirectionRanges& ranges_m, const DirectionRanges& others_m) {
  int num_both = 0;
  int num_changed = 0;
  for (std::size_t i = 0; i < ranges_m.size(); ++i) {
    const float change_m = std::abs(ranges_m[i] - others_m[i]);
    num_both += change_m >= 0 ? 1 : 0;
    num_changed += change_m > kChanged_m ? 1 : 0;
  }
  return num_changed > kMinChanged * std::max(1, num_both);
}

// Indices that lie all over a list, however many of them are asked for.
std::size_t ScatteredIdx(std::size_t i, std::size_t size) {
  const double turns = std::numbers::phi * static_cast<double>(i);
  return static_cast<std::size_t>((turns - std::floor(turns)) * static_cast<double>(size));
}

// Scans that hit something and all differ from each other.
std::vector<DirectionRanges> DifferentScans(const std::vector<SignalSample>& scans,
                                            const BeamFan& directions) {
  std::vector<DirectionRanges> chosen;
  std::vector<DirectionRanges> chosen_few;
  const std::size_t num_judged = std::min(scans.size(), kMaxJudged);
  for (std::size_t i = 0; i < num_judged && chosen.size() < kMaxChosen; ++i) {
    DirectionRanges ranges_m = InDirections(directions, scans[ScatteredIdx(i, scans.size())]);
    DirectionRanges few_m = FewOf(ranges_m);
    if (std::ranges::all_of(few_m, [](float range_m) { return std::isnan(range_m); })) continue;
    if (!std::ranges::all_of(chosen_few,
                             [&](const auto& other) { return Differs(few_m, other); })) {
      continue;
    }
    chosen.push_back(std::move(ranges_m));
    chosen_few.push_back(std::move(few_m));
  }
  return chosen;
}

std::vector<float> HitsIn(const std::vector<DirectionRanges>& scans, std::size_t direction) {
  std::vector<float> hits_m;
  for (const DirectionRanges& ranges_m : scans) {
    if (ranges_m[direction] > 0) hits_m.push_back(ranges_m[direction]);
  }
  return hits_m;
}

// The range that most hits have, if it may be the robot's; else kUnseen.
float StayingRange_m(const std::vector<float>& hits_m, std::size_t num_scans) {
  if (hits_m.empty()) return kUnseen;
  const float middle_m = Median(hits_m);
  const auto num_same = std::ranges::count_if(
      hits_m, [&](float range_m) { return std::abs(range_m - middle_m) <= kSame_m; });
  const auto num_hits = static_cast<double>(hits_m.size());
  const bool is_body = middle_m < kLargestBody_m &&
                       num_hits >= kMinShareHit * static_cast<double>(num_scans) &&
                       static_cast<double>(num_same) >= kMinSame * num_hits;
  return is_body ? middle_m : kUnseen;
}

// A least range, where nothing else is nearer; else the sectors.
std::string RemedyFor(const RobotBody& body, const std::vector<DirectionRanges>& scans) {
  const double farthest_m = body.largest_range_m + body.margin_m;
  const double min_range_m = kRangeStep_m * std::ceil(farthest_m / kRangeStep_m - 1e-6);
  double num_others = 0;
  double num_lost = 0;
  for (const DirectionRanges& ranges_m : scans) {
    for (std::size_t i = 0; i < ranges_m.size(); ++i) {
      if (body.range_m[i] > 0 || !(ranges_m[i] > 0)) continue;
      ++num_others;
      num_lost += ranges_m[i] < min_range_m ? 1 : 0;
    }
  }
  if (min_range_m <= kLargestMinRange_m && num_lost <= kMaxLost * std::max(1.0, num_others)) {
    return fmt::format("min_range_m = {:.2f}", min_range_m);
  }
  return fmt::format("blind_deg = [{}]", fmt::join(body.sectors_deg, ", "));
}

// A direction loses all but hits beyond to_m, or hits from from_m to to_m alone.
struct TakenAway {
  bool is_robot = false;
  float from_m = std::numeric_limits<float>::infinity();
  float to_m = 0;

  bool Takes(const SignalSample& scan, float range_m) const {
    if (!IsHit(scan, range_m)) return is_robot;
    return range_m <= to_m && (is_robot || range_m >= from_m);
  }
};

std::vector<TakenAway> TakenAwayOf(const RobotBody& body) {
  const auto count = static_cast<std::ptrdiff_t>(body.directions.count);
  const auto beside = std::max<std::ptrdiff_t>(
      1, static_cast<std::ptrdiff_t>(kBeside_deg / body.directions.Step_deg()));
  std::vector<TakenAway> taken(body.directions.count);
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    const float range_m = body.range_m[static_cast<std::size_t>(i)];
    if (!(range_m > 0)) continue;
    taken[static_cast<std::size_t>(i)].is_robot = true;
    for (std::ptrdiff_t k = i - beside; k <= i + beside; ++k) {
      if (!body.directions.IsCircle() && (k < 0 || k >= count)) continue;
      TakenAway& near = taken[static_cast<std::size_t>((k % count + count) % count)];
      near.from_m = std::min(near.from_m, range_m - body.margin_m);
      near.to_m = std::max(near.to_m, range_m + body.margin_m);
    }
  }
  return taken;
}

}  // namespace

std::optional<RobotBody> FindRobotBody(const std::vector<SignalSample>& scans) {
  if (scans.empty()) return std::nullopt;
  const BeamFan directions = UsualFan(scans);
  const std::vector<DirectionRanges> chosen = DifferentScans(scans, directions);
  if (chosen.size() < kMinChosen) return std::nullopt;
  RobotBody body;
  body.directions = directions;
  std::vector<float> deviations_m;
  std::vector<bool> shows_robot;
  for (std::size_t i = 0; i < directions.count; ++i) {
    const std::vector<float> hits_m = HitsIn(chosen, i);
    const float range_m = StayingRange_m(hits_m, chosen.size());
    body.range_m.push_back(range_m);
    shows_robot.push_back(range_m > 0);
    if (!shows_robot.back()) continue;
    body.share += 1 / static_cast<double>(directions.count);
    body.largest_range_m = std::max<double>(body.largest_range_m, range_m);
    for (const float hit_m : hits_m) deviations_m.push_back(std::abs(hit_m - range_m));
  }
  if (body.share == 0) return body;
  const auto num_same =
      std::ranges::count_if(deviations_m, [](float deviation_m) { return deviation_m <= kSame_m; });
  body.is_certain =
      body.largest_range_m <= kLargestCertain_m &&
      static_cast<double>(num_same) >= kMinSameIfCertain * static_cast<double>(deviations_m.size());
  const float sigma_m = kSigmaOfMedian * Median(deviations_m);
  body.margin_m = std::max(kLeastMargin_m, kMarginSigmas * sigma_m);
  body.sectors_deg = SectorsOf_deg(directions, shows_robot);
  body.remedy = RemedyFor(body, chosen);
  return body;
}

void LeaveOut(const RobotBody& body, std::vector<SignalSample>* scans) {
  if (body.share == 0) return;
  const std::vector<TakenAway> taken = TakenAwayOf(body);
  for (SignalSample& scan : *scans) {
    const BeamFan beams = FanOf(scan);
    for (std::size_t i = 0; i < beams.count; ++i) {
      const auto direction = body.directions.BeamAt(beams.Angle_rad(i));
      float& range_m = scan.ranges_m[i];
      if (direction && taken[*direction].Takes(scan, range_m)) range_m = kNotMeasured_m;
    }
  }
}

}  // namespace nightmap
