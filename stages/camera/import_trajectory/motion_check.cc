// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/import_trajectory/motion_check.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <utility>

#include "pipeline/base/median.h"
#include "pipeline/recording/frame_lists.h"

namespace nightmap {
namespace {

constexpr std::size_t kMaxPairs = 300;
constexpr int kMinInliers = 30;
// A motion tells when it is far above the noise of its measurement.
constexpr double kMinDistance_m = 0.08;
constexpr double kMinTurn_rad = 0.08;
// It disagrees when the given one differs by more than this, far above noise and drift.
constexpr double kMaxError = 0.3;  // of the motion itself
constexpr double kMaxError_m = 0.03;
constexpr double kMaxError_rad = 0.03;

constexpr double kMinAgreeing = 0.5;     // of a trajectory that can be right
constexpr double kMinRemedied = 0.7;     // of one that a remedy makes right
constexpr double kImpossibleScale = 2;   // or its inverse
constexpr double kDoubtfulScale = 1.15;  // likewise

constexpr std::int64_t kShiftStep_ns = 10'000'000;
constexpr int kMaxShiftSteps = 100;

struct MotionPair {
  Rigid3 given;
  Rigid3 measured;
};

std::vector<MotionPair> PairsAt(const std::vector<StampedPose>& given,
                                const std::vector<MeasuredMotion>& measured,
                                std::int64_t shift_ns) {
  std::vector<MotionPair> pairs;
  for (const MeasuredMotion& motion : measured) {
    const auto a = TruthAt(given, motion.time_a_ns + shift_ns);
    const auto b = TruthAt(given, motion.time_b_ns + shift_ns);
    if (a && b) pairs.push_back({b->Inverse() * *a, motion.b_from_a});
  }
  return pairs;
}

double MedianScale(const std::vector<MotionPair>& pairs) {
  std::vector<double> ratios;
  for (const MotionPair& pair : pairs) {
    const double length_m = pair.measured.translation.norm();
    if (length_m > kMinDistance_m) ratios.push_back(pair.given.translation.norm() / length_m);
  }
  return ratios.size() < kMinMotions ? 1 : Median(std::move(ratios));
}

bool Agrees(const MotionPair& pair, double scale) {
  const double angle_rad = Eigen::AngleAxisd(pair.measured.rotation).angle();
  const double length_m = pair.measured.translation.norm();
  const Eigen::Vector3d moved = pair.given.translation / std::max(scale, 1e-12);
  return AngleBetween_rad(pair.given, pair.measured) < kMaxError_rad + kMaxError * angle_rad &&
         (moved - pair.measured.translation).norm() < kMaxError_m + kMaxError * length_m;
}

struct Fit {
  int num_motions = 0;
  int num_agreeing = 0;
  double scale = 1;

