// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/edges_io.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <set>
#include <tuple>

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kEdgesFormat[] = "nightmap edges";
constexpr int kEdgesVersion = 1;

// An optimizer takes the root of the inverse, so that must exist too.
bool IsCovariance(const Matrix6d& matrix) {
  const Matrix6d asymmetry = matrix - matrix.transpose();
  if (asymmetry.cwiseAbs().maxCoeff() > 1e-9 * matrix.cwiseAbs().maxCoeff()) return false;
  const Eigen::LLT<Matrix6d> root(matrix);
  if (root.info() != Eigen::Success) return false;
  const Matrix6d information = root.solve(Matrix6d::Identity());
  return information.allFinite() && information.llt().info() == Eigen::Success;
}

void CheckTimes(const Hdf5Reader& file, const std::vector<SensorEdge>& edges) {
  std::set<std::tuple<EdgeKind, std::int64_t, std::int64_t>> known;
  std::optional<std::int64_t> end_ns;  // of the odometry so far
  for (const SensorEdge& edge : edges) {
    const std::int64_t source_ns = edge.source_time_ns;
    const std::int64_t target_ns = edge.target_time_ns;
    if (edge.kind == EdgeKind::kPrior) {
      file.Demand(source_ns == target_ns, "time_ns", "has two nodes for a prior");
    } else {
      file.Demand(source_ns != target_ns, "time_ns", "has an edge from a node to itself");
    }
    const auto nodes = std::minmax(source_ns, target_ns);
    file.Demand(
        known.emplace(edge.kind, nodes.first, nodes.second).second, "time_ns", "has an edge twice");
    if (edge.kind != EdgeKind::kOdometry) continue;
    file.Demand(source_ns < target_ns && (!end_ns || *end_ns <= source_ns),
                "time_ns",
                "has odometry that does not ascend");
    end_ns = target_ns;
  }
}

constexpr auto kEdges = Hdf5Table<SensorEdge>(
    Hdf5Column("kind", &SensorEdge::kind)
        .Rows([](const SensorEdge& edge) { return edge.kind <= EdgeKind::kPrior; },
              "has an unknown kind"),
    Hdf5Column("time_ns", &SensorEdge::source_time_ns, &SensorEdge::target_time_ns),
    Hdf5Column("target_from_source", &SensorEdge::target_from_source),
    Hdf5Column("covariance", &SensorEdge::covariance)
        .Rows([](const SensorEdge& edge) { return IsCovariance(edge.covariance); },
              "is not symmetric and positive definite"));

constexpr auto kSensorPose = Hdf5Table<Rigid3>(Hdf5Column("robot_from_sensor", kItself));
constexpr auto kCameraPoses = Hdf5Table<Rigid3>(Hdf5Column("robot_from_camera", kItself));

std::optional<Mounting> ReadMounting(const Hdf5Reader& file) {
  if (!file.Has("robot_from_sensor")) return std::nullopt;
  const auto sensor = kSensorPose.Read(file);
  file.Demand(sensor.size() == 1, "robot_from_sensor");
  return Mounting{sensor[0], kCameraPoses.Read(file)};
}

}  // namespace

void WriteEdges(const std::filesystem::path& path,
                const SensorEdges& edges,
                const std::string& config) {
  Hdf5Writer file(
      path,
      kEdgesFormat,
      kEdgesVersion,
      config,
      "metres; rad; covariance: rotation, then translation, along the axes of the target");
  file.WriteText("sensor", edges.sensor);
  kEdges.Write(edges.edges, &file);
  if (edges.mounting) {
    kSensorPose.Write(std::array{edges.mounting->robot_from_sensor}, &file);
    kCameraPoses.Write(edges.mounting->robot_from_camera, &file);
  }
  file.Close();
}

SensorEdges ReadEdges(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kEdgesFormat, kEdgesVersion);
  SensorEdges edges{file.ReadText("sensor"), {}, {}};
  file.Demand(!edges.sensor.empty(), "sensor", "is empty");
  edges.edges = kEdges.Read(file);
  CheckTimes(file, edges.edges);
  edges.mounting = ReadMounting(file);
  return edges;
}

}  // namespace nightmap
