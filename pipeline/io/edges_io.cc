// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/edges_io.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <optional>
#include <set>
#include <tuple>

#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/pose_arrays.h"

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

void WriteMounting(const Mounting& mounting, Hdf5Writer* file) {
  Array<double> sensor{0, 7, {}}, cameras{0, 7, {}};
  AppendPose(mounting.robot_from_sensor, &sensor);
  for (const Rigid3& robot_from_camera : mounting.robot_from_camera) {
    AppendPose(robot_from_camera, &cameras);
  }
  file->Write("robot_from_sensor", sensor);
  file->Write("robot_from_camera", cameras);
}

std::optional<Mounting> ReadMounting(const Hdf5Reader& file, const std::filesystem::path& path) {
  if (!file.Has("robot_from_sensor")) return std::nullopt;
  const auto sensor = file.Read<double>("robot_from_sensor", 7);
  const auto cameras = file.Read<double>("robot_from_camera", 7);
  file.Demand(sensor.rows == 1, "robot_from_sensor");
  Mounting mounting{PoseAt(sensor, 0, path), {}};
  for (std::size_t i = 0; i < cameras.rows; ++i) {
    mounting.robot_from_camera.push_back(PoseAt(cameras, i, path));
  }
  return mounting;
}

}  // namespace

void WriteEdges(const std::filesystem::path& path,
                const SensorEdges& edges,
                const std::string& config) {
  std::vector<std::uint8_t> kind;
  Array<std::int64_t> time_ns{edges.edges.size(), 2, {}};
  Array<double> pose{0, 7, {}}, covariance{0, 36, {}};
  for (const SensorEdge& edge : edges.edges) {
    kind.push_back(static_cast<std::uint8_t>(edge.kind));
    time_ns.values.insert(time_ns.values.end(), {edge.source_time_ns, edge.target_time_ns});
    AppendPose(edge.target_from_source, &pose);
    AppendCovariance(edge.covariance, &covariance);
  }
  Hdf5Writer file(
      path,
      kEdgesFormat,
      kEdgesVersion,
      config,
      "metres; rad; covariance: rotation, then translation, along the axes of the target");
  file.WriteText("sensor", edges.sensor);
  file.WriteList("kind", kind);
  file.Write("time_ns", time_ns);
  file.Write("target_from_source", pose);
  file.Write("covariance", covariance);
  if (edges.mounting) WriteMounting(*edges.mounting, &file);
  file.Close();
}

SensorEdges ReadEdges(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kEdgesFormat, kEdgesVersion);
  SensorEdges edges;
  edges.sensor = file.ReadText("sensor");
  const auto kind = file.ReadList<std::uint8_t>("kind");
  const auto time_ns = file.Read<std::int64_t>("time_ns", 2);
  const auto pose = file.Read<double>("target_from_source", 7);
  const auto covariance = file.Read<double>("covariance", 36);
  file.Demand(!edges.sensor.empty(), "sensor", "is empty");
  file.Demand(time_ns.rows == kind.size(), "time_ns");
  file.Demand(pose.rows == kind.size(), "target_from_source");
  file.Demand(covariance.rows == kind.size(), "covariance");
  for (std::size_t i = 0; i < kind.size(); ++i) {
    file.Demand(kind[i] <= static_cast<int>(EdgeKind::kPrior), "kind", "has an unknown kind");
    edges.edges.push_back({static_cast<EdgeKind>(kind[i]),
                           time_ns.values[2 * i],
                           time_ns.values[2 * i + 1],
                           PoseAt(pose, i, path),
                           CovarianceAt(covariance, i)});
    file.Demand(IsCovariance(edges.edges[i].covariance),
                "covariance",
                "is not symmetric and positive definite");
  }
  CheckTimes(file, edges.edges);
  edges.mounting = ReadMounting(file, path);
  return edges;
}

}  // namespace nightmap
