// SPDX-License-Identifier: Apache-2.0
#include "pipeline/laser/scan_queries_io.h"

#include <algorithm>
#include <cmath>

#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kScanQueriesFormat[] = "nightmap scan queries";
constexpr int kScanQueriesVersion = 1;
constexpr double kMaxOffset_m = 1000;  // of a scan from its query
constexpr double kMaxRough_m = 1e6;    // of a rough position
constexpr char kScanQueriesUnits[] =
    "query_from_laser: heading (rad) x y (m); beams: first angle, step (rad), limit (m); "
    "rough_position: x y radius (m) in the map";

// Appends an item's values and where they end.
template <typename T, typename Values>
void Append(const Values& item, std::vector<T>* values, std::vector<std::int64_t>* offsets) {
  values->insert(values->end(), item.begin(), item.end());
  offsets->push_back(static_cast<std::int64_t>(values->size()));
}

void AppendRow(std::initializer_list<double> row, Array<double>* array) {
  array->values.insert(array->values.end(), row);
  ++array->rows;
}

// The scans of all queries, query after query.
std::vector<QueryScan> ReadScans(const Hdf5Reader& file) {
  const auto pose = file.Read<double>("query_from_laser", 3);
  const auto beams = file.Read<double>("beams", 3);
  const auto range_m = file.ReadList<float>("range_m");
  file.Demand(beams.rows == pose.rows, "beams");
  const auto offsets = file.ReadOffsets("range_offset", pose.rows, range_m.size());
  std::vector<QueryScan> scans;
  for (std::size_t i = 0; i < pose.rows; ++i) {
    const double* p = &pose.values[3 * i];
    const double* b = &beams.values[3 * i];
    file.Demand(b[1] != 0, "beams", "has an angle step of 0");
    const bool is_on_spot = std::abs(p[1]) <= kMaxOffset_m && std::abs(p[2]) <= kMaxOffset_m;
    file.Demand(is_on_spot, "query_from_laser", "is too far from the robot");
    scans.push_back({{p[0], {p[1], p[2]}}, b[0], b[1], b[2], {}});
    const auto begin = range_m.begin();
    scans.back().ranges_m.assign(begin + static_cast<std::ptrdiff_t>(offsets[i]),
                                 begin + static_cast<std::ptrdiff_t>(offsets[i + 1]));
  }
  return scans;
}

std::vector<std::string> ReadNames(const Hdf5Reader& file, std::size_t count) {
  const auto bytes = file.ReadList<std::uint8_t>("name");
  const auto offsets = file.ReadOffsets("name_offset", count, bytes.size());
  std::vector<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    const auto begin = bytes.begin();
    names.emplace_back(begin + static_cast<std::ptrdiff_t>(offsets[i]),
                       begin + static_cast<std::ptrdiff_t>(offsets[i + 1]));
    const bool is_line = std::ranges::all_of(
        names.back(), [](char c) { return static_cast<unsigned char>(c) >= ' '; });
    file.Demand(is_line && !names.back().empty(), "name");
  }
  return names;
}

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
  std::vector<std::int64_t> name_offset = {0}, time_ns, scan_offset = {0}, range_offset = {0};
  std::vector<std::uint8_t> name;
  std::vector<float> range_m;
  Array<double> pose{0, 3, {}}, beams{0, 3, {}}, rough{0, 3, {}};
  for (const ScanQuery& query : queries) {
    Append(query.name, &name, &name_offset);
    time_ns.push_back(query.time_ns);
    const RoughPosition position = query.rough_position.value_or(RoughPosition{});
    AppendRow({position.point_in_map.x(), position.point_in_map.y(), position.radius_m}, &rough);
    for (const QueryScan& scan : query.scans) {
      const Rigid2& at = scan.query_from_laser;
      AppendRow({at.heading_rad, at.translation.x(), at.translation.y()}, &pose);
      AppendRow({scan.first_angle_rad, scan.step_angle_rad, scan.limit_m}, &beams);
      std::vector<float> finite = scan.ranges_m;
      std::ranges::replace_if(
          finite, [](float value) { return !std::isfinite(value); }, 0.0F);
      Append(finite, &range_m, &range_offset);
    }
    scan_offset.push_back(static_cast<std::int64_t>(pose.rows));
  }
  Hdf5Writer file(path,
                  kScanQueriesFormat,
                  kScanQueriesVersion,
                  "# made of the site config\n",
                  kScanQueriesUnits);
  file.WriteList("name_offset", name_offset);
  file.WriteList("name", name);
  file.WriteList("time_ns", time_ns);
  file.WriteList("scan_offset", scan_offset);
  file.Write("query_from_laser", pose);
  file.Write("beams", beams);
  file.WriteList("range_offset", range_offset);
  file.WriteList("range_m", range_m);
  file.Write("rough_position", rough);
  file.Close();
}

std::vector<ScanQuery> ReadScanQueries(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kScanQueriesFormat, kScanQueriesVersion);
  const auto time_ns = file.ReadList<std::int64_t>("time_ns");
  const auto names = ReadNames(file, time_ns.size());
  auto scans = ReadScans(file);
  const auto offsets = file.ReadOffsets("scan_offset", time_ns.size(), scans.size());
  const auto rough = file.Read<double>("rough_position", 3);
  file.Demand(rough.rows == time_ns.size(), "rough_position");
  std::vector<ScanQuery> queries;
  for (std::size_t i = 0; i < time_ns.size(); ++i) {
    file.Demand(i == 0 || time_ns[i - 1] < time_ns[i], "time_ns", "does not increase");
    ScanQuery& query = queries.emplace_back(ScanQuery{names[i], time_ns[i], {}, {}});
    for (std::size_t k = offsets[i]; k < offsets[i + 1]; ++k) {
      query.scans.push_back(std::move(scans[k]));
    }
    const double* values = &rough.values[3 * i];
    file.Demand(values[2] >= 0, "rough_position", "has a negative radius");
    for (int k = 0; k < 3; ++k) file.Demand(std::abs(values[k]) <= kMaxRough_m, "rough_position");
    if (values[2] > 0) query.rough_position = RoughPosition{{values[0], values[1]}, values[2]};
  }
  return queries;
}

}  // namespace nightmap
