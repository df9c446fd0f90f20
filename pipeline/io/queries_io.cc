// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/queries_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "pipeline/io/csv.h"

namespace nightmap {
namespace {

constexpr char kHeader[] =
    "query_idx,time_ns,color_path,status,reason,num_matches,num_inliers,num_rival_inliers,"
    "confidence,"
    "reprojection_error_px,position_sigma_m,rotation_sigma_deg,tx_m,ty_m,tz_m,qx,qy,qz,qw";
enum Column : std::size_t {
  kQueryIdx,
  kTime,
  kColorPath,
  kStatus,
  kReason,
  kNumMatches,
  kNumInliers,
  kNumRivalInliers,
  kConfidence,
  kError,
  kPositionSigma,
  kRotationSigma,
  kPose,
  kNumColumns = kPose + 7
};

constexpr std::array<std::string_view, 5> kVerdicts = {
    "located", "ambiguous", "not_in_map", "no_features", "unreadable"};

std::string PoseToCsv(const Rigid3& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return fmt::format("{},{},{},{},{},{},{}", t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

Rigid3 ReadPose(const CsvRow& row) {
  std::array<double, 7> v{};
  for (std::size_t i = 0; i < v.size(); ++i) v[i] = row.Real(kPose + i);
  const Eigen::Quaterniond rotation(v[6], v[3], v[4], v[5]);
  if (std::abs(rotation.norm() - 1.0) > 1e-6) row.Fail("the quaternion is not of unit length");
  return {rotation, {v[0], v[1], v[2]}};
}

QueryVerdict ReadVerdict(const CsvRow& row) {
  const auto found = std::ranges::find(kVerdicts, row.Text(kStatus));
  if (found == kVerdicts.end()) row.Fail("status is none of the known verdicts");
  return static_cast<QueryVerdict>(found - kVerdicts.begin());
}

void CheckWithoutPose(const CsvRow& row) {
  for (std::size_t column = kPose; column < kNumColumns; ++column) {
    if (!row.IsEmpty(column)) row.Fail("a query that was not located with a pose");
  }
}

QueryResult ReadQuery(const CsvRow& row) {
  QueryResult query;
  query.query_idx = row.Index(kQueryIdx);
  query.time_ns = row.Integer(kTime);
  query.color_path = row.Text(kColorPath);
  query.verdict = ReadVerdict(row);
  query.reason = row.Text(kReason);
  query.num_matches = row.Index(kNumMatches);
  query.num_inliers = row.Index(kNumInliers);
  query.num_rival_inliers = row.Index(kNumRivalInliers);
  query.confidence = row.Real(kConfidence);
  query.reprojection_error_px = row.Real(kError);
  query.position_sigma_m = row.Real(kPositionSigma);
  query.rotation_sigma_deg = row.Real(kRotationSigma);
  if (query.IsLocated() != query.reason.empty()) {
    row.Fail(query.IsLocated() ? "a located query with a reason of failure"
                               : "a query that was not located without reason");
  }
  if (query.HasPose()) {
    query.map_from_camera = ReadPose(row);
  } else {
    CheckWithoutPose(row);
  }
  return query;
}

}  // namespace

std::string_view QueryVerdictText(QueryVerdict verdict) {
  return kVerdicts.at(static_cast<std::size_t>(verdict));
}

std::string QueriesToCsv(const std::vector<QueryResult>& queries) {
  std::string text = fmt::format("{}\n", kHeader);
  for (const QueryResult& query : queries) {
    text += fmt::format("{},{},{},{},{},{},{},{},{},{},{},{},{}\n",
                        query.query_idx,
                        query.time_ns,
                        CsvField(query.color_path),
                        QueryVerdictText(query.verdict),
                        CsvField(query.reason),
                        query.num_matches,
                        query.num_inliers,
                        query.num_rival_inliers,
                        query.confidence,
                        query.reprojection_error_px,
                        query.position_sigma_m,
                        query.rotation_sigma_deg,
                        query.HasPose() ? PoseToCsv(query.map_from_camera) : ",,,,,,");
  }
  return text;
}

std::vector<QueryResult> ReadQueries(const std::filesystem::path& path) {
  const CsvFile file(path, kHeader);
  std::vector<QueryResult> queries;
  for (const CsvRow& row : file.Rows()) queries.push_back(ReadQuery(row));
  return queries;
}

std::vector<StampedPose> LocatedPoses(const std::vector<QueryResult>& queries) {
  std::vector<StampedPose> poses;
  for (const QueryResult& query : queries) {
    if (query.IsLocated()) poses.push_back({query.time_ns, query.map_from_camera});
  }
  std::stable_sort(poses.begin(), poses.end(), [](const auto& a, const auto& b) {
    return a.time_ns < b.time_ns;
  });
  return poses;
}

}  // namespace nightmap
