// SPDX-License-Identifier: Apache-2.0
// Arrays of labels/shard_NNNN.h5 (F labelled frames, C classes):
//   text classes (a name per line); moving C;
//   frame_idx F; time_ns F; size_px F x 2 (width, height);
//   labels/T, confidences/T: the images of the frame with time_ns T, row by row, as zlib streams.
#include "pipeline/io/labels_io.h"

#include <fmt/ranges.h>
#include <zlib.h>

#include <algorithm>
#include <optional>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kLabelsFormat[] = "nightmap labels";
constexpr int kLabelsVersion = 2;
constexpr std::size_t kMaxClasses = 255;
constexpr std::int32_t kMaxLabelsSize_px = 1 << 15;
constexpr int kCompression = 4;
// zlib's streams unpack to at most this many times their size: a larger image is damage, for which
// no memory is taken.
constexpr std::size_t kMaxRatio = 1032;

std::string LabelsField(std::int64_t time_ns) { return fmt::format("labels/{}", time_ns); }
std::string ConfidencesField(std::int64_t time_ns) {
  return fmt::format("confidences/{}", time_ns);
}

std::vector<std::uint8_t> PackImage(const GrayImage& image) {
  uLongf size = compressBound(image.pixels.size());
  std::vector<std::uint8_t> packed(size);
  if (compress2(packed.data(), &size, image.pixels.data(), image.pixels.size(), kCompression) !=
      Z_OK) {
    throw DataError("an image of {} x {} cannot be compressed", image.width, image.height);
  }
  packed.resize(size);
  return packed;
}

// None when the bytes are damaged.
std::optional<GrayImage> UnpackImage(const std::vector<std::uint8_t>& packed,
                                     int width,
                                     int height) {
  GrayImage image{width, height, 1, {}};
  const std::size_t num_pixels = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  if (num_pixels / kMaxRatio > packed.size()) return std::nullopt;
  image.pixels.resize(num_pixels);
  uLongf size = num_pixels;
  const int status = uncompress(image.pixels.data(), &size, packed.data(), packed.size());
  if (status != Z_OK || size != num_pixels) return std::nullopt;
  return image;
}

std::vector<std::string> NamesOf(const std::string& text) {
  std::vector<std::string> lines;
  if (text.empty()) return lines;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    lines.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return lines;
}

LabelClasses ReadClasses(const Hdf5Reader& file) {
  LabelClasses classes;
  classes.names = ReadClassNames(file);
  classes.moving = file.ReadList<std::uint8_t>("moving");
  const auto is_flag = [](std::uint8_t value) { return value <= 1; };
  file.Demand(
      classes.moving.size() == classes.names.size() && std::ranges::all_of(classes.moving, is_flag),
      "moving");
  return classes;
}

constexpr auto kLabelledFrames = Hdf5Table<PackedLabels>(
    Hdf5Column("frame_idx", &PackedLabels::frame_idx)
        .Elements(kNotNegative)
        .Pairs(Ascending(&PackedLabels::frame_idx)),
    Hdf5Column("time_ns", &PackedLabels::time_ns).Pairs(Ascending(&PackedLabels::time_ns)),
    Hdf5Column("size_px", &PackedLabels::width, &PackedLabels::height).Elements([](int size_px) {
      return size_px > 0 && size_px <= kMaxLabelsSize_px;
    }));

}  // namespace

void WriteClassNames(const std::vector<std::string>& names, Hdf5Writer* file) {
  file->WriteText("classes", fmt::format("{}", fmt::join(names, "\n")));
}

std::vector<std::string> ReadClassNames(const Hdf5Reader& file) {
  std::vector<std::string> names = NamesOf(file.ReadText("classes"));
  const auto is_empty = [](const std::string& name) { return name.empty(); };
  file.Demand(names.size() <= kMaxClasses && std::ranges::none_of(names, is_empty), "classes");
  return names;
}

PackedLabels PackLabels(int frame_idx, std::int64_t time_ns, const Segmentation& segmentation) {
  return {frame_idx,
          time_ns,
          segmentation.labels.width,
          segmentation.labels.height,
          PackImage(segmentation.labels),
          PackImage(segmentation.confidences)};
}

std::string HashOf(const PackedLabels& packed, const std::vector<std::string>& classes) {
  std::string bytes = fmt::format("{}\n{} {} {} {} ",
                                  fmt::join(classes, "\n"),
                                  classes.size(),
                                  packed.width,
                                  packed.height,
                                  packed.labels.size());
  bytes.append(packed.labels.begin(), packed.labels.end());
  bytes.append(packed.confidences.begin(), packed.confidences.end());
  return HashBytes(bytes);
}

void WriteLabels(const std::filesystem::path& path,
                 const LabelsShard& shard,
                 const std::string& config) {
  Hdf5Writer file(path,
                  kLabelsFormat,
                  kLabelsVersion,
                  config,
                  "pixels of the color image; confidences 255 times the probability");
  WriteClassNames(shard.classes.names, &file);
  file.WriteList("moving", shard.classes.moving);
  kLabelledFrames.Write(shard.frames, &file);
  for (const PackedLabels& frame : shard.frames) {
    file.WriteList(LabelsField(frame.time_ns), frame.labels);
    file.WriteList(ConfidencesField(frame.time_ns), frame.confidences);
  }
  file.Close();
}

LabelsReader::LabelsReader(const std::filesystem::path& path)
    : file_(path, kLabelsFormat, kLabelsVersion),
      classes_(ReadClasses(file_)),
      frames_(kLabelledFrames.Read(file_)) {}

PackedLabels LabelsReader::ReadPacked(std::int64_t time_ns) const {
  const auto found = std::ranges::lower_bound(frames_, time_ns, {}, &PackedLabels::time_ns);
  file_.Demand(found != frames_.end() && found->time_ns == time_ns,
               "time_ns",
               fmt::format("does not hold {}", time_ns));
  PackedLabels packed = *found;
  packed.labels = file_.ReadList<std::uint8_t>(LabelsField(time_ns));
  packed.confidences = file_.ReadList<std::uint8_t>(ConfidencesField(time_ns));
  return packed;
}

Segmentation LabelsReader::Read(std::int64_t time_ns) const { return Unpack(ReadPacked(time_ns)); }

Segmentation LabelsReader::Unpack(const PackedLabels& packed) const {
  const std::string field = LabelsField(packed.time_ns);
  auto labels = UnpackImage(packed.labels, packed.width, packed.height);
  auto confidences = UnpackImage(packed.confidences, packed.width, packed.height);
  file_.Demand(labels.has_value(), field, "is damaged or has fewer pixels than size_px");
  file_.Demand(confidences.has_value(),
               ConfidencesField(packed.time_ns),
               "is damaged or has fewer pixels than size_px");
  file_.Demand(
      std::ranges::max(labels->pixels) < classes_.names.size(), field, "has a label of no class");
  return {*std::move(labels), *std::move(confidences)};
}

}  // namespace nightmap
