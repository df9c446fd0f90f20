// SPDX-License-Identifier: Apache-2.0
// Label pictures of the labelled frames of a shard, each with the confidence of its labels.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/image_io.h"

namespace nightmap {

// Meaning of a picture's labels.
struct LabelClasses {
  std::vector<std::string> names;    // by label; at most 255, none empty, of one line
  std::vector<std::uint8_t> moving;  // per class, 1: such things move by themselves

  bool operator==(const LabelClasses&) const = default;
};

// The text `classes` of a file. Throws DataError naming file and field on an empty name or too
// many.
void WriteClassNames(const std::vector<std::string>& names, Hdf5Writer* file);
std::vector<std::string> ReadClassNames(const Hdf5Reader& file);

// Labels of a picture's pixels. Both images have the picture's size.
struct Segmentation {
  LabelImage labels;      // index of the class
  GrayImage confidences;  // 255 times the probability of that class
};

// A labelled frame as the file holds it: both images compressed.
struct PackedLabels {
  int frame_idx = 0;
  std::int64_t time_ns = 0;
  int width = 0;
  int height = 0;
  std::vector<std::uint8_t> labels;
  std::vector<std::uint8_t> confidences;
};

// Compresses the images of a frame, without loss. Equal images give equal bytes.
PackedLabels PackLabels(int frame_idx, std::int64_t time_ns, const Segmentation& segmentation);
// Hash of what they hold and of the names of the classes, which readers take along with them, for
// the lists of frames.
std::string HashOf(const PackedLabels& packed, const std::vector<std::string>& classes);

struct LabelsShard {
  LabelClasses classes;
  std::vector<PackedLabels> frames;  // in order of frame_idx and of time
};

void WriteLabels(const std::filesystem::path& path,
                 const LabelsShard& shard,
                 const std::string& config);

// Reads the list of the frames at once, and the images of a frame when asked for. Not thread-safe,
// as all readers of HDF5 files.
class LabelsReader {
 public:
  // Throws DataError naming file and field on another format, a newer version, a missing array or
  // sizes and indices that do not fit.
  explicit LabelsReader(const std::filesystem::path& path);

  const LabelClasses& Classes() const { return classes_; }
  // In order of frame_idx and of time, without their images.
  const std::vector<PackedLabels>& Frames() const { return frames_; }
  // Throws DataError naming file and field when no frame has that time, or when its images are
  // damaged or have a label of no class.
  PackedLabels ReadPacked(std::int64_t time_ns) const;
  Segmentation Read(std::int64_t time_ns) const;
  // The second half of Read, for several threads at once.
  Segmentation Unpack(const PackedLabels& packed) const;

 private:
  Hdf5Reader file_;
  LabelClasses classes_;
  std::vector<PackedLabels> frames_;
};

}  // namespace nightmap
