// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/located_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "pipeline/base/median.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

constexpr char kHeader[] =
    "query_idx,rank,x_m,y_m,heading_rad,fit,walls_fit,score,search_score,through_share,"
    "num_confirmed,num_contradicted,sigma_x_m,sigma_y_m,sigma_heading_rad,correlation_xy\n";

std::string Row(int query_idx, std::size_t rank, const ScanCandidate& candidate) {
  const Rigid2& pose = candidate.map_from_query;
  const Eigen::Vector3d sigmas = candidate.covariance.diagonal().cwiseSqrt();
  const double scale = sigmas.x() * sigmas.y();
  return fmt::format(
      "{},{},{:.4f},{:.4f},{:.5f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{},{},{:.5f},{:.5f},{:.6f},"
      "{:.4f}\n",
      query_idx,
      rank,
      pose.translation.x(),
      pose.translation.y(),
      WrapAngle_rad(pose.heading_rad),
      candidate.fit,
      candidate.walls_fit,
      candidate.score,
      candidate.search_score,
      candidate.through_share,
      candidate.objects.num_confirmed,
      candidate.objects.num_contradicted,
      sigmas.x(),
      sigmas.y(),
      sigmas.z(),
      scale > 0 ? candidate.covariance(0, 1) / scale : 0);
}

}  // namespace

std::string CandidatesToCsv(const std::vector<LocatedScan>& located) {
  std::string text = kHeader;
  for (const LocatedScan& scan : located) {
    for (std::size_t i = 0; i < scan.candidates.size(); ++i) {
      text += Row(scan.result.query_idx, i, scan.candidates[i]);
    }
  }
  return text;
}

std::string ObjectPosesToCsv(const std::vector<LocatedScan>& located) {
  std::string text = "query_idx,object_idx,x_m,y_m,heading_rad,num_in_sight,overlap\n";
  for (const LocatedScan& scan : located) {
    for (const ObjectPose& pose : scan.object_poses) {
      text += fmt::format("{},{},{:.4f},{:.4f},{:.5f},{},{:.4f}\n",
                          scan.result.query_idx,
                          pose.object_idx,
                          pose.map_from_query.translation.x(),
                          pose.map_from_query.translation.y(),
                          WrapAngle_rad(pose.map_from_query.heading_rad),
                          pose.num_in_sight,
                          pose.overlap);
    }
  }
  return text;
}

nlohmann::json SummarizeScans(const std::vector<LocatedScan>& located) {
  std::map<std::string, int> verdicts{
      {"located", 0}, {"ambiguous", 0}, {"not_in_map", 0}, {"no_features", 0}};
  std::map<std::string, int> reasons;
  std::vector<double> sigmas_m, num_candidates;
  std::size_t num_object_poses = 0, num_near_objects = 0, num_filtered = 0;
  for (const LocatedScan& scan : located) {
    ++verdicts[std::string(QueryVerdictText(scan.result.verdict))];
    if (!scan.result.reason.empty()) ++reasons[scan.result.reason];
    if (scan.result.IsLocated()) sigmas_m.push_back(scan.result.position_sigma_m);
    num_candidates.push_back(static_cast<double>(scan.candidates.size()));
    num_object_poses += scan.object_poses.size();
    num_near_objects += scan.num_near_objects > 0;
    num_filtered += scan.num_filtered > 0;
  }
  return {{"num_queries", located.size()},
          {"num_by_verdict", verdicts},
          {"num_not_located_by_reason", reasons},
          {"median_position_sigma_m", Median(sigmas_m)},
          {"median_num_candidates", Median(num_candidates)},
          {"num_object_poses", num_object_poses},
          {"num_queries_near_objects", num_near_objects},
          {"num_queries_filtered_by_objects", num_filtered}};
}

void WriteLocated(const std::vector<LocatedScan>& located, StageContext& context) {
  std::vector<QueryResult> results;
  for (const LocatedScan& scan : located) results.push_back(scan.result);
  WriteFile(context.Output("queries"), QueriesToCsv(results));
  WriteFile(context.Output("trajectory"),
            TrajectoryToTum(LocatedPoses(results), "map_from_robot of the located scans"));
  WriteFile(context.Output("candidates"), CandidatesToCsv(located));
  WriteFile(context.Output("object_poses"), ObjectPosesToCsv(located));
  context.Report().update(SummarizeScans(located));
}

}  // namespace nightmap
