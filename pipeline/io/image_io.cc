// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/image_io.h"

#include <algorithm>
#include <fstream>
#include <memory>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/memory.h"
#include "pipeline/io/camera_images.h"
#include "pipeline/io/media.h"
#include "pipeline/io/picture_file.h"
#include "pipeline/io/picture_format.h"
#include "pipeline/io/pixel_values.h"

namespace nightmap {
namespace {

using namespace std::string_view_literals;

constexpr std::streamoff kTailSize = 4096;  // bytes after the end mark that are tolerated
constexpr float kSaturatedDepth = 65535;    // 7-Scenes: no measurement
constexpr std::uintmax_t kMaxFile_bytes = std::uintmax_t{1} << 30;  // of what is read whole

std::string Tail(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary | std::ios::ate);
  const std::streamoff size = file.tellg();
  std::string tail(static_cast<std::size_t>(std::clamp(size, std::streamoff{0}, kTailSize)), '\0');
  file.seekg(-static_cast<std::streamoff>(tail.size()), std::ios::end);
  file.read(tail.data(), static_cast<std::streamsize>(tail.size()));
  return tail;
}

// Decoders fill the missing part of a truncated file with gray and report success.
void CheckEndMark(const std::filesystem::path& path, std::string_view format) {
  std::string_view end_mark;
  if (format == "png") end_mark = "IEND\xAE\x42\x60\x82"sv;
  if (format == "jpeg") end_mark = "\xFF\xD9"sv;
  if (end_mark.empty() || Tail(path).find(end_mark) != std::string::npos) return;
  throw DataError("{}: truncated {} file: copy it again", path.string(), format);
}

// A PNG, JPEG or PGM of an unusual kind is left to the module, like all other pictures.
std::unique_ptr<PictureFile> OpenAs(std::string_view format,
                                    PngValues values,
                                    const std::filesystem::path& path) {
  std::error_code ignored;
  if (std::filesystem::file_size(path, ignored) <= kMaxFile_bytes) {
    std::unique_ptr<PictureFile> file;
    if (format == "png") file = OpenPng(ReadFile(path), values);
    if (format == "jpeg") file = OpenJpeg(ReadFile(path));
    if (format == "pnm") file = OpenPgm(path, ReadFile(path));
    if (file) return file;
    if (format == "heif") CheckHeifSizes(path, ReadFile(path));
  }
  return LoadedMedia().OpenPicture(path, format);
}

std::unique_ptr<PictureFile> Open(const std::filesystem::path& path,
                                  PngValues values = PngValues::kColors) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {  // opening a pipe would block
    const bool is_there = std::filesystem::exists(path, ignored);
    throw DataError("{}: {}", path.string(), is_there ? "not a file" : "no such image file");
  }
  auto file = OpenAs(FormatOfFile(path), values, path);
  CheckPictureSize(path, file->info.width, file->info.height, file->info.num_channels);
  CheckEndMark(path, file->format);
  return file;
}

// Other formats' readers scale values of few bits to 8 bits.
std::unique_ptr<PictureFile> OpenLabels(const std::filesystem::path& path) {
  auto file = Open(path, PngValues::kIndices);
  if (file->format == "png") return file;
  throw DataError(
      "{}: labels must be PNG files, this is of format {}", path.string(), file->format);
}

template <typename T>
Image<T> Blank(const ImageInfo& info) {
  Image<T> image{info.width, info.height, info.num_channels, {}};
  image.pixels.resize(static_cast<std::size_t>(info.width) * static_cast<std::size_t>(info.height) *
                      static_cast<std::size_t>(info.num_channels));
  return image;
}

template <typename T>
Image<T> Decode(PictureFile& file, const std::filesystem::path& path) {
  const ImageInfo& info = file.info;
  auto image = Blank<T>(info);
  if (file.Read(image.pixels.data())) return image;
  const auto other = LoadedMedia().OpenPicture(path, file.format);  // or says what is wrong
  if (other->info.width != info.width || other->info.height != info.height ||
      other->info.num_channels != info.num_channels) {
    throw DataError("{}: changed while it was read", path.string());
  }
  other->Read(image.pixels.data());
  return image;
}

void CheckSize(int width, int height, const Camera& camera, const std::filesystem::path& path) {
  if (width == camera.width && height == camera.height) return;
  throw DataError(
      "{}: {} x {} pixels, its camera has {} x {}: correct the camera in the site config",
      path.string(),
      width,
      height,
      camera.width,
      camera.height);
}

void CheckIsDepth(const PictureFile& file, const std::filesystem::path& path) {
  if (file.info.num_channels == 1 && (file.type == "uint16" || file.info.is_float)) return;
  throw DataError("{}: depth must be one channel of 16 bits or of floats, this has {} of {}",
                  path.string(),
                  file.info.num_channels,
                  file.type);
}

template <typename T>
void WritePngOf(const std::filesystem::path& path, const Image<T>& image) {
  const MemoryWatch memory;
  const std::string bytes = EncodePng(image);
  if (!bytes.empty()) return WriteFile(path, bytes);
  memory.Check(path.string());
  throw DataError("{}: a PNG cannot hold {} x {} pixels of {} channels",
                  path.string(),
                  image.width,
                  image.height,
                  image.num_channels);
}

}  // namespace

