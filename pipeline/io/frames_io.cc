// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frames_io.h"

#include <set>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"

namespace nightmap {
namespace {

constexpr const char* kFramesHeader =
    "frame_idx,time_ns,color_path,depth_path,camera_idx,sequence_idx,content_hash";

FrameRecord RecordFromRow(const CsvRow& row) {
  FrameRecord frame;
  frame.frame_idx = row.Index(0);
  frame.time_ns = row.Integer(1);
  frame.color_path = row.Text(2);
  frame.depth_path = row.Text(3);
  frame.camera_idx = row.Index(4);
  frame.sequence_idx = row.Index(5);
  frame.content_hash = row.Text(6);
  if (frame.color_path.empty()) row.Fail("color_path is empty");
  if (frame.content_hash.empty()) row.Fail("content_hash is empty");
  return frame;
}

}  // namespace

std::string FramesToCsv(const std::vector<FrameRecord>& frames) {
  std::string text = std::string(kFramesHeader) + '\n';
  for (const FrameRecord& frame : frames) {
    text += fmt::format("{},{},{},{},{},{},{}\n",
                        frame.frame_idx,
                        frame.time_ns,
                        CsvField(frame.color_path),
                        CsvField(frame.depth_path),
                        frame.camera_idx,
                        frame.sequence_idx,
                        frame.content_hash);
  }
  return text;
}

std::vector<FrameRecord> ReadFrames(const std::filesystem::path& path) {
  const CsvFile csv(path, kFramesHeader);
  std::vector<FrameRecord> frames;
  for (const CsvRow& row : csv.Rows()) {
    frames.push_back(RecordFromRow(row));
    if (frames.size() > 1 && frames.back().frame_idx - 1 != frames[frames.size() - 2].frame_idx) {
      row.Fail("frame_idx must count up by one");
    }
  }
  return frames;
}

std::vector<FrameRecord> ReadFrames(const std::vector<std::filesystem::path>& paths) {
  std::vector<FrameRecord> frames;
  std::set<std::string> pictures;  // later stages tell frames apart by them, as COLMAP does
  for (const auto& path : paths) {
    std::vector<FrameRecord> shard = ReadFrames(path);
    if (shard.empty()) {
      throw DataError("{}: lists no frame; delete the frames folder of this site and run make",
                      path.string());
    }
    for (FrameRecord& frame : shard) {
      if (!frames.empty() && frame.frame_idx - 1 != frames.back().frame_idx) {
        throw DataError("{}: starts with frame {} after frame {}: give all shards in order",
                        path.string(),
                        frame.frame_idx,
                        frames.back().frame_idx);
      }
      if (!pictures.insert(frame.color_path).second) {
        throw DataError(
            "{}: frame {} has the picture {} of another frame; delete the frames folder of this "
            "site and run make",
            path.string(),
            frame.frame_idx,
            frame.color_path);
      }
      frames.push_back(std::move(frame));
    }
  }
  return frames;
}

}  // namespace nightmap
