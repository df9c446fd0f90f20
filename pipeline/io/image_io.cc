// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/image_io.h"

// First include: otherwise OpenImageIO would define fmt's functions again from its own copy, and
// every program that formats a text would link OpenImageIO and all that it loads.
#include <fmt/format.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <fstream>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/memory.h"
#include "pipeline/io/camera_images.h"

namespace nightmap {
namespace {

constexpr int kPngCompression = 4;
constexpr std::streamoff kTailSize = 4096;  // bytes after the end mark that are tolerated
constexpr int kMaxSize_px = 1 << 15;        // a wider header is damage, not a camera
constexpr std::int64_t kMaxValues = std::int64_t{1} << 30;  // pixels times channels
constexpr int kMaxChannels = 4;  // RGB and alpha; the decoder makes room for all

// Stages process one image per thread, so the library's own threads would only compete.
void UseOneThreadPerImage() {
  static std::once_flag once;
  std::call_once(once, [] { OIIO::attribute("threads", 1); });
}

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
  using namespace std::string_view_literals;
  std::string_view end_mark;
  if (format == "png") end_mark = "IEND\xAE\x42\x60\x82"sv;
  if (format == "jpeg") end_mark = "\xFF\xD9"sv;
  if (end_mark.empty() || Tail(path).find(end_mark) != std::string::npos) return;
  throw DataError("{}: truncated {} file: copy it again", path.string(), format);
}

std::string Reason(const std::string& message) {
  return message.empty() ? "not a readable image" : message;
}

std::unique_ptr<OIIO::ImageInput> Open(const std::filesystem::path& path) {
  UseOneThreadPerImage();
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path, ignored)) {  // opening a pipe would block
    const bool is_there = std::filesystem::exists(path, ignored);
    throw DataError("{}: {}", path.string(), is_there ? "not a file" : "no such image file");
  }
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;  // colors as stored, not multiplied by alpha
  const MemoryWatch memory;
  auto input = OIIO::ImageInput::open(path.string(), &config);
  if (!input) {
    memory.Check(path.string());
    throw DataError("{}: {}", path.string(), Reason(OIIO::geterror()));
  }
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.width <= 0 || spec.height <= 0 || spec.nchannels <= 0 || spec.width > kMaxSize_px ||
      spec.height > kMaxSize_px) {
    throw DataError("{}: header says {} x {} pixels", path.string(), spec.width, spec.height);
  }
  if (spec.depth > 1 || spec.nchannels > kMaxChannels) {
    throw DataError("{}: header says {} layers of {} channels; a picture has one, of at most {}",
                    path.string(),
                    spec.depth,
                    spec.nchannels,
                    kMaxChannels);
  }
  if (std::int64_t{spec.width} * spec.height * spec.nchannels > kMaxValues) {
    throw DataError(
        "{}: header says {} x {} pixels of {} channels, more than {} values; make the "
        "picture smaller",
        path.string(),
        spec.width,
        spec.height,
        spec.nchannels,
        kMaxValues);
  }
  CheckEndMark(path, input->format_name());
  return input;
}

template <typename T>
Image<T> Decode(OIIO::ImageInput& input, const std::filesystem::path& path) {
  const OIIO::ImageSpec& spec = input.spec();
  Image<T> image{spec.width, spec.height, spec.nchannels, {}};
  image.pixels.resize(static_cast<std::size_t>(spec.image_pixels()) *
                      static_cast<std::size_t>(spec.nchannels));
  const auto type = OIIO::TypeDesc(OIIO::BaseTypeFromC<T>::value);
  const MemoryWatch memory;
  if (!input.read_image(0, 0, 0, spec.nchannels, type, image.pixels.data())) {
    memory.Check(path.string());
    throw DataError("{}: {}", path.string(), Reason(input.geterror()));
  }
  return image;
}

