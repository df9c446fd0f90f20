// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/frames/write_frames.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "pipeline/base/files.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/io/unit_list.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr const char* kPort = "shards";

// Files of truth, which a site may have or not.
constexpr const char* kFilesOfTruth[] = {"ground_truth.tum", "robot_truth.tum", "relations.txt"};

// Writes files next to shards.txt and remembers their names.
class Writer {
 public:
  explicit Writer(StageContext& context) : context_(context) {}

  void Write(const std::string& name, const std::string& text) {
    WriteFile(context_.OutputBeside(kPort, name), text);
    names_.insert(name);
  }

  void Write(const SignalKindRow& row, const std::vector<Signal>& all) {
    std::vector<Signal> signals;
    for (const Signal& signal : all) {
      if (signal.kind == row.kind) signals.push_back(signal);
    }
    WriteSignals(context_.OutputBeside(kPort, row.file), row.kind, signals);
  }

  void RemoveOthers() const {
    const fs::path folder = fs::absolute(context_.FinalPath(kPort)).parent_path();
    for (const auto& entry : fs::directory_iterator(folder)) {
      const std::string name = entry.path().filename().string();
      const bool ours = (name.starts_with("shard_") && name.ends_with(".csv")) ||
                        std::ranges::find(kFilesOfTruth, name) != std::end(kFilesOfTruth);
      if (ours && !names_.contains(name)) fs::remove(entry.path());
    }
  }

 private:
  StageContext& context_;
  std::set<std::string> names_;
};

void WriteTruth(const RobotTruth& truth, Writer& writer, nlohmann::json& report) {
  if (!truth.truth_from_robot.empty()) {
    writer.Write("robot_truth.tum",
                 TrajectoryToTum(truth.truth_from_robot, "truth of the site, truth_from_robot"));
    report["num_robot_truth_poses"] = truth.truth_from_robot.size();
  }
  if (!truth.relations.empty()) {
    writer.Write("relations.txt", truth.relations);
    report["num_relations"] = truth.num_relations;
  }
}

void Report(const FrameLists& lists, const std::vector<Signal>& signals, nlohmann::json& report) {
  std::set<int> sequences;
  std::map<std::string, std::size_t> num_of_channel;
  for (const FrameRecord& frame : lists.frames) {
    sequences.insert(frame.sequence_idx);
    for (const auto& [name, file] : ChannelsOf(frame)) {
      num_of_channel[name] += file->path.empty() ? 0 : 1;
    }
  }
  const auto& frames = lists.frames;
  const auto duration_ns = frames.empty() ? 0 : frames.back().time_ns - frames.front().time_ns;
  report["num_frames"] = frames.size();
  report["num_frames_unusable"] = lists.num_frames_unusable;
  report["num_held_out"] = lists.held_out.size();
  report["num_sequences"] = sequences.size();
  report["duration_s"] = static_cast<double>(duration_ns) / 1e9;
  report["has_ground_truth"] = !lists.ground_truth.empty();
  report["num_frames_with_ground_truth"] = lists.ground_truth.size();
  for (const auto& [name, count] : num_of_channel) report["num_frames_with_" + name] = count;
  for (const Signal& signal : signals) {
    report["num_samples"][signal.sensor_id] = signal.samples.size();
  }
}

void ReportLimit(const std::string& id, float range_of_no_hit_m, nlohmann::json& report) {
  report["range_of_no_hit_m"][id] = range_of_no_hit_m;
  spdlog::warn(
      "\"{}\" writes the range {} where it hit nothing, which its [[sensor]] does not say: "
      "such beams are taken so; write max_range_m = {}",
      id,
      range_of_no_hit_m,
      range_of_no_hit_m);
}

void ReportBody(const std::string& id,
                const RobotBody& body,
                bool is_left_out,
                nlohmann::json& report) {
  report["robot_body"][id] = {{"share", body.share},
                              {"largest_range_m", std::round(1e3 * body.largest_range_m) / 1e3},
                              {"sectors_deg", body.sectors_deg},
                              {"remedy", body.remedy},
                              {"is_left_out", is_left_out}};
  if (body.share == 0) return;
  spdlog::warn(
      "\"{}\" sees something that stays at one distance in {:.1f} % of its directions, up to "
      "{:.2f} m: {} write {}",
      id,
      100 * body.share,
      body.largest_range_m,
      is_left_out ? "the robot itself, which is left out;"
                  : "it is not left out; where it is the robot itself,",
      body.remedy);
}

}  // namespace

