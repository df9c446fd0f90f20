// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_loops/scan_loops.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "pipeline/base/parallel.h"
#include "pipeline/laser/match_scan.h"
#include "pipeline/laser/thin_points.h"
#include "pipeline/laser/wall_normals.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/keyscans.h"
#include "stages/laser/scan_loops/doubtful_loops.h"
#include "stages/laser/scan_loops/drive.h"
#include "stages/laser/scan_loops/scan_stretches.h"
#include "stages/laser/scan_loops/unique_pose.h"

namespace nightmap {
namespace {

constexpr int kMaxQueryPoints = 300;  // of the scans about a place, spread evenly
constexpr int kNumLevels = 7;         // squares of up to 64 cells
constexpr double kMaxExtent_m = 60;   // of a submap, on each side of its middle
constexpr double kWindowSigmas = 3;
// Room that a window has beside the drift.
constexpr double kMargin_m = 0.3;
constexpr double kMargin_rad = 0.05;

std::vector<Keyscan> MakeKeyscans(const ScanLoopsOptions& options,
                                  const Signal& scans,
                                  const std::vector<StampedPose>& poses) {
  std::vector<Keyscan> keyscans;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    Keyscan keyscan{poses[i].time_ns, ToRigid2(poses[i].pose), 0, {}, {}};
    keyscan.points_in_robot =
        ThinPoints(PointsOfKeyscan(scans, poses, i, options.max_range_m), options.resolution_m);
    keyscan.points_in_robot.shrink_to_fit();
    keyscan.normals_in_robot = WallNormals(keyscan.points_in_robot, options.sigma_m / 2);
    if (!keyscans.empty()) {
      const Keyscan& last = keyscans.back();
      keyscan.path_m =
          last.path_m +
          (keyscan.start_from_robot.translation - last.start_from_robot.translation).norm();
    }
    keyscans.push_back(std::move(keyscan));
  }
  return keyscans;
}

class LoopFinder {
 public:
  LoopFinder(const ScanLoopsOptions& options, std::vector<Keyscan> keyscans)
      : options_(options),
        keyscans_(std::move(keyscans)),
        submaps_(CutSubmaps(options, keyscans_)),
        queries_(CutQueries(options, keyscans_)) {}

  std::vector<LoopPair> Pairs(const DriftSums& drifts) const {
    return PairsToTry(options_, keyscans_, drifts, submaps_, queries_);
  }
  std::size_t NumSubmaps() const { return submaps_.size(); }
  std::size_t NumQueries() const { return queries_.size(); }
  const std::vector<Keyscan>& Keyscans() const { return keyscans_; }

  // Candidates of all pairs with this submap.
  std::vector<ScanLoopCandidate> Try(std::size_t submap, const std::vector<LoopPair>& pairs) const {
    if (pairs.empty()) return {};
    const LikelihoodField field = MakeField(submaps_[submap]);
    const FieldPyramid pyramid(field, kNumLevels);
    std::vector<ScanLoopCandidate> candidates;
    for (const LoopPair& pair : pairs) candidates.push_back(TryPair(pyramid, pair));
    return candidates;
  }

 private:
  LikelihoodField MakeField(const ScanStretch& stretch) const {
    const std::vector<Eigen::Vector2d> points = PointsOf(keyscans_, stretch).points;
    double extent_m = 1;
    for (const Eigen::Vector2d& point : points) {
      extent_m = std::max(extent_m, point.cwiseAbs().maxCoeff());
    }
    LikelihoodField field({.resolution_m = options_.resolution_m,
                           .half_extent_m = std::min(extent_m + 3 * options_.sigma_m, kMaxExtent_m),
                           .sigma_m = options_.sigma_m});
    field.Add(ThinPoints(points, options_.resolution_m / 2));
    return field;
  }

  SearchWindow WindowOf(const LoopPair& pair) const {
    SearchWindow window;
    window.min_value = options_.min_score;
    if (pair.drift.IsUnknown()) {  // anywhere in the submap
      window.half_extent_m = options_.max_shift_m;
      window.half_angle_rad = std::numbers::pi;
      return window;
    }
    window.center = keyscans_[submaps_[pair.submap].middle].start_from_robot.Inverse() *
                    keyscans_[queries_[pair.query].middle].start_from_robot;
    window.half_extent_m =
        std::min(kWindowSigmas * pair.drift.Sigma_m() + kMargin_m, options_.max_shift_m);
    window.half_angle_rad =
        std::min(kWindowSigmas * pair.drift.Sigma_rad() + kMargin_rad, options_.max_turn_rad);
    return window;
  }