ColorImage ReadColorImage(const std::filesystem::path& path) {
  if (const auto frame = SplitVideoFramePath(path)) {
    return LoadedMedia().ReadVideoFrame(frame->first, frame->second);
  }
  const auto file = Open(path);
  return ToRgb(Decode<std::uint8_t>(*file, path));
}

GrayImage ToGray(const ColorImage& image) {
  GrayImage gray{image.width, image.height, 1, {}};
  gray.pixels.resize(image.pixels.size() / 3);
  for (std::size_t i = 0; i < gray.pixels.size(); ++i) {
    const std::uint8_t* rgb = &image.pixels[3 * i];
    // ITU-R BT.601 luma in 16-bit fixed point.
    const std::uint32_t luma = 19595u * rgb[0] + 38470u * rgb[1] + 7471u * rgb[2];
    gray.pixels[i] = static_cast<std::uint8_t>((luma + 32768u) >> 16);
  }
  return gray;
}

Image<std::uint16_t> ReadChannels(const std::filesystem::path& path) {
  const auto file = Open(path);
  if (file->type == "uint16") return Decode<std::uint16_t>(*file, path);
  const auto bytes = Decode<std::uint8_t>(*file, path);
  Image<std::uint16_t> image{bytes.width, bytes.height, bytes.num_channels, {}};
  image.pixels.reserve(bytes.pixels.size());
  for (const std::uint8_t value : bytes.pixels) {
    image.pixels.push_back(static_cast<std::uint16_t>(257 * value));
  }
  return image;
}

RawDepthImage ReadRawDepth(const std::filesystem::path& path) {
  const auto file = Open(path);
  CheckIsDepth(*file, path);
  return Decode<std::uint16_t>(*file, path);
}

ColorImage ReadColorOf(const Camera& camera, const std::filesystem::path& path, int num_bits) {
  if (const auto frame = SplitVideoFramePath(path)) {
    ColorImage image = LoadedMedia().ReadVideoFrame(frame->first, frame->second);
    CheckSize(image.width, image.height, camera, path);
    return image;
  }
  const auto file = Open(path);
  CheckSize(file->info.width, file->info.height, camera, path);
  if (num_bits < 16 && file->type == "uint16") {
    return ToRgb(ToBytes(Decode<std::uint16_t>(*file, path), num_bits, path));
  }
  return ToRgb(Decode<std::uint8_t>(*file, path));
}

Image<float> ReadRawDepthOf(const Camera& camera, const std::filesystem::path& path) {
  const auto file = Open(path);
  CheckIsDepth(*file, path);
  CheckSize(file->info.width, file->info.height, camera, path);
  if (file->info.is_float) return Decode<float>(*file, path);
  const auto raw = Decode<std::uint16_t>(*file, path);
  Image<float> depth{raw.width, raw.height, 1, {raw.pixels.begin(), raw.pixels.end()}};
  std::ranges::replace(depth.pixels, kSaturatedDepth, 0);
  return depth;
}

LabelImage ReadLabelImage(const std::filesystem::path& path) {
  const auto file = OpenLabels(path);
  if (file->info.num_channels != 1 || file->info.num_bits != 8) {
    throw DataError("{}: labels must be one channel of 8 bits, this has {} of {}",
                    path.string(),
                    file->info.num_channels,
                    file->info.num_bits);
  }
  LabelImage labels = Blank<std::uint8_t>(file->info);
  if (file->Read(labels.pixels.data())) return labels;  // other readers would read colors
  throw DataError("{}: cannot be decoded: copy it again", path.string());
}

ImageInfo InspectLabelImage(const std::filesystem::path& path) { return OpenLabels(path)->info; }

void CheckConfidenceSize(const std::string& file, int width, int height, const Camera& depth) {
  const int factor = width > 0 ? depth.width / width : 0;
  if (factor > 0 && depth.width == factor * width && depth.height == factor * height) return;
  throw DataError(
      "{}: {} x {} pixels, its depth has {} x {}: a picture of confidence has the size "
      "of depth, or a half, a third ... of it",
      file,
      width,
      height,
      depth.width,
      depth.height);
}

LabelImage ReadConfidenceOf(const Camera& depth_camera, const std::filesystem::path& path) {
  const ImageInfo info = InspectLabelImage(path);
  CheckConfidenceSize(path.string(), info.width, info.height, depth_camera);
  return ReadLabelImage(path);
}

ImageInfo InspectImage(const std::filesystem::path& path) {
  const auto file = Open(path);
  return file->has_exif ? LoadedMedia().OpenPicture(path, file->format)->info : file->info;
}

void WritePng(const std::filesystem::path& path, const Image<std::uint8_t>& image) {
  WritePngOf(path, image);
}

void WritePng(const std::filesystem::path& path, const Image<std::uint16_t>& image) {
  WritePngOf(path, image);
}

}  // namespace nightmap
