// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/scan_queries_io.h"

#include <algorithm>
#include <cmath>

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kScanQueriesFormat[] = "nightmap scan queries";
constexpr int kScanQueriesVersion = 1;
constexpr double kMaxOffset_m = 1000;  // of a scan from its query
constexpr double kMaxRough_m = 1e6;    // of a rough position
constexpr char kScanQueriesUnits[] =
    "query_from_laser: heading (rad) x y (m); beams: first angle, step (rad), limit (m); "
    "rough_position: x y radius (m) in the map";

constexpr auto kQueryScans = Hdf5Table<QueryScan>(
    Hdf5Column("query_from_laser",
               MemberOf(&QueryScan::query_from_laser, &Rigid2::heading_rad),
               MemberOf(&QueryScan::query_from_laser, &Rigid2::translation))
        .Rows(
            [](const QueryScan& scan) {
              return scan.query_from_laser.translation.cwiseAbs().maxCoeff() <= kMaxOffset_m;
            },
            "is too far from the robot"),
    Hdf5Column(
        "beams", &QueryScan::first_angle_rad, &QueryScan::step_angle_rad, &QueryScan::limit_m)
        .Rows([](const QueryScan& scan) { return scan.step_angle_rad != 0; },
              "has an angle step of 0"),
    Hdf5Lists(
        "range_offset", &QueryScan::ranges_m, Hdf5Table<float>(Hdf5Column("range_m", kItself))));

bool IsLine(const std::string& name) {
  const auto is_printed = [](char c) { return static_cast<unsigned char>(c) >= ' '; };
  return !name.empty() && std::ranges::all_of(name, is_printed);
}

constexpr auto kScanQueries = Hdf5Table<ScanQuery>(
    Hdf5Lists(
        "name_offset", &ScanQuery::name, Hdf5Table<std::uint8_t>(Hdf5Column("name", kItself))),
    Hdf5Column("time_ns", &ScanQuery::time_ns)
        .Pairs(Ascending(&ScanQuery::time_ns), "does not increase"),
    Hdf5Lists("scan_offset", &ScanQuery::scans, kQueryScans));

constexpr auto kRoughPositions = Hdf5Table<RoughPosition>(
    Hdf5Column("rough_position", &RoughPosition::point_in_map, &RoughPosition::radius_m)
        .Rows([](const RoughPosition& position) { return position.radius_m >= 0; },
              "has a negative radius")
        .Elements([](double value) { return std::abs(value) <= kMaxRough_m; }));

}  // namespace

std::vector<Eigen::Vector2d> PointsInQuery(const ScanQuery& query, double max_range_m) {
  std::vector<Eigen::Vector2d> points;
  for (const QueryScan& scan : query.scans) {
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      if (!scan.IsHit(i) || scan.ranges_m[i] > max_range_m) continue;
      const double angle_rad = scan.Angle_rad(i);
      points.push_back(
          scan.query_from_laser *
          (scan.ranges_m[i] * Eigen::Vector2d(std::cos(angle_rad), std::sin(angle_rad))));
    }
  }
  return points;
}

void WriteScanQueries(const std::filesystem::path& path, const std::vector<ScanQuery>& queries) {
  std::vector<ScanQuery> finite = queries;
  std::vector<RoughPosition> positions;
  for (ScanQuery& query : finite) {
    positions.push_back(query.rough_position.value_or(RoughPosition{}));
    for (QueryScan& scan : query.scans) {
      std::ranges::replace_if(
          scan.ranges_m, [](float value) { return !std::isfinite(value); }, 0.0F);
    }
  }
  Hdf5Writer file(path,
                  kScanQueriesFormat,
                  kScanQueriesVersion,
                  "# made of the site config\n",
                  kScanQueriesUnits);
  kScanQueries.Write(finite, &file);
  kRoughPositions.Write(positions, &file);
  file.Close();
}

std::vector<ScanQuery> ReadScanQueries(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kScanQueriesFormat, kScanQueriesVersion);
  auto queries = kScanQueries.Read(file);
  const auto positions = kRoughPositions.Read(file);
  file.Demand(positions.size() == queries.size(), "rough_position");
  for (std::size_t i = 0; i < queries.size(); ++i) {
    file.Demand(IsLine(queries[i].name), "name");
    if (positions[i].radius_m > 0) queries[i].rough_position = positions[i];
  }
  return queries;
}

}  // namespace nightmap