  StretchPoints QueryPoints(const ScanStretch& stretch) const {
    const StretchPoints all = PointsOf(keyscans_, stretch);
    const auto kept = SpreadIndices(ThinnedIndices(all.points, 2 * options_.resolution_m),
                                    static_cast<std::size_t>(kMaxQueryPoints));
    return {PointsAt(all.points, kept), PointsAt(all.normals, kept)};
  }

  ScanLoopCandidate TryPair(const FieldPyramid& pyramid, const LoopPair& pair) const {
    ScanLoopCandidate candidate;
    candidate.submap_keyscan = submaps_[pair.submap].middle;
    candidate.query_keyscan = queries_[pair.query].middle;
    const StretchPoints query = QueryPoints(queries_[pair.query]);
    const SearchWindow window = WindowOf(pair);
    const auto found = SearchBestPoses(pyramid, query.points, window, options_.max_second_ratio);
    if (!found) return candidate;
    candidate.score = found->best.score;
    if (found->second) candidate.second_score = found->second->score;
    if (found->second) return candidate;
    Refine(pyramid.Field(), query, window, found->best.field_from_robot, &candidate);
    return candidate;
  }

  void Refine(const LikelihoodField& field,
              const StretchPoints& query,
              const SearchWindow& window,
              const Rigid2& start,
              ScanLoopCandidate* candidate) const {
    const PosePrior prior{start, window.half_extent_m, window.half_angle_rad};
    const ScanMatch match = RefinePose(field, query.points, prior, start);
    // Along a bare corridor the query may be anywhere.
    candidate->is_loop =
        !UnclearDirection(field, query.points, query.normals, match.field_from_robot);
    candidate->score = match.score;
    candidate->query_from_submap = match.field_from_robot.Inverse().ToRigid3();
    candidate->covariance = OnFloor(CovarianceInRobot(match));
  }

  const ScanLoopsOptions& options_;
  std::vector<Keyscan> keyscans_;
  std::vector<ScanStretch> submaps_, queries_;
};

SensorEdges EdgesOf(const std::vector<ScanLoopCandidate>& candidates,
                    const std::vector<Keyscan>& keyscans,
                    const std::string& sensor_id) {
  SensorEdges edges{sensor_id, {}};
  for (const ScanLoopCandidate& candidate : candidates) {
    if (!candidate.is_loop) continue;
    edges.edges.push_back({EdgeKind::kLoop,
                           keyscans[candidate.submap_keyscan].time_ns,
                           keyscans[candidate.query_keyscan].time_ns,
                           candidate.query_from_submap,
                           candidate.covariance});
  }
  return edges;
}

}  // namespace

ScanLoopsResult RunScanLoops(const ScanLoopsOptions& options,
                             ScanLoopsInput input,
                             Progress& progress,
                             int num_threads) {
  const Signal& scans = ChooseScanner(input.scans, options.scan_sensor, "scan_loops.scan_sensor");
  CheckEdgesOfKeyscans(input.keyscans, input.odometry.edges);
  std::vector<Keyscan> keyscans = MakeKeyscans(options, scans, input.keyscans);
  const std::string sensor_id = scans.sensor_id;
  input.scans = {};  // the keyscans have their points
  const DriftSums drifts(keyscans, input.odometry.edges);
  const LoopFinder finder(options, std::move(keyscans));
  std::vector<std::vector<LoopPair>> pairs(finder.NumSubmaps());
  for (const LoopPair& pair : finder.Pairs(drifts)) pairs[pair.submap].push_back(pair);
  std::vector<std::vector<ScanLoopCandidate>> candidates(pairs.size());
  progress.Start(pairs.size());
  ParallelFor(pairs.size(), num_threads, [&](std::size_t i) {
    candidates[i] = finder.Try(i, pairs[i]);
    progress.Advance();
  });
  ScanLoopsResult result;
  result.num_submaps = finder.NumSubmaps();
  result.num_queries = finder.NumQueries();
  for (const auto& of_submap : candidates) {
    result.candidates.insert(result.candidates.end(), of_submap.begin(), of_submap.end());
  }
  DropDoubtfulLoops(options, finder.Keyscans(), drifts, &result.candidates);
  result.edges = EdgesOf(result.candidates, finder.Keyscans(), sensor_id);
  return result;
}

}  // namespace nightmap