// Gray (+ alpha) to three equal channels, RGB + alpha to RGB.
ColorImage ToRgb(const Image<std::uint8_t>& image) {
  if (image.num_channels == 3) return image;
  ColorImage rgb{image.width, image.height, 3, {}};
  const std::size_t num_channels = static_cast<std::size_t>(image.num_channels);
  const std::size_t num_pixels = image.pixels.size() / num_channels;
  rgb.pixels.resize(num_pixels * 3);
  for (std::size_t i = 0; i < num_pixels; ++i) {
    for (std::size_t c = 0; c < 3; ++c) {
      rgb.pixels[3 * i + c] = image.pixels[num_channels * i + (num_channels < 3 ? 0 : c)];
    }
  }
  return rgb;
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

void CheckIsDepth(const OIIO::ImageSpec& spec, const std::filesystem::path& path) {
  if (spec.nchannels == 1 && spec.format == OIIO::TypeDesc::UINT16) return;
  throw DataError("{}: depth must be one channel of 16 bits, this has {} of {}",
                  path.string(),
                  spec.nchannels,
                  spec.format.c_str());
}

ExifLens LensOf(const OIIO::ImageSpec& spec) {
  return {spec.get_float_attribute("Exif:FocalLengthIn35mmFilm"),
          spec.get_float_attribute("Exif:FocalLength"),
          spec.get_float_attribute("Exif:FocalPlaneXResolution"),
          spec.get_int_attribute("Exif:FocalPlaneResolutionUnit", ExifLens().plane_unit),
          std::max(spec.get_float_attribute("Exif:PixelXDimension"),
                   spec.get_float_attribute("Exif:PixelYDimension"))};
}

void WriteBuffer(const std::filesystem::path& path, const OIIO::Filesystem::IOVecOutput& bytes) {
  const auto& buffer = bytes.buffer();
  WriteFile(path, {reinterpret_cast<const char*>(buffer.data()), buffer.size()});
}

template <typename T>
void WritePngOf(const std::filesystem::path& path, const Image<T>& image) {
  UseOneThreadPerImage();
  OIIO::ImageSpec spec(
      image.width, image.height, image.num_channels, OIIO::TypeDesc(OIIO::BaseTypeFromC<T>::value));
  spec["png:compressionLevel"] = kPngCompression;
  spec["oiio:UnassociatedAlpha"] = 1;
  OIIO::Filesystem::IOVecOutput bytes;  // through memory, because WriteFile reports a full disk
  auto output = OIIO::ImageOutput::create("png", &bytes);
  const bool done = output && output->open("memory.png", spec) &&
                    output->write_image(spec.format, image.pixels.data()) && output->close();
  if (!done) {
    throw DataError("{}: {}", path.string(), output ? output->geterror() : OIIO::geterror());
  }
  WriteBuffer(path, bytes);
}

}  // namespace

ColorImage ReadVideoFrame(const std::filesystem::path& video, int frame_idx);  // video_io.cc

ColorImage ReadColorImage(const std::filesystem::path& path) {
  if (const auto frame = SplitVideoFramePath(path)) {
    return ReadVideoFrame(frame->first, frame->second);
  }
  const auto input = Open(path);
  return ToRgb(Decode<std::uint8_t>(*input, path));
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

RawDepthImage ReadRawDepth(const std::filesystem::path& path) {
  const auto input = Open(path);
  CheckIsDepth(input->spec(), path);
  return Decode<std::uint16_t>(*input, path);
}

ColorImage ReadColorOf(const Camera& camera, const std::filesystem::path& path) {
  if (const auto frame = SplitVideoFramePath(path)) {
    ColorImage image = ReadVideoFrame(frame->first, frame->second);
    CheckSize(image.width, image.height, camera, path);
    return image;
  }
  const auto input = Open(path);
  CheckSize(input->spec().width, input->spec().height, camera, path);
  return ToRgb(Decode<std::uint8_t>(*input, path));
}

RawDepthImage ReadRawDepthOf(const Camera& camera, const std::filesystem::path& path) {
  const auto input = Open(path);
  CheckIsDepth(input->spec(), path);
  CheckSize(input->spec().width, input->spec().height, camera, path);
  return Decode<std::uint16_t>(*input, path);
}

GrayImage ReadGrayImage(const std::filesystem::path& path) {
  const auto input = Open(path);
  const OIIO::ImageSpec& spec = input->spec();
  if (spec.nchannels != 1 || spec.format != OIIO::TypeDesc::UINT8) {
    throw DataError("{}: expected one channel of 8 bits, this has {} of {}",
                    path.string(),
                    spec.nchannels,
                    spec.format.c_str());
  }
  return Decode<std::uint8_t>(*input, path);
}

ImageInfo InspectImage(const std::filesystem::path& path) {
  const auto input = Open(path);
  const OIIO::ImageSpec& spec = input->spec();
  const int num_bits = static_cast<int>(spec.format.size()) * 8;
  return {spec.width, spec.height, spec.nchannels, num_bits, LensOf(spec)};
}

void WritePng(const std::filesystem::path& path, const Image<std::uint8_t>& image) {
  WritePngOf(path, image);
}

void WritePng(const std::filesystem::path& path, const Image<std::uint16_t>& image) {
  WritePngOf(path, image);
}

}  // namespace nightmap
