// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frame_reader.h"

#include <map>
#include <mutex>
#include <utility>

#include "pipeline/base/input_error.h"
#include "pipeline/io/masked_pixels.h"
#include "pipeline/io/masks_io.h"

namespace nightmap {

void MaskOut(GrayImage moving, RgbdImages* images) {
  FadeOut(moving, &images->color);
  if (!images->depth.pixels.empty()) RemoveDepth(moving, &images->depth);
  // Pixels that the camera's mask took out already stay out.
  for (std::size_t i = 0; i < images->moving.pixels.size(); ++i) {
    moving.pixels[i] |= images->moving.pixels[i];
  }
  images->moving = std::move(moving);
}

using MasksByTime = std::map<std::int64_t, PackedMask>;

// Readers of HDF5 files take turns.
struct FrameReader::MaskFiles {
  std::map<std::string, std::filesystem::path> paths;  // by file name
  std::map<std::string, MasksByTime> read;
  std::mutex mutex;

  const PackedMask& Of(const std::string& name, const FrameRecord& frame) {
    const std::lock_guard lock(mutex);
    const MasksByTime& masks = In(name, frame);
    const auto mask = masks.find(frame.time_ns);
    if (mask != masks.end()) return mask->second;
    throw ArtifactError("{}: has no mask of frame {}; make the masks again",
                        paths.at(name).string(),
                        frame.color.path);
  }

 private:
  const MasksByTime& In(const std::string& name, const FrameRecord& frame) {
    const auto known = read.find(name);
    if (known != read.end()) return known->second;
    const auto path = paths.find(name);
    if (path == paths.end()) {
      throw ArtifactError("{}: its mask is in {}, which is not among the files of masks given",
                          frame.color.path,
                          name);
    }
    MasksByTime masks;
    for (PackedMask& mask : ReadMasks(path->second)) masks.emplace(mask.time_ns, std::move(mask));
    return read.emplace(name, std::move(masks)).first->second;
  }
};

FrameReader::FrameReader(std::filesystem::path data_root,
                         const std::vector<std::filesystem::path>& mask_files)
    : data_root_(std::move(data_root)), masks_(std::make_shared<MaskFiles>()) {
  for (const auto& path : mask_files) masks_->paths[path.filename().string()] = path;
}

bool FrameReader::MayUse(const FrameRecord& frame) const {
  return masks_->paths.empty() || frame.others.contains(kMaskChannel);
}

GrayImage FrameReader::Mask(const FrameRecord& frame, const RgbdCamera& camera) const {
  const auto channel = frame.others.find(kMaskChannel);
  if (masks_->paths.empty() || channel == frame.others.end()) return {};
  const PackedMask& mask = masks_->Of(channel->second.path, frame);
  const Camera& picture = camera.color;
  if (mask.width == picture.width && mask.height == picture.height) return UnpackMask(mask);
  throw ArtifactError(
      "{}: the mask of {} is {} x {} pixels and its picture {} x {}; make the masks again",
      masks_->paths.at(channel->second.path).string(),
      frame.color.path,
      mask.width,
      mask.height,
      picture.width,
      picture.height);
}

ColorImage FrameReader::Color(const FrameRecord& frame, const RgbdCamera& camera) const {
  ColorImage color = LoadColor(frame, camera, data_root_);
  const GrayImage mask = Mask(frame, camera);
  if (!mask.pixels.empty()) FadeOut(mask, &color);
  return color;
}

DepthImage FrameReader::Depth(const FrameRecord& frame, const RgbdCamera& camera) const {
  DepthImage depth = LoadDepth(frame, camera, data_root_);
  const GrayImage mask = Mask(frame, camera);
  if (!mask.pixels.empty()) RemoveDepth(mask, &depth);
  return depth;
}

RgbdImages FrameReader::Rgbd(const FrameRecord& frame, const RgbdCamera& camera) const {
  RgbdImages images = LoadRgbd(frame, camera, data_root_);
  GrayImage moving = Mask(frame, camera);
  if (!moving.pixels.empty()) MaskOut(std::move(moving), &images);
  return images;
}

}  // namespace nightmap
