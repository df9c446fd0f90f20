// SPDX-License-Identifier: Apache-2.0
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <csetjmp>
#include <cstring>
#include <new>
#include <utility>
#include <vector>

#include "pipeline/io/picture_file.h"

namespace nightmap {
namespace {

constexpr int kPngCompression = 4;

// libpng jumps out of a function on an error: nothing in it may have a destructor to run.
[[noreturn]] void Fail(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void Ignore(png_structp, png_const_charp) {}

struct Unread {
  const char* next = nullptr;
  std::size_t size = 0;
};

void ReadSome(png_structp png, png_bytep to, std::size_t size) {
  auto* unread = static_cast<Unread*>(png_get_io_ptr(png));
  if (size > unread->size) png_error(png, "truncated");
  std::memcpy(to, unread->next, size);
  unread->next += size;
  unread->size -= size;
}

class PngFile : public PictureFile {
 public:
  explicit PngFile(std::string bytes)
      : bytes_(std::move(bytes)), unread_{bytes_.data(), bytes_.size()} {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, Fail, Ignore);
    if (png_) info_ = png_create_info_struct(png_);
  }
  ~PngFile() override { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngFile(const PngFile&) = delete;
  PngFile& operator=(const PngFile&) = delete;

  // Whether the picture is of a kind that this class reads.
  bool Open(PngValues values) {
    if (!info_ || !ReadHeader()) return false;
    if (values == PngValues::kIndices ? !HoldsIndices() : !HoldsUsualColors()) return false;
    info.width = static_cast<int>(png_get_image_width(png_, info_));
    info.height = static_cast<int>(png_get_image_height(png_, info_));
    info.num_channels = png_get_channels(png_, info_);
    info.num_bits = std::max(8, static_cast<int>(png_get_bit_depth(png_, info_)));
    format = "png";
    type = info.num_bits == 8 ? "uint8" : "uint16";
    has_exif = png_get_valid(png_, info_, PNG_INFO_eXIf) != 0;
    return true;
  }

  bool Read(std::uint8_t* pixels) override { return info.num_bits == 8 && ReadRows(pixels); }
  bool Read(std::uint16_t* pixels) override {
    return info.num_bits == 16 && ReadRows(reinterpret_cast<png_bytep>(pixels));
  }
  bool Read(float*) override { return false; }

 private:
  bool HoldsUsualColors() const {
    return (png_get_color_type(png_, info_) & PNG_COLOR_MASK_PALETTE) == 0 &&
           png_get_bit_depth(png_, info_) >= 8 &&
           png_get_interlace_type(png_, info_) == PNG_INTERLACE_NONE &&
           png_get_valid(png_, info_, PNG_INFO_tRNS) == 0;
  }
  bool HoldsIndices() const {
    return png_get_channels(png_, info_) == 1 && png_get_bit_depth(png_, info_) <= 8;
  }

  bool ReadHeader() {
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    png_set_read_fn(png_, &unread_, ReadSome);
    png_read_info(png_, info_);
    return true;
  }

  bool ReadRows(png_bytep pixels) {
    const std::size_t row_size = static_cast<std::size_t>(info.width) *
                                 static_cast<std::size_t>(info.num_channels * info.num_bits / 8);
    if (setjmp(png_jmpbuf(png_)) != 0) return false;
    if (info.num_bits == 16) png_set_swap(png_);  // files have the high byte first
    png_set_packing(png_);                        // a byte for each value of fewer bits
    const int num_passes = png_set_interlace_handling(png_);
    png_read_update_info(png_, info_);
    for (int pass = 0; pass < num_passes; ++pass) {
      for (int y = 0; y < info.height; ++y) {
        png_read_row(png_, pixels + static_cast<std::size_t>(y) * row_size, nullptr);
      }
    }
    return true;
  }

  std::string bytes_;
  Unread unread_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

void AppendSome(png_structp png, png_bytep from, std::size_t size) {
  try {
    static_cast<std::string*>(png_get_io_ptr(png))
        ->append(reinterpret_cast<const char*>(from), size);
    return;
  } catch (const std::bad_alloc&) {
  }
  png_error(png, "out of memory");
}

template <typename T>
bool Write(png_structp png, png_infop info, const Image<T>& image, std::string* bytes) {
  constexpr int kColors[] = {
      PNG_COLOR_TYPE_GRAY, PNG_COLOR_TYPE_GRAY_ALPHA, PNG_COLOR_TYPE_RGB, PNG_COLOR_TYPE_RGB_ALPHA};
  const std::size_t row_size =
      static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.num_channels);
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_write_fn(png, bytes, AppendSome, nullptr);
  png_set_compression_level(png, kPngCompression);
  png_set_compression_strategy(png, Z_DEFAULT_STRATEGY);
  png_set_IHDR(png,
               info,
               static_cast<png_uint_32>(image.width),
               static_cast<png_uint_32>(image.height),
               8 * sizeof(T),
               kColors[image.num_channels - 1],
               PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT,
               PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  if (sizeof(T) == 2) png_set_swap(png);
  for (int y = 0; y < image.height; ++y) {
    const T* row = &image.pixels[static_cast<std::size_t>(y) * row_size];
    png_write_row(png, reinterpret_cast<png_const_bytep>(row));
  }
  png_write_end(png, info);
  return true;
}

template <typename T>
std::string Encode(const Image<T>& image) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, Fail, Ignore);
  png_infop info = png ? png_create_info_struct(png) : nullptr;
  const bool is_written = info && Write(png, info, image, &bytes);
  png_destroy_write_struct(&png, &info);
  return is_written ? bytes : "";
}

}  // namespace

std::unique_ptr<PictureFile> OpenPng(std::string bytes, PngValues values) {
  auto file = std::make_unique<PngFile>(std::move(bytes));
  if (!file->Open(values)) return nullptr;
  return file;
}

std::string EncodePng(const Image<std::uint8_t>& image) { return Encode(image); }
std::string EncodePng(const Image<std::uint16_t>& image) { return Encode(image); }

}  // namespace nightmap
