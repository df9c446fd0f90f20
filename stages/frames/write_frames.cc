// SPDX-License-Identifier: Apache-2.0
#include "stages/frames/write_frames.h"

#include <set>
#include <string>
#include <vector>

#include "pipeline/base/files.h"
#include "pipeline/io/name_list.h"
#include "pipeline/io/trajectory_io.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPort = "shards";

std::string AccelerationsToCsv(const std::vector<Acceleration>& samples) {
  std::string text = "time_ns,ax_m_per_s2,ay_m_per_s2,az_m_per_s2\n";
  for (const auto& [time_ns, value] : samples) {
    text += fmt::format("{},{},{},{}\n", time_ns, value.x(), value.y(), value.z());
  }
  return text;
}

// Writes files beside shards.txt and remembers their names.
class Writer {
 public:
  explicit Writer(StageContext& context) : context_(context) {}

  void Write(const std::string& name, const std::string& text) {
    WriteFile(context_.OutputBeside(kPort, name), text);
    names_.insert(name);
  }

  void RemoveOthers() const {
    const fs::path folder = fs::absolute(context_.FinalPath(kPort)).parent_path();
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      const bool ours = (name.starts_with("shard_") && name.ends_with(".csv")) ||
                        name == "ground_truth.tum" || name == "query_ground_truth.tum" ||
                        name == "accelerometer.csv";
      if (ours && !names_.contains(name)) fs::remove(entry.path());
    }
  }

 private:
  StageContext& context_;
  std::set<std::string> names_;
};

void Report(const FrameLists& lists, nlohmann::json& report) {
  std::set<int> sequences;
  for (const FrameRecord& frame : lists.frames) sequences.insert(frame.sequence_idx);
  const auto& frames = lists.frames;
  const auto duration_ns = frames.back().time_ns - frames.front().time_ns;
  report["num_frames"] = frames.size();
  report["num_frames_unusable"] = lists.num_frames_unusable;
  report["num_queries"] = lists.queries.size();
  report["num_sequences"] = sequences.size();
  report["duration_s"] = static_cast<double>(duration_ns) / 1e9;
  report["has_ground_truth"] = !lists.ground_truth.empty();
  report["num_frames_with_ground_truth"] = lists.ground_truth.size();
  report["num_queries_with_ground_truth"] = lists.query_ground_truth.size();
}

}  // namespace

void WriteFrames(const FramesOptions& options,
                 const std::vector<RgbdCamera>& cameras,
                 FrameLists lists,
                 const std::vector<Acceleration>& accelerations,
                 StageContext& context) {
  Writer writer(context);
  const auto map_cameras = KeepUsedCameras(cameras, &lists.frames);
  const auto query_cameras = KeepUsedCameras(cameras, &lists.queries);
  writer.Write("cameras.json", CamerasToJson(map_cameras));
  writer.Write("query_cameras.json", CamerasToJson(query_cameras));
  std::vector<std::string> names;
  const auto shards = CutShards(lists.frames, options.shard_size);
  for (std::size_t i = 0; i < shards.size(); ++i) {
    names.push_back(fmt::format("{:04}", i));
    writer.Write("shard_" + names.back() + ".csv", FramesToCsv(shards[i]));
  }
  writer.Write("queries.csv", FramesToCsv(lists.queries));
  const std::string comment = "ground truth of the site, world_from_camera, at the times of the ";
  if (!lists.ground_truth.empty()) {
    writer.Write("ground_truth.tum", TrajectoryToTum(lists.ground_truth, comment + "frames"));
  }
  if (!lists.query_ground_truth.empty()) {
    writer.Write("query_ground_truth.tum",
                 TrajectoryToTum(lists.query_ground_truth, comment + "queries"));
  }
  if (!accelerations.empty()) writer.Write("accelerometer.csv", AccelerationsToCsv(accelerations));
  WriteFile(context.Output(kPort), NameListToText("shards", names));
  Report(lists, context.Report());
  context.Report()["num_cameras"] = map_cameras.size();
  context.Report()["num_query_cameras"] = query_cameras.size();
  context.Report()["num_shards"] = shards.size();
  writer.RemoveOthers();
}

}  // namespace nightmap
