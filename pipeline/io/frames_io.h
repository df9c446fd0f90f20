// SPDX-License-Identifier: Apache-2.0
// What the frames stage writes and every later stage reads: the list of frames (CSV), the cameras
// (JSON), and one frame's pixels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/depth_noise.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

// One file of a frame. The path is relative to the data root (Make's DATA folder), so that an
// artifact holds no path of the machine it was made on; the hash of the file's bytes stands for its
// pixels wherever the list is read. No path: the frame lacks this channel.
struct ChannelFile {
  std::string path;
  std::string hash;
};

// One frame: the pictures of one moment, a channel each.
struct FrameRecord {
  int frame_idx = 0;         // contiguous over all sequences of the site, mapping frames only
  std::int64_t time_ns = 0;  // unique over the site; the key of every trajectory file
  int camera_idx = 0;        // into the list of cameras.json; of a query: query_cameras.json
  int sequence_idx = 0;
  ChannelFile color;                          // always there
  ChannelFile depth;                          // lists of an RGB-D map demand it, queries do not
  std::map<std::string, ChannelFile> others;  // by channel, such as "label"; those that it has
};

// Name and file of each channel: color, depth, then the others by name.
std::vector<std::pair<std::string, const ChannelFile*>> ChannelsOf(const FrameRecord& frame);
// The file of the channel of that name, added among `others` when it is there neither.
ChannelFile& ChannelOf(FrameRecord& frame, const std::string& name);
// Throws DataError when a channel has a path and no hash, or the reverse, or color has none.
void CheckChannels(const FrameRecord& frame);

// One RGB-D camera: the color camera, and how its depth images are to be read.
struct RgbdCamera {
  std::string camera_id;     // as named in the site config
  Rigid3 robot_from_camera;  // pose of the color camera on the robot; identity: the same axes
  Camera color;
  bool depth_registered = true;     // depth pixels are color pixels
  Camera depth;                     // used when not registered
  Rigid3 color_from_depth;          // used when not registered
  double depth_units_per_m = 1000;  // raw 16-bit units in one metre
  double min_depth_m = 0.1;
  double max_depth_m = 10.0;
  DepthNoise noise;
};

// Pixels of one frame.
struct RgbdImages {
  ColorImage color;
  DepthImage depth;  // metres at the color camera's pixels
};

// CSV with header frame_idx,time_ns,camera_idx,sequence_idx,color_path,color_hash,depth_path,
// depth_hash and, for each further channel that a frame of the list has, NAME_path,NAME_hash. So a
// new channel needs no new reader, and changes no list without it. Readers throw DataError naming
// file and line.
std::string FramesToCsv(const std::vector<FrameRecord>& frames);
std::vector<FrameRecord> ReadFrames(const std::filesystem::path& path);
// Several shards, concatenated; none may be empty, frame_idx is contiguous, a picture is one frame.
std::vector<FrameRecord> ReadFrames(const std::vector<std::filesystem::path>& paths);

std::string CamerasToJson(const std::vector<RgbdCamera>& cameras);
std::vector<RgbdCamera> ReadCameras(const std::filesystem::path& path);
// The same for those who look up the cameras of frames: every camera_idx is checked.
std::vector<RgbdCamera> ReadCameras(const std::filesystem::path& path,
                                    const std::vector<FrameRecord>& frames);
// Throws DataError when the frame's camera is not in the list; `list` is its name for the message.
void CheckCamera(const FrameRecord& frame,
                 const std::vector<RgbdCamera>& cameras,
                 const std::string& list);

// `depth` of the depth camera as seen from the color camera: every measured pixel is moved by the
// extrinsics and drawn as a rectangle as large as it appears in the color image (at least one
// pixel), so that a finer color image gets no pinholes; where several fall on a pixel the nearest
// wins. Color pixels that no measurement reaches stay 0. Deterministic.
DepthImage RegisterDepth(const DepthImage& depth, const RgbdCamera& camera);

// Color image of a frame, checked to have the camera's size. Throws DataError naming the file.
ColorImage LoadColor(const FrameRecord& frame,
                     const RgbdCamera& camera,
                     const std::filesystem::path& data_root);
// Depth of a frame in metres at the pixels of the color camera (registered here from the extrinsics
// when the recording is not), 0 where nothing was measured or the measurement is outside
// [min_depth_m, max_depth_m]. Raw 0 and 65535 mean no measurement. Throws DataError naming the file
// when it cannot be read, has another size than its camera, or the frame has no depth.
DepthImage LoadDepth(const FrameRecord& frame,
                     const RgbdCamera& camera,
                     const std::filesystem::path& data_root);
// Both.
RgbdImages LoadRgbd(const FrameRecord& frame,
                    const RgbdCamera& camera,
                    const std::filesystem::path& data_root);

}  // namespace nightmap
