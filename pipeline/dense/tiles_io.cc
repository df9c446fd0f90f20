// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/tiles_io.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/json_fields.h"

namespace nightmap {
namespace {

using TileJson = nlohmann::ordered_json;

constexpr const char* kTileFormat = "nightmap tile";
constexpr int kTileVersion = 2;

TileJson KeyframeToJson(const Keyframe& keyframe) {
  const FrameRecord& frame = keyframe.frame;
  const auto& t = keyframe.map_from_camera.translation;
  const auto& q = keyframe.map_from_camera.rotation;
  TileJson channels = TileJson::object();
  for (const auto& [name, file] : ChannelsOf(frame)) {
    if (!file->path.empty()) channels[name] = {{"path", file->path}, {"hash", file->hash}};
  }
  return {{"keyframe_idx", keyframe.keyframe_idx},
          {"frame_idx", frame.frame_idx},
          {"time_ns", frame.time_ns},
          {"camera_idx", frame.camera_idx},
          {"sequence_idx", frame.sequence_idx},
          {"channels", channels},
          {"map_from_camera", {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()}}};
}

void ReadChannels(const TileJson& channels, FrameRecord* frame) {
  if (!channels.is_object()) throw DataError("channels is no object");
  for (const auto& [name, file] : channels.items()) {
    ChannelOf(*frame, name) = {file.at("path").get<std::string>(),
                               file.at("hash").get<std::string>()};
  }
  CheckChannels(*frame);
}

Keyframe KeyframeFromJson(const TileJson& json) {
  Keyframe keyframe;
  keyframe.keyframe_idx = IntegerAt(json, "keyframe_idx");
  keyframe.frame.frame_idx = IntegerAt(json, "frame_idx");
  keyframe.frame.time_ns = json.at("time_ns").get<std::int64_t>();
  keyframe.frame.camera_idx = IntegerAt(json, "camera_idx");
  keyframe.frame.sequence_idx = IntegerAt(json, "sequence_idx");
  ReadChannels(json.at("channels"), &keyframe.frame);
  const auto v = json.at("map_from_camera").get<std::vector<double>>();
  if (v.size() != 7) throw DataError("map_from_camera has {} numbers, not 7", v.size());
  Rigid3& pose = keyframe.map_from_camera;
  pose = {Eigen::Quaterniond(v[6], v[3], v[4], v[5]), {v[0], v[1], v[2]}};
  if (!(std::abs(pose.rotation.norm() - 1) < 1e-9) || !pose.translation.allFinite()) {
    throw DataError("map_from_camera of keyframe {} is no rigid transform", keyframe.keyframe_idx);
  }
  return keyframe;
}

Tile TileFromJson(const TileJson& json) {
  if (json.at("format").get<std::string>() != kTileFormat) {
    throw DataError("format is not '{}'", kTileFormat);
  }
  if (IntegerAt(json, "version", 1) > kTileVersion) {
    throw DataError("version is newer than {}: update nightmap", kTileVersion);
  }
  Tile tile;
  tile.region.inside = {{FiniteAt(json, "min_x_m"), FiniteAt(json, "min_y_m")},
                        {FiniteAt(json, "max_x_m"), FiniteAt(json, "max_y_m")}};
  tile.region.overlap_m = FiniteAt(json, "overlap_m");
  tile.region.max_range_m = FiniteAt(json, "max_range_m");
  const Eigen::Array2d size_m = tile.region.inside.max_m - tile.region.inside.min_m;
  if (!(size_m > 0).all() || !(tile.region.overlap_m >= 0) || !(tile.region.max_range_m > 0)) {
    throw DataError("the tile has no extent");
  }
  for (const TileJson& keyframe : json.at("keyframes")) {
    tile.keyframes.push_back(KeyframeFromJson(keyframe));
    const std::size_t count = tile.keyframes.size();
    if (count > 1 && tile.keyframes[count - 2].keyframe_idx >= tile.keyframes.back().keyframe_idx) {
      throw DataError("keyframe_idx must increase");
    }
  }
  return tile;
}

}  // namespace

std::string TileToJson(const Tile& tile) {
  const TileJson head = {{"format", kTileFormat},
                         {"version", kTileVersion},
                         {"units", "map_from_camera: tx ty tz (m) qx qy qz qw"},
                         {"min_x_m", tile.region.inside.min_m.x()},
                         {"min_y_m", tile.region.inside.min_m.y()},
                         {"max_x_m", tile.region.inside.max_m.x()},
                         {"max_y_m", tile.region.inside.max_m.y()},
                         {"overlap_m", tile.region.overlap_m},
                         {"max_range_m", tile.region.max_range_m}};
  std::string text = head.dump(1);
  text.erase(text.size() - 2);  // the closing brace and the line break before it
  text += ",\n \"keyframes\": [";
  for (const Keyframe& keyframe : tile.keyframes) {
    text += text.back() == '[' ? "\n  " : ",\n  ";
    try {
      text += KeyframeToJson(keyframe).dump();
    } catch (const TileJson::type_error&) {
      throw DataError("{}: the name is not UTF-8, rename it", keyframe.frame.color.path);
    }
  }
  return text + "\n ]\n}\n";
}

Tile ReadTile(const std::filesystem::path& path) {
  const std::string text = ReadFile(path);
  try {
    return TileFromJson(TileJson::parse(text));
  } catch (const std::exception& error) {
    throw DataError("{}: {}; delete the tiles folder of this site and run make",
                    path.string(),
                    JsonReason(error));
  }
}

}  // namespace nightmap
