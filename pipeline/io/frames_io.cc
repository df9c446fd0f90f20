// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frames_io.h"

#include <algorithm>
#include <set>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"

namespace nightmap {
namespace {

constexpr const char* kFramesHeader =
    "frame_idx,time_ns,camera_idx,sequence_idx,color_path,color_hash,depth_path,depth_hash";
constexpr std::size_t kFirstChannel = 4;  // column from which path and hash of each channel follow
constexpr std::string_view kPath = "_path";
constexpr std::string_view kHash = "_hash";

// The channels that a header names, from kFirstChannel on.
std::vector<std::string> ChannelsOfHeader(const CsvFile& csv) {
  const std::vector<std::string>& header = csv.Header();
  std::vector<std::string> names;
  for (std::size_t i = kFirstChannel; i < header.size(); i += 2) {
    const std::string name = header[i].substr(0, header[i].size() - kPath.size());
    const bool is_pair = header[i].ends_with(kPath) && i + 1 < header.size() &&
                         header[i + 1] == name + std::string(kHash);
    if (!is_pair || name.empty() || std::ranges::count(names, name) > 0) {
      csv.HeaderRow().Fail(
          fmt::format("column '{}': each channel has NAME_path and NAME_hash, once", header[i]));
    }
    names.push_back(name);
  }
  return names;
}

FrameRecord RecordFromRow(const CsvRow& row, const std::vector<std::string>& channels) {
  FrameRecord frame;
  frame.frame_idx = row.Index(0);
  frame.time_ns = row.Integer(1);
  frame.camera_idx = row.Index(2);
  frame.sequence_idx = row.Index(3);
  for (std::size_t i = 0; i < channels.size(); ++i) {
    const std::size_t column = kFirstChannel + 2 * i;
    if (row.IsEmpty(column) && row.IsEmpty(column + 1)) continue;
    ChannelOf(frame, channels[i]) = {row.Text(column), row.Text(column + 1)};
  }
  try {
    CheckChannels(frame);
  } catch (const DataError& error) {
    row.Fail(error.what());
  }
  return frame;
}

}  // namespace

std::vector<std::pair<std::string, const ChannelFile*>> ChannelsOf(const FrameRecord& frame) {
  std::vector<std::pair<std::string, const ChannelFile*>> channels = {{"color", &frame.color},
                                                                      {"depth", &frame.depth}};
  for (const auto& [name, file] : frame.others) channels.emplace_back(name, &file);
  return channels;
}

ChannelFile& ChannelOf(FrameRecord& frame, const std::string& name) {
  if (name == "color") return frame.color;
  if (name == "depth") return frame.depth;
  return frame.others[name];
}

void CheckChannels(const FrameRecord& frame) {
  if (frame.color.path.empty()) throw DataError("color_path is empty");
  for (const auto& [name, file] : ChannelsOf(frame)) {
    if (file->path.empty() == file->hash.empty()) continue;
    throw DataError("{}{} is empty", name, file->path.empty() ? kPath : kHash);
  }
}

std::string FramesToCsv(const std::vector<FrameRecord>& frames) {
  std::set<std::string> others;
  for (const FrameRecord& frame : frames) {
    for (const auto& [name, file] : frame.others) others.insert(name);
  }
  std::string text = kFramesHeader;
  for (const std::string& name : others) text += fmt::format(",{0}{1},{0}{2}", name, kPath, kHash);
  const auto add = [&](const ChannelFile& file) {
    text += fmt::format(",{},{}", CsvField(file.path), CsvField(file.hash));
  };
  for (const FrameRecord& frame : frames) {
    text += fmt::format(
        "\n{},{},{},{}", frame.frame_idx, frame.time_ns, frame.camera_idx, frame.sequence_idx);
    add(frame.color);
    add(frame.depth);
    for (const std::string& name : others) {
      const auto file = frame.others.find(name);
      add(file == frame.others.end() ? ChannelFile{} : file->second);
    }
  }
  return text + '\n';
}

std::vector<FrameRecord> ReadFrames(const std::filesystem::path& path) {
  const CsvFile csv(path, kFramesHeader, true);
  const auto channels = ChannelsOfHeader(csv);
  std::vector<FrameRecord> frames;
  for (const CsvRow& row : csv.Rows()) {
    frames.push_back(RecordFromRow(row, channels));
    if (frames.size() > 1 && frames.back().frame_idx - 1 != frames[frames.size() - 2].frame_idx) {
      row.Fail("frame_idx must count up by one");
    }
  }
  return frames;
}

std::vector<FrameRecord> ReadFrames(const std::vector<std::filesystem::path>& paths) {
  std::vector<FrameRecord> frames;
  std::set<std::string> pictures;  // later stages, like COLMAP, identify frames by them
  for (std::size_t i = 0; i < paths.size(); ++i) {
    const std::filesystem::path& path = paths[i];
    std::vector<FrameRecord> shard = ReadFrames(path);
    if (shard.empty()) {
      throw DataError("{}: lists no frame; delete the frames folder of this site and run make",
                      path.string());
    }
    for (FrameRecord& frame : shard) {
      if (!frames.empty() && frame.frame_idx - 1 != frames.back().frame_idx) {
        throw DataError(
            "{} starts with frame {}, but {}, the list before it, ends with frame {}; "
            "one is damaged, or they are not in order: delete both and run make again",
            path.string(),
            frame.frame_idx,
            paths[i - 1].string(),
            frames.back().frame_idx);
      }
      if (!pictures.insert(frame.color.path).second) {
        throw DataError(
            "{}: frame {} has the picture {} of another frame; delete the frames folder of this "
            "site and run make",
            path.string(),
            frame.frame_idx,
            frame.color.path);
      }
      frames.push_back(std::move(frame));
    }
  }
  return frames;
}

}  // namespace nightmap
