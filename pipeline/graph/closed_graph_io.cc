// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/closed_graph_io.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/pose_arrays.h"

namespace nightmap {
namespace {

constexpr char kGraphFormat[] = "nightmap pose graph";
constexpr int kGraphVersion = 1;
constexpr int kCamera = -1;  // in place of a sensor's index

enum class StoredKind : std::uint8_t { kOdometry, kBridge, kReplacedBridge, kLoop, kPrior };

class EdgeTable {
 public:
  void Add(StoredKind kind, int sensor_idx, const PoseEdge& edge) {
    kind_.push_back(static_cast<std::uint8_t>(kind));
    sensor_.push_back(sensor_idx);
    frame_.values.insert(frame_.values.end(), {edge.frame_a, edge.frame_b});
    ++frame_.rows;
    AppendPose(edge.b_from_a, &pose_);
    AppendCovariance(edge.covariance, &covariance_);
  }

  void Write(Hdf5Writer* file) const {
    file->WriteList("edge_kind", kind_);
    file->WriteList("edge_sensor", sensor_);
    file->Write("edge_frame", frame_);
    file->Write("edge_b_from_a", pose_);
    file->Write("edge_covariance", covariance_);
  }

 private:
  std::vector<std::uint8_t> kind_;
  std::vector<std::int32_t> sensor_;
  Array<std::int32_t> frame_{0, 2, {}};
  Array<double> pose_{0, 7, {}}, covariance_{0, 36, {}};
};

EdgeTable EdgesOf(const ClosedGraph& graph) {
  EdgeTable table;
  for (const PoseEdge& edge : graph.chain.edges) {
    const bool is_replaced = graph.replaced_bridges.contains(edge.frame_b);
    const StoredKind bridge = is_replaced ? StoredKind::kReplacedBridge : StoredKind::kBridge;
    table.Add(edge.is_bridge ? bridge : StoredKind::kOdometry, kCamera, edge);
  }
  for (std::size_t i = 0; i < graph.sensors.size(); ++i) {
    const int sensor_idx = static_cast<int>(i);
    const SensorGraph& sensor = graph.sensors[i];
    for (const PoseEdge& e : sensor.odometry) table.Add(StoredKind::kOdometry, sensor_idx, e);
    for (const PoseEdge& e : sensor.loops) table.Add(StoredKind::kLoop, sensor_idx, e);
    for (const PoseEdge& e : sensor.priors) table.Add(StoredKind::kPrior, sensor_idx, e);
  }
  return table;
}

void WriteFrames(const ClosedGraph& graph, Hdf5Writer* file) {
  Array<double> frame_pose{0, 7, {}}, keyframe_pose{0, 7, {}};
  std::vector<std::uint8_t> is_guessed(graph.chain.graph_from_camera.size());
  for (const Rigid3& pose : graph.chain.graph_from_camera) AppendPose(pose, &frame_pose);
  for (const int idx : graph.chain.guessed) is_guessed[static_cast<std::size_t>(idx)] = 1;
  std::vector<std::int32_t> keyframe_idx;
  for (const auto& [idx, pose] : graph.graph_from_keyframe) {
    keyframe_idx.push_back(idx);
    AppendPose(pose, &keyframe_pose);
  }
  file->Write("odometry_from_camera", frame_pose);
  file->WriteList("is_guessed", is_guessed);
  file->WriteList("keyframe_idx", keyframe_idx);
  file->Write("graph_from_keyframe", keyframe_pose);
}

class GraphReader {
 public:
  explicit GraphReader(const std::filesystem::path& path)
      : file_(path, kGraphFormat, kGraphVersion) {}

  ClosedGraph Read() {
    ReadSensors();
    ReadFrames();
    ReadKeyframes();
    ReadEdges();
    ReadFilledBridges();
    const auto floor = file_.ReadList<double>("sigma_floor");
    file_.Demand(floor.size() == 2, "sigma_floor");
    graph_.floor = {floor[0], floor[1]};
    for (const auto flag : file_.ReadList<std::uint8_t>("is_loop_accepted")) {
      graph_.is_loop_accepted.push_back(flag != 0);
    }
    return std::move(graph_);
  }

 private:
  void ReadSensors() {
    const auto ids = nlohmann::json::parse(file_.ReadText("sensors"), nullptr, false);
    file_.Demand(ids.is_array(), "sensors", "is no list of ids");
    for (const nlohmann::json& id : ids) {
      file_.Demand(id.is_string(), "sensors", "is no list of ids");
      graph_.sensors.push_back({id.get<std::string>(), {}, {}, {}});
    }
  }

  void ReadFrames() {
    const auto pose = file_.Read<double>("odometry_from_camera", 7);
    const auto is_guessed = file_.ReadList<std::uint8_t>("is_guessed");
    file_.Demand(is_guessed.size() == pose.rows, "is_guessed");
    for (std::size_t i = 0; i < pose.rows; ++i) {
      graph_.chain.graph_from_camera.push_back(PoseAt(pose, i, file_.Path()));
      if (is_guessed[i] != 0) graph_.chain.guessed.insert(static_cast<int>(i));
    }
  }

  void ReadKeyframes() {
    const auto idx = file_.ReadList<std::int32_t>("keyframe_idx");
    const auto pose = file_.Read<double>("graph_from_keyframe", 7);
    file_.Demand(pose.rows == idx.size(), "graph_from_keyframe");
    file_.Demand(!idx.empty() && idx[0] == 0, "keyframe_idx", "does not begin with frame 0");
    for (std::size_t i = 0; i < idx.size(); ++i) {
      file_.Demand(IsFrame(idx[i]) && (i == 0 || idx[i - 1] < idx[i]), "keyframe_idx");
      graph_.graph_from_keyframe.emplace(idx[i], PoseAt(pose, i, file_.Path()));
      graph_.chain.keyframes.insert(idx[i]);
    }
  }

