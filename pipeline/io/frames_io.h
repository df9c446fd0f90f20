// SPDX-License-Identifier: Apache-2.0
// Output of the frames stage, input of every later one: the list of frames (CSV), the cameras
// (JSON), and one frame's pixels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/depth_noise.h"
#include "pipeline/geometry/rigid3.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

// One file of a frame. The path is relative to the data root (Make's DATA folder), so that an
// artifact does not depend on the machine that made it. The hash of the file's bytes represents its
// pixels wherever the list is read. An empty path means that the frame lacks this channel.
struct ChannelFile {
  std::string path;
  std::string hash;
};

// The channel of label pictures that a recording brings.
constexpr const char* kLabelChannel = "label";
// The channel of the truth of what moves: not 0 where it does. Only evaluation reads it.
constexpr const char* kMovingChannel = "moving";
// The channel that says how sure the depth is (LoadDepth).
constexpr const char* kConfidenceChannel = "confidence";

// One frame: the pictures of one moment, one per channel.
struct FrameRecord {
  int frame_idx = 0;         // contiguous over all sequences of the site; mapping frames only
  std::int64_t time_ns = 0;  // unique over the site; the key of every trajectory file
  int camera_idx = 0;        // index in cameras.json; for a query in query_cameras.json
  int sequence_idx = 0;
  ChannelFile color;                          // always present
  ChannelFile depth;                          // empty for queries and where the site has none
  std::map<std::string, ChannelFile> others;  // present channels by name, such as "label"
};

// Name and file of each channel: color, depth, then the others by name.
std::vector<std::pair<std::string, const ChannelFile*>> ChannelsOf(const FrameRecord& frame);
// The file of the channel of that name, added to `others` if it is missing.
ChannelFile& ChannelOf(FrameRecord& frame, const std::string& name);
// Throws DataError when a channel has a path without a hash, or the reverse, or when color has
// neither.
void CheckChannels(const FrameRecord& frame);

// One RGB-D camera: the color camera, and how to read its depth images.
struct RgbdCamera {
  std::string camera_id;     // as named in the site config
  Rigid3 robot_from_camera;  // pose of the color camera on the robot; identity: the same axes
  Camera color;              // at the size at which stages see its pictures
  // Size of its pictures as stored, which LoadColor and LoadDepth shrink; 0: that of `color`.
  int picture_width = 0;
  int picture_height = 0;
  int picture_bits = 16;            // in use of color pictures that have 16 bits
  bool depth_registered = true;     // depth pixels are color pixels
  Camera depth;                     // used when not registered
  Rigid3 color_from_depth;          // used when not registered
  double depth_units_per_m = 1000;  // raw units per metre; 0: depth is of floats in metres
  bool depth_along_ray = false;     // raw depth is the distance from the camera, not z
  double depth_offset_m = 0;        // what raw depth, of z or along the ray, is too far
  double min_depth_m = 0.1;
  double max_depth_m = 10.0;  // bounds the map; `features` reads farther depth too
  // Depth is not measured where the picture of its confidence is lower; 0: none is asked.
  int min_confidence = 0;
  DepthNoise noise;
  // How sure the focal length of `color` is: standard deviation of its logarithm; 0: calibrated.
  double focal_sigma_ratio = 0;
  // Where every picture shows the robot itself, not the world: 255, elsewhere 0. As large as
  // `color`; null: nowhere.
  std::shared_ptr<const GrayImage> mask;

  // Picture is the camera of the color pictures as stored, DepthPicture that of the depth pictures.
  Camera Picture() const;
  Camera DepthPicture() const { return depth_registered ? Picture() : depth; }
  bool IsCalibrated() const { return focal_sigma_ratio == 0; }
};

// Pixels of one frame.
struct RgbdImages {
  ColorImage color;
  DepthImage depth;  // metres at the color camera's pixels; no pixels when the frame has no depth
  // The camera's mask and the things that move by themselves (MaskOut in frame_reader.h), which
  // color and depth no longer show; empty: nothing is known.
  GrayImage moving = {};
};

