// SPDX-License-Identifier: Apache-2.0
#include "pipeline/graph/closed_graph_io.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kGraphFormat[] = "nightmap pose graph";
constexpr int kGraphVersion = 1;
constexpr int kCamera = -1;  // in place of a sensor's index

enum class StoredKind : std::uint8_t { kOdometry, kBridge, kReplacedBridge, kLoop, kPrior };

struct StoredFrame {
  Rigid3 graph_from_camera;
  bool is_guessed = false;
};
using StoredKeyframe = std::pair<int, Rigid3>;  // with its index
struct StoredEdge : PoseEdge {
  StoredKind kind = StoredKind::kOdometry;
  int sensor = kCamera;
};
using StoredFilling = std::pair<int, int>;  // keyframe after the bridge, sensor

constexpr auto kFrames =
    Hdf5Table<StoredFrame>(Hdf5Column("odometry_from_camera", &StoredFrame::graph_from_camera),
                           Hdf5Column("is_guessed", &StoredFrame::is_guessed));

constexpr auto kKeyframes = Hdf5Table<StoredKeyframe>(
    Hdf5Column("keyframe_idx", &StoredKeyframe::first).Pairs(Ascending(&StoredKeyframe::first)),
    Hdf5Column("graph_from_keyframe", &StoredKeyframe::second));

constexpr auto kGraphEdges = Hdf5Table<StoredEdge>(
    Hdf5Column("edge_kind", &StoredEdge::kind).Rows([](const StoredEdge& edge) {
      return edge.kind <= StoredKind::kPrior;
    }),
    Hdf5Column("edge_sensor", &StoredEdge::sensor),
    Hdf5Column("edge_frame", &StoredEdge::frame_a, &StoredEdge::frame_b),
    Hdf5Column("edge_b_from_a", &StoredEdge::b_from_a),
    Hdf5Column("edge_covariance", &StoredEdge::covariance));

constexpr auto kAcceptedLoops = Hdf5Table<std::uint8_t>(Hdf5Column("is_loop_accepted", kItself));

constexpr auto kFilledBridges = Hdf5Table<StoredFilling>(
    Hdf5Column("filled_bridge", &StoredFilling::first, &StoredFilling::second));

std::vector<StoredFrame> FramesOf(const OdometryChain& chain) {
  std::vector<StoredFrame> frames;
  for (const Rigid3& pose : chain.graph_from_camera) frames.push_back({pose});
  for (const int idx : chain.guessed) frames[static_cast<std::size_t>(idx)].is_guessed = true;
  return frames;
}

std::vector<StoredEdge> EdgesOf(const ClosedGraph& graph) {
  std::vector<StoredEdge> edges;
  for (const PoseEdge& edge : graph.chain.edges) {
    const bool is_replaced = graph.replaced_bridges.contains(edge.frame_b);
    const StoredKind bridge = is_replaced ? StoredKind::kReplacedBridge : StoredKind::kBridge;
    edges.push_back({edge, edge.is_bridge ? bridge : StoredKind::kOdometry, kCamera});
  }
  for (std::size_t i = 0; i < graph.sensors.size(); ++i) {
    const int idx = static_cast<int>(i);
    const SensorGraph& sensor = graph.sensors[i];
    for (const PoseEdge& e : sensor.odometry) edges.push_back({e, StoredKind::kOdometry, idx});
    for (const PoseEdge& e : sensor.loops) edges.push_back({e, StoredKind::kLoop, idx});
    for (const PoseEdge& e : sensor.priors) edges.push_back({e, StoredKind::kPrior, idx});
  }
  return edges;
}

class GraphReader {
 public:
  explicit GraphReader(const std::filesystem::path& path)
      : file_(path, kGraphFormat, kGraphVersion) {}

  ClosedGraph Read() {
    ReadSensors();
    ReadFrames();
    ReadKeyframes();
    for (const StoredEdge& edge : kGraphEdges.Read(file_)) AddEdge(edge);
    ReadFilledBridges();
    const auto floor = file_.ReadList<double>("sigma_floor");
    file_.Demand(floor.size() == 2, "sigma_floor");
    graph_.floor = {floor[0], floor[1]};
    const auto is_accepted = kAcceptedLoops.Read(file_);
    graph_.is_loop_accepted.assign(is_accepted.begin(), is_accepted.end());
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
    OdometryChain& chain = graph_.chain;
    for (const StoredFrame& frame : kFrames.Read(file_)) {
      if (frame.is_guessed) chain.guessed.insert(static_cast<int>(chain.graph_from_camera.size()));
      chain.graph_from_camera.push_back(frame.graph_from_camera);
    }
  }

  void ReadKeyframes() {
    const auto keyframes = kKeyframes.Read(file_);
    file_.Demand(!keyframes.empty() && keyframes[0].first == 0,
                 "keyframe_idx",
                 "does not begin with frame 0");
    for (const auto& [idx, pose] : keyframes) {
      file_.Demand(IsFrame(idx), "keyframe_idx");
      graph_.graph_from_keyframe.emplace(idx, pose);
      graph_.chain.keyframes.insert(idx);
    }
  }

  void AddEdge(const StoredEdge& edge) {
    const bool is_prior = edge.kind == StoredKind::kPrior;
    file_.Demand(IsFrame(edge.frame_b) && edge.frame_a < edge.frame_b &&
                     (is_prior ? edge.frame_a == kMapNode : IsFrame(edge.frame_a)),
                 "edge_frame");
    if (edge.sensor == kCamera) return AddOdometry(edge.kind, edge);
    file_.Demand(IsSensor(edge.sensor), "edge_sensor", "names no sensor");
    SensorGraph& sensor = graph_.sensors[static_cast<std::size_t>(edge.sensor)];
    switch (edge.kind) {
      case StoredKind::kOdometry:
        return sensor.odometry.push_back(edge);
      case StoredKind::kLoop:
        return sensor.loops.push_back(edge);
      case StoredKind::kPrior:
        return sensor.priors.push_back(edge);
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
    for (const auto& [keyframe, sensor_idx] : kFilledBridges.Read(file_)) {
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
  Hdf5Writer file(path,
                  kGraphFormat,
                  kGraphVersion,
                  config,
                  "metres; rad; target_from_source poses; covariance: rotation, then translation");
  file.WriteText("sensors", sensors.dump());
  file.WriteList("sigma_floor", std::vector<double>{graph.floor.m, graph.floor.rad});
  kFrames.Write(FramesOf(graph.chain), &file);
  kKeyframes.Write(graph.graph_from_keyframe, &file);
  kGraphEdges.Write(EdgesOf(graph), &file);
  kAcceptedLoops.Write(graph.is_loop_accepted, &file);
  kFilledBridges.Write(graph.filled, &file);
  file.Close();
}

ClosedGraph ReadClosedGraph(const std::filesystem::path& path) { return GraphReader(path).Read(); }

}  // namespace nightmap