void ReportLeftOut(const FramesOptions& options, std::size_t num_left_out, nlohmann::json& report) {
  report["num_left_out_by_max_frames"] = num_left_out;
  if (num_left_out == 0) return;
  spdlog::warn("max_frames = {} leaves out the last {} frames; raise it to map them",
               options.max_frames,
               num_left_out);
}

void ReportTimesInLineOrder(const SiteConfig& site,
                            const std::vector<std::size_t>& num_in_line_order,
                            nlohmann::json& report) {
  for (std::size_t i = 0; i < num_in_line_order.size(); ++i) {
    if (num_in_line_order[i] == 0) continue;
    const std::string& id = site.sensors[i].id;
    report["num_times_in_line_order"][id] = num_in_line_order[i];
    spdlog::warn(
        "{} samples of {} have times that contradict the order of lines: they get times between "
        "those of other lines",
        num_in_line_order[i],
        id);
  }
}

void ReportFoundInScans(const SiteConfig& site,
                        const std::vector<FoundInScans>& found,
                        nlohmann::json& report) {
  for (std::size_t i = 0; i < found.size(); ++i) {
    const std::string& id = site.sensors[i].id;
    if (found[i].range_of_no_hit_m) ReportLimit(id, *found[i].range_of_no_hit_m, report);
    if (found[i].body) ReportBody(id, *found[i].body, found[i].is_body_left_out, report);
  }
}

void ReportApart(const std::vector<std::string>& apart, nlohmann::json& report) {
  if (apart.empty()) return;
  report["odometry_apart"] = apart;
  for (const std::string& text : apart) spdlog::warn("{}", text);
}

void ReportSkipped(const FramesOptions& options,
                   const FrameLists& lists,
                   const std::vector<std::string>& problems,
                   StageContext& context) {
  for (const std::string& reason : lists.skipped) context.Skip(reason);
  context.CheckSkipped(lists.num_inspected, options.max_failed_ratio);
  for (const std::string& reason : problems) context.Skip(reason);
  for (const std::string& reason : lists.left_out) context.Skip(reason);
}

void CheckAnyIsLeft(const FrameLists& lists, const fs::path& data_root) {
  if (!lists.frames.empty()) return;
  throw DataError("{}: no usable frame is left: see the skipped ones above", data_root.string());
}

void WriteFrames(const FramesOptions& options,
                 const std::vector<RgbdCamera>& cameras,
                 FrameLists lists,
                 const std::vector<Signal>& signals,
                 const RobotTruth& robot_truth,
                 StageContext& context) {
  Writer writer(context);
  const auto map_cameras = KeepUsedCameras(cameras, &lists.frames);
  writer.Write("cameras.json", CamerasToJson(map_cameras));
  std::vector<std::string> names;
  const auto shards = CutShards(lists.frames, options.shard_size);
  for (std::size_t i = 0; i < shards.size(); ++i) {
    names.push_back(fmt::format("{:04}", i));
    writer.Write("shard_" + names.back() + ".csv", FramesToCsv(shards[i]));
  }
  const std::string comment = "ground truth of the site, world_from_camera, at the times of the ";
  if (!lists.ground_truth.empty()) {
    writer.Write("ground_truth.tum", TrajectoryToTum(lists.ground_truth, comment + "frames"));
  }
  writer.Write("held_out.csv", FramesToCsv(lists.held_out));
  writer.Write("held_out.tum",
               TrajectoryToTum(lists.held_out_ground_truth, comment + "held-out frames"));
  for (const SignalKindRow& row : SignalKinds()) writer.Write(row, signals);
  WriteTruth(robot_truth, writer, context.Report());
  WriteFile(context.Output(kPort), NameListToText("shards", names));
  Report(lists, signals, context.Report());
  context.Report()["num_cameras"] = map_cameras.size();
  context.Report()["num_shards"] = shards.size();
  writer.RemoveOthers();
}

}  // namespace nightmap
