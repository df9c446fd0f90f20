// SPDX-License-Identifier: Apache-2.0
// An open picture file. Four read the same pixels from the same bytes: three the PNG, JPEG and PGM
// that cameras and this pipeline write, the fourth whatever OpenImageIO reads (media.h).
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "pipeline/io/image_io.h"

namespace nightmap {

class PictureFile {
 public:
  virtual ~PictureFile() = default;
  // Fills width x height x num_channels values, row by row, channels interleaved. False when the
  // values are of another type or cannot be decoded.
  virtual bool Read(std::uint8_t* pixels) = 0;
  virtual bool Read(std::uint16_t* pixels) = 0;
  virtual bool Read(float* pixels) = 0;

  ImageInfo info;         // with the lens when `has_exif` is not set
  std::string format;     // "png", "jpeg", or another of OpenImageIO's names
  bool has_exif = false;  // and this reader does not read it
  std::string type;  // of a value: "uint8", "uint16", "float", or another of OpenImageIO's names
};

// Meaning of a PNG's values. Indices are read as stored, one byte for each: neither is a value
// of few bits scaled to 8 bits, nor one of a palette replaced by its color.
enum class PngValues { kColors, kIndices };

// Nothing unless `bytes` begins a PNG of 8 or 16 bits, gray or RGB, alpha or not, that is not
// interlaced and has no transparent color; or, of indices, a gray one or one with a palette, of at
// most 8 bits.
std::unique_ptr<PictureFile> OpenPng(std::string bytes, PngValues values = PngValues::kColors);
// Nothing unless `bytes` begins a gray or YCbCr JPEG.
std::unique_ptr<PictureFile> OpenJpeg(std::string bytes);
// Nothing unless `bytes` begins a binary PGM (P5) of values up to 255, or a damaged PNM. Throws
// DataError naming the file when a PNM file's header is damaged. So does Read when it holds fewer
// pixels than that says, or a PGM more: one byte too many, as of line ends that a copy made two
// bytes long, would move the picture.
std::unique_ptr<PictureFile> OpenPgm(const std::filesystem::path& path, std::string bytes);

// The bytes of a PNG file of 1 to 4 channels, which depend on the pixels alone; empty when a PNG
// cannot hold them, or memory is short.
std::string EncodePng(const Image<std::uint8_t>& image);
std::string EncodePng(const Image<std::uint16_t>& image);

// Whether a JPEG file holds the colors of each pixel, or of four together as cameras do.
enum class JpegColors { kFull, kSubsampled };

// The bytes of a JPEG file of an RGB picture, which depend on the pixels, the quality (1 .. 100)
// and the colors alone. Throws DataError when libjpeg cannot encode it, as beyond 65500
// pixels of width or height.
std::string EncodeJpeg(const ColorImage& image, int quality, JpegColors colors);

}  // namespace nightmap
