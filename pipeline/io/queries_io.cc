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
    "query_idx,time_ns,color_path,status,reason,num_matches,num_inliers,reprojection_error_px,"
    "tx_m,ty_m,tz_m,qx,qy,qz,qw";
enum Column : std::size_t {
  kQueryIdx,
  kTime,
  kColorPath,
  kStatus,
  kReason,
  kNumMatches,
  kNumInliers,
  kError,
  kPose,
  kNumColumns = kPose + 7
};

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

void CheckFailed(const CsvRow& row) {
  if (row.Text(kStatus) != "failed") row.Fail("status is neither located nor failed");
  if (row.IsEmpty(kReason)) row.Fail("a failed query without reason");
  for (std::size_t column = kPose; column < kNumColumns; ++column) {
    if (!row.IsEmpty(column)) row.Fail("a failed query with a pose");
  }
}

QueryResult ReadQuery(const CsvRow& row) {
  QueryResult query;
  query.query_idx = row.Index(kQueryIdx);
  query.time_ns = row.Integer(kTime);
  query.color_path = row.Text(kColorPath);
  query.reason = row.Text(kReason);
  query.num_matches = row.Index(kNumMatches);
  query.num_inliers = row.Index(kNumInliers);
  query.reprojection_error_px = row.Real(kError);
  if (row.Text(kStatus) == "located") {
    if (!query.reason.empty()) row.Fail("a located query with a reason of failure");
    query.map_from_camera = ReadPose(row);
  } else {
    CheckFailed(row);
  }
  return query;
}

}  // namespace

std::string QueriesToCsv(const std::vector<QueryResult>& queries) {
  std::string text = fmt::format("{}\n", kHeader);
  for (const QueryResult& query : queries) {
    text += fmt::format("{},{},{},{},{},{},{},{},{}\n",
                        query.query_idx,
                        query.time_ns,
                        CsvField(query.color_path),
                        query.IsLocated() ? "located" : "failed",
                        CsvField(query.reason),
                        query.num_matches,
                        query.num_inliers,
                        query.reprojection_error_px,
                        query.IsLocated() ? PoseToCsv(query.map_from_camera) : ",,,,,,");
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
