// SPDX-License-Identifier: Apache-2.0
#include "stages/world/synthesize/write_site.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstring>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/grid_io.h"
#include "pipeline/io/image_io.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/world/true_things.h"
#include "stages/world/synthesize/robot_recording.h"

namespace nightmap {

namespace {

namespace fs = std::filesystem;

constexpr double kDepthUnitsPerM = 5000;

RawDepthImage ToRawDepth(const DepthImage& depth) {
  RawDepthImage raw{depth.width, depth.height, 1, {}};
  raw.pixels.reserve(depth.pixels.size());
  for (const float depth_m : depth.pixels) {
    raw.pixels.push_back(static_cast<std::uint16_t>(std::lround(depth_m * kDepthUnitsPerM)));
  }
  return raw;
}

std::vector<double> ToList(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }

nlohmann::ordered_json ToJson(const Box& box) {
  return {{"center_m", ToList(box.center)},
          {"half_size_m", ToList(box.half_size)},
          {"yaw_rad", box.yaw_rad},
          {"label", static_cast<int>(box.label)},
          {"piece", box.piece_idx}};
}

template <typename T>
void AppendBytes(std::string& bytes, const T& value) {
  static_assert(std::endian::native == std::endian::little);
  std::array<char, sizeof(T)> raw{};
  std::memcpy(raw.data(), &value, sizeof(T));
  bytes.append(raw.data(), raw.size());
}

}  // namespace

std::vector<RecordingFile> ListsAndTruth(const SynthesizeOptions& options,
                                         const SynthesizePlan& plan) {
  std::vector<RecordingFile> files;
  if (options.render) {
    const std::string comment = "building_from_camera; time_s tx ty tz qx qy qz qw";
    files = {{"rgb.txt", FileList(plan.frames, "rgb", "jpg")},
             {"depth.txt", FileList(plan.frames, "depth", "png")},
             {"groundtruth.txt", TrajectoryToTum(plan.frames, comment)},
             {"camera.json", CameraJson(options)},
             {"queries/rgb.txt", FileList(plan.queries, "rgb", "jpg")},
             {"queries/depth.txt", FileList(plan.queries, "depth", "png")},
             {"queries/groundtruth.txt", TrajectoryToTum(plan.queries, comment)}};
  }
  if (!plan.upward.empty()) {
    const std::string comment = "building_from_camera; time_s tx ty tz qx qy qz qw";
    files.push_back({"up/rgb.txt", FileList(plan.upward, "rgb", "jpg")});
    files.push_back({"up/groundtruth.txt", TrajectoryToTum(plan.upward, comment)});
  }
  for (std::size_t i = 0; i < plan.floor_plans.size(); ++i) {
    const std::string name = FloorPlanName(i);
    files.push_back({"truth/" + name + ".pgm", GridToPgm(plan.floor_plans[i])});
    files.push_back({"truth/" + name + ".yaml", GridToYaml(plan.floor_plans[i], name + ".pgm")});
  }
  files.push_back({"truth/boxes.json", TruthJson(plan.world)});
  files.push_back({"truth/surfaces.ply", TruthMesh(plan.world)});
  return files;
}

void ClearRecording(const fs::path& summary, const SynthesizeOptions& options) {
  const fs::path folder = summary.parent_path();
  TakeRecordingFolder(summary, fs::exists(folder / "rgb") || fs::exists(folder / kRobotLog));
  for (const fs::path& part : {folder, folder / "queries"}) {
    for (const char* name : {"rgb", "depth", "labels"}) {
      fs::remove_all(part / name);
      if (options.render) fs::create_directories(part / name);
    }
  }
  if (!options.render) {
    fs::remove_all(folder / "queries");
    for (const char* name : {"rgb.txt", "depth.txt", "groundtruth.txt", "camera.json"}) {
      fs::remove(folder / name);
    }
  }
  fs::remove_all(folder / "up" / "rgb");
  if (options.render && options.upward.rate_hz > 0) {
    fs::create_directories(folder / "up" / "rgb");
  } else {
    fs::remove_all(folder / "up");
  }
  if (options.scanner.rate_hz <= 0) {
    for (const char* name : {kRobotLog, kRobotTruth}) fs::remove(folder / name);
  }
}

void WriteFrame(const fs::path& folder,
                const WritingFolder& writing,
                std::size_t idx,
                const RenderedFrame& frame) {
  const std::string name = fmt::format("{:06}", idx);
  WriteAtomically(folder / "rgb" / (name + ".jpg"), writing, [&](const fs::path& path) {
    WriteJpeg(path, frame.color);
  });
  WriteAtomically(folder / "depth" / (name + ".png"), writing, [&](const fs::path& path) {
    WritePng(path, ToRawDepth(frame.depth));
  });
  WriteAtomically(folder / "labels" / (name + ".png"), writing, [&](const fs::path& path) {
    WritePng(path, frame.labels);
  });
}

void RenderInto(const fs::path& folder,
                const SynthesizeOptions& options,
                const SynthesizePlan& plan,
                Progress& progress,
                int num_threads) {
  if (!options.render) return;
  const fs::path queries = folder / "queries";
  const WritingFolder writing(folder), writing_queries(queries);
  const auto sink = [&](bool is_query, std::size_t idx, const RenderedFrame& frame) {
    WriteFrame(is_query ? queries : folder, is_query ? writing_queries : writing, idx, frame);
  };
  RunSynthesize(options, plan, sink, progress, num_threads);
}

void RenderUpwardInto(const fs::path& folder,
                      const SynthesizeOptions& options,
                      const SynthesizePlan& plan,
                      Progress& progress,
                      int num_threads) {
  const WritingFolder writing(folder / "up");
  const auto sink = [&](std::size_t idx, const ColorImage& picture) {
    WriteAtomically(folder / "up" / "rgb" / fmt::format("{:06}.jpg", idx),
                    writing,
                    [&](const fs::path& path) { WriteJpeg(path, picture); });
  };
  RunUpward(options, plan, sink, progress, num_threads);
}

std::string CameraJson(const SynthesizeOptions& options) {
  const Camera camera = options.camera.Pinhole();
  nlohmann::ordered_json json;
  json["width_px"] = camera.width;
  json["height_px"] = camera.height;
  json["fx_px"] = camera.fx;
  json["fy_px"] = camera.fy;
  json["cx_px"] = camera.cx;
  json["cy_px"] = camera.cy;
  json["depth_units_per_m"] = kDepthUnitsPerM;
  json["min_depth_m"] = options.sensor.min_depth_m;
  json["max_depth_m"] = options.sensor.max_depth_m;
  return json.dump(2) + "\n";
}

std::string FloorPlanName(std::size_t floor) {
  return floor == 0 ? "floor_plan" : fmt::format("floor_plan_{}", floor);
}

std::string TruthJson(const SyntheticWorld& world) {
  nlohmann::ordered_json json;
  json["format"] = "nightmap_true_surfaces";
  json["version"] = 1;
  json["units"] = "metres, radians; building frame: z up, floor z = 0";
  for (int i = 0; i < kNumSurfaceLabels; ++i)
    json["labels"].push_back(LabelName(static_cast<SurfaceLabel>(i)));
  const FloorLayout& layout = world.layout;
  std::vector<Rect2> doorways = layout.doorways;
  if (layout.ramp_hall) doorways.push_back(layout.ramp_hall->passage);
  for (int floor = 0; floor < layout.num_floors; ++floor) {
    nlohmann::ordered_json list = nlohmann::ordered_json::array();
    for (const Rect2& door : doorways) list.push_back({door.x0, door.y0, door.x1, door.y1});
    json["floors"].push_back({{"height_m", floor * layout.storey_m},
                              {"plan", FloorPlanName(static_cast<std::size_t>(floor)) + ".yaml"},
                              {"doorways_m", list}});
  }
  if (const Rect2& blank = layout.blank; blank.Area() > 0) {
    json["blank_corridor_m"] = {blank.x0, blank.y0, blank.x1, blank.y1};
  }
  json["boxes"] = nlohmann::ordered_json::array();
  for (const Box& box : world.scene.boxes) json["boxes"].push_back(ToJson(box));
  json["things"] = nlohmann::ordered_json::array();
  for (const Box& thing : TrueThings(world.scene.boxes)) {
    json["things"].push_back(ToJson(thing));
    json["things"].back()["class"] = LabelName(thing.label);
  }
  json["rectangles"] = nlohmann::ordered_json::array();
  for (const Surface& surface : world.scene.surfaces) {
    const bool is_slab = surface.label == SurfaceLabel::kFloor ||
                         surface.label == SurfaceLabel::kCeiling ||
                         surface.label == SurfaceLabel::kLamp;
    if (!is_slab) continue;
    json["rectangles"].push_back({{"origin_m", ToList(surface.origin)},
                                  {"edge_u_m", ToList(surface.edge_u)},
                                  {"edge_v_m", ToList(surface.edge_v)},
                                  {"label", static_cast<int>(surface.label)}});
  }
  return json.dump(1) + "\n";
}

std::string TruthMesh(const SyntheticWorld& world) {
  const std::size_t num_surfaces = world.scene.surfaces.size();
  std::string bytes = fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment building frame: z up, floor z = 0, metres\n"
      "element vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
      "element face {}\nproperty list uchar int vertex_indices\nproperty uchar label\nend_header\n",
      4 * num_surfaces,
      2 * num_surfaces);
  for (const Surface& surface : world.scene.surfaces) {
    for (const auto& [a, b] : {std::pair{0, 0}, {1, 0}, {1, 1}, {0, 1}}) {
      const Eigen::Vector3f corner =
          (surface.origin + a * surface.edge_u + b * surface.edge_v).cast<float>();
      for (int c = 0; c < 3; ++c) AppendBytes(bytes, corner[c]);
    }
  }
  for (std::size_t i = 0; i < num_surfaces; ++i) {
    const auto first = static_cast<std::int32_t>(4 * i);
    // Counter-clockwise seen from the front.
    for (const std::array<std::int32_t, 3>& corners : {std::array{0, 3, 2}, std::array{0, 2, 1}}) {
      AppendBytes(bytes, std::uint8_t{3});
      for (const std::int32_t corner : corners) AppendBytes(bytes, first + corner);
      AppendBytes(bytes, static_cast<std::uint8_t>(world.scene.surfaces[i].label));
    }
  }
  return bytes;
}

}  // namespace nightmap
