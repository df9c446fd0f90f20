// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cstring>
#include <string>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/io/picture_file.h"
#include "pipeline/io/picture_format.h"

namespace nightmap {
namespace {

// Reads the next number of a PNM header; comments run from # to the end of the line.
int HeaderNumber(const std::string& bytes,
                 std::size_t& at,
                 const std::string& path,
                 const char* field) {
  while (at < bytes.size() &&
         (std::isspace(static_cast<unsigned char>(bytes[at])) != 0 || bytes[at] == '#')) {
    at = bytes[at] == '#' ? std::min(bytes.find('\n', at), bytes.size()) : at + 1;
  }
  constexpr int kMax = 65535;
  int value = 0;
  const auto [end, error] = std::from_chars(bytes.data() + at, bytes.data() + bytes.size(), value);
  if (error != std::errc() || value < 1 || value > kMax) {
    throw DataError("{}: {} in the PNM header is not a number in [1, {}]: copy the file again",
                    path,
                    field,
                    kMax);
  }
  at = static_cast<std::size_t>(end - bytes.data());
  return value;
}

class PgmFile : public PictureFile {
 public:
  PgmFile(std::string bytes, std::size_t begin, int width, int height)
      : bytes_(std::move(bytes)), begin_(begin) {
    info.width = width;
    info.height = height;
    info.num_channels = 1;
    info.num_bits = 8;
    format = "pnm";
    type = "uint8";
  }

  bool Read(std::uint8_t* pixels) override {
    std::memcpy(pixels, bytes_.data() + begin_, bytes_.size() - begin_);
    return true;
  }
  bool Read(std::uint16_t*) override { return false; }
  bool Read(float*) override { return false; }

 private:
  std::string bytes_;
  std::size_t begin_;
};

// One whose size can be asked, and whose pixels cannot be had.
class DamagedPnm : public PictureFile {
 public:
  DamagedPnm(int width, int height, int num_channels, bool is_wide, std::string reason)
      : reason_(std::move(reason)) {
    info.width = width;
    info.height = height;
    info.num_channels = num_channels;
    info.num_bits = is_wide ? 16 : 8;
    format = "pnm";
    type = is_wide ? "uint16" : "uint8";
  }

  bool Read(std::uint8_t*) override { throw DataError("{}", reason_); }
  bool Read(std::uint16_t*) override { throw DataError("{}", reason_); }
  bool Read(float*) override { throw DataError("{}", reason_); }

 private:
  std::string reason_;
};

// Fewest bytes that hold so many values, of a file whose kind is its second character.
std::size_t LeastSize(char kind, std::size_t num_values, int max_value) {
  if (kind == '4') return num_values / 8;
  if (kind == '2' || kind == '3') return 2 * num_values - 1;  // a digit and a blank
  return max_value > 255 ? 2 * num_values : num_values;
}

}  // namespace

std::unique_ptr<PictureFile> OpenPgm(const std::filesystem::path& path, std::string bytes) {
  const std::string name = path.string();
  std::size_t at = 2;
  const int width = HeaderNumber(bytes, at, name, "width");
  const int height = HeaderNumber(bytes, at, name, "height");
  const int num_channels = bytes[1] == '3' || bytes[1] == '6' ? 3 : 1;
  CheckPictureSize(path, width, height, num_channels);
  const bool has_max = bytes[1] != '1' && bytes[1] != '4';
  const int max_value = has_max ? HeaderNumber(bytes, at, name, "largest value") : 1;
  ++at;  // the single white space before the pixels
  const std::size_t num_values = static_cast<std::size_t>(width) *
                                 static_cast<std::size_t>(height) *
                                 static_cast<std::size_t>(num_channels);
  const std::size_t size = bytes.size() - std::min(at, bytes.size());
  const std::size_t least = LeastSize(bytes[1], num_values, max_value);
  const bool is_pgm = bytes[1] == '5' && max_value == 255;
  if (size < least || (is_pgm && size > least)) {
    return std::make_unique<DamagedPnm>(
        width,
        height,
        num_channels,
        max_value > 255,
        fmt::format("{}: {} bytes of {} x {} pixels, {} expected: {}: copy it again, as binary",
                    name,
                    size,
                    width,
                    height,
                    least,
                    size < least ? "truncated" : "too long"));
  }
  if (!is_pgm) return nullptr;
  return std::make_unique<PgmFile>(std::move(bytes), at, width, height);
}

}  // namespace nightmap