  bool Reaches(double ratio) const {
    return num_motions >= kMinMotions && num_agreeing >= ratio * num_motions;
  }
};

Fit FitOf(const std::vector<MotionPair>& pairs) {
  Fit fit{static_cast<int>(pairs.size()), 0, MedianScale(pairs)};
  for (const MotionPair& pair : pairs) fit.num_agreeing += Agrees(pair, fit.scale);
  return fit;
}

// Ways in which files of other systems differ from what is asked for.
struct Convention {
  Rigid3 (*correct)(const Rigid3& pose);
  const char* remedy;
};

Rigid3 ReadAsWxyz(const Rigid3& pose) {
  const Eigen::Vector4d q = pose.rotation.coeffs();  // columns 5 to 8
  return {Eigen::Quaterniond(q[0], q[1], q[2], q[3]), pose.translation};
}

Rigid3 ReadAsInverse(const Rigid3& pose) { return pose.Inverse(); }

// x forward, y left, z up to x right, y down, z forward.
Rigid3 ReadAsRobot(const Rigid3& pose) {
  Eigen::Matrix3d robot_from_camera;
  robot_from_camera << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  return pose * Rigid3{Eigen::Quaterniond(robot_from_camera), Eigen::Vector3d::Zero()};
}

constexpr std::array kConventions = {
    Convention{ReadAsWxyz,
               "columns 5 to 8 fit if they are read as qw qx qy qz: write them as qx qy qz qw"},
    Convention{ReadAsInverse,
               "the inverses of its poses fit: write position and orientation of the camera in the "
               "map, not of the map in the camera"},
    Convention{ReadAsRobot,
               "its poses fit if their axes are those of a robot (x forward, y left, z up): write "
               "poses of the color camera (x right, y down, z forward)"}};

bool IsScaleOff(double scale, double factor) { return scale > factor || scale * factor < 1; }

std::string ScaleRemedy(double scale) {
  return fmt::format(
      "its lengths are {:.4g} times those that depth shows: multiply columns 2 to 4 by {:.4g}",
      scale,
      1 / std::max(scale, 1e-12));
}

struct Shift {
  std::int64_t time_ns = 0;
  Fit fit;
  double median_error = 0;
};

// Metres and radians together: at the metre or two of rooms both move pixels alike.
double MedianError(const std::vector<MotionPair>& pairs) {
  std::vector<double> errors;
  for (const MotionPair& pair : pairs) {
    errors.push_back(AngleBetween_rad(pair.given, pair.measured) +
                     (pair.given.translation - pair.measured.translation).norm());
  }
  return Median(std::move(errors));
}

// The shift of the times that fits best, among those that nearly all motions can be compared at.
Shift BestShift(const std::vector<StampedPose>& given,
                const std::vector<MeasuredMotion>& measured) {
  Shift best;
  for (int step = -kMaxShiftSteps; step <= kMaxShiftSteps; ++step) {
    const auto pairs = PairsAt(given, measured, step * kShiftStep_ns);
    if (pairs.size() < kMinMotions || 10 * pairs.size() < 8 * measured.size()) continue;
    const Shift shift{step * kShiftStep_ns, FitOf(pairs), MedianError(pairs)};
    if (best.fit.num_motions == 0 || shift.median_error < best.median_error) best = shift;
  }
  return best;
}

std::string ShiftRemedy(std::int64_t shift_ns) {
  return fmt::format(
      "its times are {:.2f} s {} than those of the pictures: {} {:.2f} s {} column 1",
      1e-9 * static_cast<double>(std::abs(shift_ns)),
      shift_ns > 0 ? "later" : "earlier",
      shift_ns > 0 ? "subtract" : "add",
      1e-9 * static_cast<double>(std::abs(shift_ns)),
      shift_ns > 0 ? "from" : "to");
}

std::string WithScale(const std::string& remedy, double scale) {
  return IsScaleOff(scale, kImpossibleScale) ? remedy + "; and " + ScaleRemedy(scale) : remedy;
}

std::string Remedy(const std::vector<StampedPose>& given,
                   const std::vector<MeasuredMotion>& measured) {
  for (const Convention& convention : kConventions) {
    std::vector<StampedPose> corrected = given;
    for (StampedPose& stamped : corrected) stamped.pose = convention.correct(stamped.pose);
    const Fit fit = FitOf(PairsAt(corrected, measured, 0));
    if (fit.Reaches(kMinRemedied)) return WithScale(convention.remedy, fit.scale);
  }
  const Shift shift = BestShift(given, measured);
  if (shift.fit.Reaches(kMinRemedied))
    return WithScale(ShiftRemedy(shift.time_ns), shift.fit.scale);
  return "give poses of the color camera of this recording at its own times (time_s tx ty tz qx qy "
         "qz qw)";
}

}  // namespace

std::vector<MeasuredMotion> MeasureMotions(const FramesWithFeatures& input,
                                           const std::vector<StampedPose>& given,
                                           int num_threads,
                                           Progress& progress) {
  const FeaturesShard& heads = input.features.Heads();
  CheckFeaturesOfFrames(input.frames, heads);
  std::vector<FramePair> all;
  const FrameFeatures* before = nullptr;
  for (std::size_t i = 0; i < input.frames.size(); ++i) {
    const FrameFeatures& frame = heads.frames[i];
    if (!frame.IsDescribed() || !TruthAt(given, input.frames[i].time_ns)) continue;
    if (before != nullptr) all.push_back(MakePair(before->frame_idx, frame.frame_idx));
    before = &frame;
  }
  std::vector<FramePair> pairs;
  const std::size_t count = std::min(all.size(), kMaxPairs);
  for (std::size_t i = 0; i < count; ++i) pairs.push_back(all[i * all.size() / count]);
  VerifyOptions verify;
  verify.pose.min_inliers = kMinInliers;
  VerifyPairs(verify, nullptr, input, num_threads, progress, &pairs);
  const auto time_ns = [&](int frame_idx) {
    return input.frames[static_cast<std::size_t>(frame_idx - input.frames.front().frame_idx)]
        .time_ns;
  };
  std::vector<MeasuredMotion> motions;
  for (const FramePair& pair : pairs) {
    if (pair.status != PairStatus::kAccepted) continue;
    motions.push_back({time_ns(pair.frame_a), time_ns(pair.frame_b), pair.b_from_a});
  }
  return motions;
}

MotionVerdict CompareMotions(const std::vector<StampedPose>& given,
                             const std::vector<MeasuredMotion>& measured) {
  std::vector<MeasuredMotion> telling;
  std::ranges::copy_if(measured, std::back_inserter(telling), [](const MeasuredMotion& motion) {
    return motion.b_from_a.translation.norm() > kMinDistance_m ||
           Eigen::AngleAxisd(motion.b_from_a.rotation).angle() > kMinTurn_rad;
  });
  const auto pairs = PairsAt(given, telling, 0);
  const Fit fit = FitOf(pairs);
  MotionVerdict verdict{fit.num_motions, fit.num_agreeing, fit.scale, "", ""};
  if (fit.num_motions < kMinMotions) return verdict;
  if (!fit.Reaches(kMinAgreeing)) {
    verdict.contradiction = fmt::format("it agrees with {} of {} motions between pictures; {}",
                                        fit.num_agreeing,
                                        fit.num_motions,
                                        Remedy(given, telling));
    return verdict;
  }
  if (IsScaleOff(fit.scale, kImpossibleScale)) {
    verdict.contradiction = ScaleRemedy(fit.scale);
    return verdict;
  }
  const Shift shift = BestShift(given, telling);
  if (IsScaleOff(fit.scale, kDoubtfulScale)) {
    verdict.doubt = ScaleRemedy(fit.scale);
  } else if (std::abs(shift.time_ns) >= 2 * kShiftStep_ns &&
             shift.median_error < 0.5 * MedianError(pairs)) {
    verdict.doubt = ShiftRemedy(shift.time_ns);
  }
  return verdict;
}

}  // namespace nightmap