  void ReadEdges() {
    const auto kind = file_.ReadList<std::uint8_t>("edge_kind");
    const auto sensor = file_.ReadList<std::int32_t>("edge_sensor");
    const auto frame = file_.Read<std::int32_t>("edge_frame", 2);
    const auto pose = file_.Read<double>("edge_b_from_a", 7);
    const auto covariance = file_.Read<double>("edge_covariance", 36);
    file_.Demand(sensor.size() == kind.size(), "edge_sensor");
    file_.Demand(frame.rows == kind.size(), "edge_frame");
    file_.Demand(pose.rows == kind.size(), "edge_b_from_a");
    file_.Demand(covariance.rows == kind.size(), "edge_covariance");
    for (std::size_t i = 0; i < kind.size(); ++i) {
      file_.Demand(kind[i] <= static_cast<int>(StoredKind::kPrior), "edge_kind");
      AddEdge(static_cast<StoredKind>(kind[i]),
              sensor[i],
              {frame.values[2 * i],
               frame.values[2 * i + 1],
               PoseAt(pose, i, file_.Path()),
               CovarianceAt(covariance, i),
               false});
    }
  }

  void AddEdge(StoredKind kind, int sensor_idx, PoseEdge edge) {
    const bool is_prior = kind == StoredKind::kPrior;
    file_.Demand(IsFrame(edge.frame_b) && edge.frame_a < edge.frame_b &&
                     (is_prior ? edge.frame_a == kMapNode : IsFrame(edge.frame_a)),
                 "edge_frame");
    if (sensor_idx == kCamera) return AddOdometry(kind, std::move(edge));
    file_.Demand(IsSensor(sensor_idx), "edge_sensor", "names no sensor");
    SensorGraph& sensor = graph_.sensors[static_cast<std::size_t>(sensor_idx)];
    switch (kind) {
      case StoredKind::kOdometry:
        return sensor.odometry.push_back(std::move(edge));
      case StoredKind::kLoop:
        return sensor.loops.push_back(std::move(edge));
      case StoredKind::kPrior:
        return sensor.priors.push_back(std::move(edge));
      default:
        file_.Fail("edge_kind", "has a bridge of a sensor other than the camera");
    }
  }

  void AddOdometry(StoredKind kind, PoseEdge edge) {
    OdometryChain& chain = graph_.chain;
    file_.Demand(kind <= StoredKind::kReplacedBridge, "edge_kind");
    const int last = chain.edges.empty() ? 0 : chain.edges.back().frame_b;
    file_.Demand(edge.frame_a == last && chain.keyframes.contains(edge.frame_b),
                 "edge_frame",
                 "has odometry that is no chain of keyframes");
    edge.is_bridge = kind != StoredKind::kOdometry;
    if (edge.is_bridge) chain.after_bridge.insert(edge.frame_b);
    if (kind == StoredKind::kReplacedBridge) graph_.replaced_bridges.insert(edge.frame_b);
    chain.edges.push_back(std::move(edge));
  }

  void ReadFilledBridges() {
    const auto filled = file_.Read<std::int32_t>("filled_bridge", 2);
    for (std::size_t i = 0; i < filled.rows; ++i) {
      const int keyframe = filled.values[2 * i], sensor_idx = filled.values[2 * i + 1];
      file_.Demand(graph_.chain.keyframes.contains(keyframe) && IsSensor(sensor_idx),
                   "filled_bridge");
      graph_.filled.emplace(keyframe, static_cast<std::size_t>(sensor_idx));
    }
  }

  bool IsFrame(int idx) const {
    return idx >= 0 && static_cast<std::size_t>(idx) < graph_.chain.graph_from_camera.size();
  }
  bool IsSensor(int idx) const {
    return idx >= 0 && static_cast<std::size_t>(idx) < graph_.sensors.size();
  }

  const Hdf5Reader file_;
  ClosedGraph graph_;
};

}  // namespace

void WriteClosedGraph(const std::filesystem::path& path,
                      const ClosedGraph& graph,
                      const std::string& config) {
  auto sensors = nlohmann::json::array();
  for (const SensorGraph& sensor : graph.sensors) sensors.push_back(sensor.sensor);
  std::vector<std::uint8_t> is_accepted;
  for (const bool flag : graph.is_loop_accepted) is_accepted.push_back(flag);
  Array<std::int32_t> filled{graph.filled.size(), 2, {}};
  for (const auto& [keyframe, sensor_idx] : graph.filled) {
    filled.values.insert(filled.values.end(), {keyframe, static_cast<int>(sensor_idx)});
  }
  Hdf5Writer file(path,
                  kGraphFormat,
                  kGraphVersion,
                  config,
                  "metres; rad; target_from_source poses; covariance: rotation, then translation");
  file.WriteText("sensors", sensors.dump());
  file.WriteList("sigma_floor", std::vector<double>{graph.floor.m, graph.floor.rad});
  WriteFrames(graph, &file);
  EdgesOf(graph).Write(&file);
  file.WriteList("is_loop_accepted", is_accepted);
  file.Write("filled_bridge", filled);
  file.Close();
}

ClosedGraph ReadClosedGraph(const std::filesystem::path& path) { return GraphReader(path).Read(); }

}  // namespace nightmap