// Gives a stage the pixels of a frame. Throws when they cannot be read; any exception that
// FrameFailure catches (frame_failure.h) fails this frame only.
using RgbdLoader = std::function<RgbdImages(const FrameRecord&)>;

// CSV with header frame_idx,time_ns,camera_idx,sequence_idx,color_path,color_hash,depth_path,
// depth_hash and, for each further channel of any frame in the list, NAME_path,NAME_hash. So a new
// channel needs no new reader and does not change lists without it. Readers throw DataError naming
// file and line.
std::string FramesToCsv(const std::vector<FrameRecord>& frames);
std::vector<FrameRecord> ReadFrames(const std::filesystem::path& path);
// Concatenates several shards. None may be empty, frame_idx must be contiguous, and no picture may
// occur in two frames.
std::vector<FrameRecord> ReadFrames(const std::vector<std::filesystem::path>& paths);

// Version 1; 2 where a camera has a focal_sigma_ratio, 3 where one has a mask or depth_along_ray, 4
// where one has picture_bits below 16, min_confidence or a depth_offset_m, 5
// where pictures are stored larger than stages see them.
std::string CamerasToJson(const std::vector<RgbdCamera>& cameras);
std::vector<RgbdCamera> ReadCameras(const std::filesystem::path& path);
// Likewise for lookups of frames' cameras: checks every camera_idx.
std::vector<RgbdCamera> ReadCameras(const std::filesystem::path& path,
                                    const std::vector<FrameRecord>& frames);
// Throws DataError when the frame's camera is not in the list; `list` names the list in the
// message.
void CheckCamera(const FrameRecord& frame,
                 const std::vector<RgbdCamera>& cameras,
                 const std::string& list);

// `depth` of the depth camera as seen from the color camera. Moves every measured pixel by the
// extrinsics and draws it as a rectangle of its size in the color image (at least one pixel), so
// that a finer color image gets no pinholes. Where several fall on a pixel the nearest wins. Color
// pixels without a measurement stay 0. Deterministic.
DepthImage RegisterDepth(const DepthImage& depth, const RgbdCamera& camera);

// Stages see larger pictures at this size by default: more pixels cost time and memory, and made no
// better map.
constexpr double kWorking_mpx = 1.0;
// Gives a camera of more than `working_mpx` million pixels a `color` of so many, of the same lens.
void ReduceToWorkingSize(double working_mpx, RgbdCamera* camera);

// Color image of a frame, checked to have the size of the camera's pictures, at that of its
// `color`: the mean of the pixels that each covers. Pixels of the camera's mask are faded out
// (masked_pixels.h). Throws DataError naming the file.
ColorImage LoadColor(const FrameRecord& frame,
                     const RgbdCamera& camera,
                     const std::filesystem::path& data_root);
// Depth of a frame in metres at the pixels of the color camera: of a larger picture, every so many
// pixels; registered here from the extrinsics
// if the recording is not. 0 where nothing was measured or the measurement is outside [min_depth_m,
// max_depth_m], and where the camera's mask is. Raw 0 and 65535, and floats that
// are not positive numbers, mean no measurement, and so does a confidence below the camera's
// min_confidence. A picture of confidence has the size of depth, or a whole fraction of it. Throws
// DataError naming the file when it cannot be read, its size differs from its camera's, or the
// frame has no depth.
DepthImage LoadDepth(const FrameRecord& frame,
                     const RgbdCamera& camera,
                     const std::filesystem::path& data_root);
// Color, and depth where the frame has it; `moving` is the camera's mask.
RgbdImages LoadRgbd(const FrameRecord& frame,
                    const RgbdCamera& camera,
                    const std::filesystem::path& data_root);

}  // namespace nightmap
