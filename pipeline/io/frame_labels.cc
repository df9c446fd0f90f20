// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frame_labels.h"

#include <map>
#include <mutex>

#include "pipeline/base/input_error.h"

namespace nightmap {

// Keeps few files open, since a night has many and a process may have few.
struct FrameLabels::Files {
  static constexpr std::size_t kMaxOpen = 8;

  std::map<std::string, std::filesystem::path> paths;  // by file name
  std::map<std::string, std::shared_ptr<const LabelsReader>> open;
  std::vector<std::string> classes;
  std::mutex mutex;

  std::shared_ptr<const LabelsReader> Of(const std::string& name, const FrameRecord& frame) {
    const auto known = open.find(name);
    if (known != open.end()) return known->second;
    const auto path = paths.find(name);
    if (path == paths.end()) {
      throw ArtifactError("{}: its labels are in {}, which is not among the files of labels given",
                          frame.color.path,
                          name);
    }
    if (open.size() >= kMaxOpen) open.clear();
    const auto reader = std::make_shared<const LabelsReader>(path->second);
    if (reader->Classes().names != classes) {
      throw ArtifactError(
          "{}: has other classes than the first file of labels; make the labels again",
          path->second.string());
    }
    return open[name] = reader;
  }
};

FrameLabels::FrameLabels(const std::vector<std::filesystem::path>& files)
    : files_(std::make_shared<Files>()) {
  for (const auto& path : files) files_->paths[path.filename().string()] = path;
  files_->classes = LabelsReader(files.front()).Classes().names;
}

const std::vector<std::string>& FrameLabels::Classes() const { return files_->classes; }

Segmentation FrameLabels::Of(const FrameRecord& frame, const Camera& picture) const {
  const auto channel = frame.others.find(kLabelsChannel);
  if (channel == frame.others.end()) throw ArtifactError("{}: has no labels", frame.color.path);
  std::shared_ptr<const LabelsReader> reader;
  PackedLabels packed;
  {
    const std::lock_guard lock(files_->mutex);
    reader = files_->Of(channel->second.path, frame);
    packed = reader->ReadPacked(frame.time_ns);
  }
  if (packed.width != picture.width || packed.height != picture.height) {
    throw ArtifactError(
        "{}: the labels of {} are {} x {} pixels and its picture {} x {}; make the labels again",
        files_->paths.at(channel->second.path).string(),
        frame.color.path,
        packed.width,
        packed.height,
        picture.width,
        picture.height);
  }
  return reader->Unpack(packed);
}

}  // namespace nightmap
