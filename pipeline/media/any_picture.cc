// SPDX-License-Identifier: Apache-2.0
#include "pipeline/media/any_picture.h"

// First include: otherwise OpenImageIO would define fmt's functions again from its own copy.
#include <fmt/format.h>

#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <mutex>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/memory.h"

namespace nightmap::media {
namespace {

// Stages process one image per thread, so the library's own threads would only compete.
void UseOneThreadPerImage() {
  static std::once_flag once;
  std::call_once(once, [] { OIIO::attribute("threads", 1); });
}

std::string Reason(const std::string& message) {
  return message.empty() ? "not a readable image" : message;
}

ExifLens LensOf(const OIIO::ImageSpec& spec) {
  return {spec.get_float_attribute("Exif:FocalLengthIn35mmFilm"),
          spec.get_float_attribute("Exif:FocalLength"),
          spec.get_float_attribute("Exif:FocalPlaneXResolution"),
          spec.get_int_attribute("Exif:FocalPlaneResolutionUnit", ExifLens().plane_unit),
          std::max(spec.get_float_attribute("Exif:PixelXDimension"),
                   spec.get_float_attribute("Exif:PixelYDimension"))};
}

class AnyPicture : public PictureFile {
 public:
  AnyPicture(std::filesystem::path path, std::unique_ptr<OIIO::ImageInput> input)
      : path_(std::move(path)), input_(std::move(input)) {
    const OIIO::ImageSpec& spec = input_->spec();
    if (spec.depth > 1)
      throw DataError(
          "{}: header says {} layers; a picture has one layer", path_.string(), spec.depth);
    info = {spec.width,
            spec.height,
            spec.nchannels,
            8 * static_cast<int>(spec.format.size()),
            LensOf(spec),
            spec.format.is_floating_point()};
    format = input_->format_name();
    type = spec.format.c_str();
  }

  bool Read(std::uint8_t* pixels) override { return ReadAs(OIIO::TypeDesc::UINT8, pixels); }
  bool Read(std::uint16_t* pixels) override { return ReadAs(OIIO::TypeDesc::UINT16, pixels); }
  bool Read(float* pixels) override { return ReadAs(OIIO::TypeDesc::FLOAT, pixels); }

 private:
  // Throws instead of returning false: nothing else could read the file.
  bool ReadAs(OIIO::TypeDesc as, void* pixels) {
    const MemoryWatch memory;
    // read_image fills the missing part of a truncated TIFF with zeros, returns true, and leaves an
    // error.
    if (input_->read_image(0, 0, 0, info.num_channels, as, pixels) && !input_->has_error()) {
      return true;
    }
    memory.Check(path_.string());
    throw DataError("{}: {}: copy it again", path_.string(), Reason(input_->geterror()));
  }

  std::filesystem::path path_;
  std::unique_ptr<OIIO::ImageInput> input_;
};

}  // namespace

std::unique_ptr<PictureFile> OpenAnyPicture(const std::filesystem::path& path,
                                            std::string_view format) {
  UseOneThreadPerImage();
  OIIO::ImageSpec config;
  config["oiio:UnassociatedAlpha"] = 1;
  const MemoryWatch memory;
  auto input = OIIO::ImageInput::create(std::string(format));
  OIIO::ImageSpec ignored;
  if (!input || !input->open(path.string(), ignored, config)) {
    memory.Check(path.string());
    throw DataError("{}: {}: copy it again",
                    path.string(),
                    Reason(input ? input->geterror() : OIIO::geterror()));
  }
  return std::make_unique<AnyPicture>(path, std::move(input));
}

}  // namespace nightmap::media
