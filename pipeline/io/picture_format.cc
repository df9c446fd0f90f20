// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/picture_format.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <string>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

using namespace std::string_view_literals;

constexpr int kMaxSize_px = 1 << 15;  // a wider header is damage, not a camera
constexpr std::int64_t kMaxValues = std::int64_t{1} << 30;  // pixels times channels
constexpr int kMaxChannels = 4;  // RGB and alpha; the decoder makes room for all

struct Signature {
  std::string_view format;  // of a picture; empty: of a video
  std::string_view start;   // '?' stands for any byte
};

constexpr std::size_t kPacketSize = 188;  // of an MPEG transport stream

constexpr std::array kSignatures = {
    Signature{"png", "\x89PNG\r\n\x1A\n"sv},
    Signature{"jpeg", "\xFF\xD8\xFF"sv},
    Signature{"tiff", "II*\0"sv},
    Signature{"tiff", "MM\0*"sv},
    Signature{"tiff", "II+\0"sv},  // BigTIFF
    Signature{"tiff", "MM\0+"sv},
    Signature{"bmp", "BM"sv},
    Signature{"pnm", "P1"sv},
    Signature{"pnm", "P2"sv},
    Signature{"pnm", "P3"sv},
    Signature{"pnm", "P4"sv},
    Signature{"pnm", "P5"sv},
    Signature{"pnm", "P6"sv},
    Signature{"webp", "RIFF????WEBP"sv},
    Signature{"heif", "????ftypheic"sv},
    Signature{"heif", "????ftypheix"sv},
    Signature{"heif", "????ftyphevc"sv},
    Signature{"heif", "????ftypmif1"sv},
    Signature{"heif", "????ftypmsf1"sv},
    Signature{"heif", "????ftypavif"sv},
    Signature{"openexr", "v/1\x01"sv},
    Signature{"", "????ftyp"sv},  // MP4, QuickTime, 3GP: their brands are many
    Signature{"", "????moov"sv},  // QuickTime before it had brands
    Signature{"", "????mdat"sv},
    Signature{"", "????wide"sv},
    Signature{"", "????free"sv},
    Signature{"", "????skip"sv},
    Signature{"", "RIFF????AVI "sv},
    Signature{"", "\x1A\x45\xDF\xA3"sv},  // Matroska, WebM
    Signature{"", "GIF8"sv},
    Signature{"", "\x30\x26\xB2\x75\x8E\x66\xCF\x11"sv},  // ASF: WMV
    Signature{"", "\0\0\x01\xBA"sv},                      // MPEG program stream
    Signature{"", "\0\0\x01\xB3"sv},                      // MPEG video alone
    Signature{"", "FLV\x01"sv},
    Signature{"", "OggS"sv},
};

bool Begins(std::string_view start, std::string_view signature) {
  return start.size() >= signature.size() &&
         std::ranges::equal(signature, start.substr(0, signature.size()), [](char s, char byte) {
           return s == '?' || s == byte;
         });
}

const Signature* SignatureOf(std::string_view start) {
  const auto found = std::ranges::find_if(
      kSignatures, [&](const Signature& signature) { return Begins(start, signature.start); });
  return found == kSignatures.end() ? nullptr : &*found;
}

// Its packets begin with one byte, after a time of four bytes in camcorders' files.
bool IsTransportStream(std::string_view start) {
  constexpr char kSync = 0x47;
  for (const std::size_t time_size : {std::size_t{0}, std::size_t{4}}) {
    const std::size_t next = 2 * time_size + kPacketSize;
    if (start.size() > next && start[time_size] == kSync && start[next] == kSync) return true;
  }
  return false;
}

std::int64_t BigEndian(std::string_view bytes) {
  std::int64_t value = 0;
  for (const char byte : bytes) value = value * 256 + static_cast<unsigned char>(byte);
  return value;
}

}  // namespace

std::string_view FormatOfPicture(std::string_view start) {
  const Signature* signature = SignatureOf(start);
  return signature ? signature->format : "";
}

bool IsVideo(std::string_view start) {
  const Signature* signature = SignatureOf(start);
  return signature ? signature->format.empty() : IsTransportStream(start);
}

std::string_view FormatOfFile(const std::filesystem::path& path) {
  std::string start(256, '\0');
  std::ifstream file(path, std::ios::binary);
  file.read(start.data(), static_cast<std::streamsize>(start.size()));
  start.resize(static_cast<std::size_t>(file.gcount()));
  if (const std::string_view format = FormatOfPicture(start); !format.empty()) return format;
  if (IsVideo(start)) {
    throw DataError(
        "{}: is a video or an animation, no picture: extract the frames to localize as pictures; a "
        "recording of video has layout = \"video\"",
        path.string());
  }
  throw DataError(
      "{}: is no picture of a known format (PNG, JPEG, TIFF, BMP, PNM, WebP, HEIF, AVIF, OpenEXR): "
      "convert it to PNG or JPEG, or copy it again",
      path.string());
}

void CheckPictureSize(const std::filesystem::path& path,
                      std::int64_t width,
                      std::int64_t height,
                      std::int64_t num_channels) {
  if (width <= 0 || height <= 0 || num_channels <= 0 || width > kMaxSize_px ||
      height > kMaxSize_px) {
    throw DataError("{}: header says {} x {} pixels", path.string(), width, height);
  }
  if (num_channels > kMaxChannels) {
    throw DataError("{}: header says {} channels; a picture has at most {}",
                    path.string(),
                    num_channels,
                    kMaxChannels);
  }
  if (width * height * num_channels > kMaxValues) {
    throw DataError(
        "{}: header says {} x {} pixels of {} channels, more than {} values; make the "
        "picture smaller",
        path.string(),
        width,
        height,
        num_channels,
        kMaxValues);
  }
}

void CheckHeifSizes(const std::filesystem::path& path, std::string_view bytes) {
  constexpr std::string_view kBox = "\0\0\0\x14ispe\0\0\0\0"sv;  // 20 bytes: then width and height
  for (std::size_t at = bytes.find(kBox); at < bytes.size(); at = bytes.find(kBox, at + 1)) {
    const std::string_view size = bytes.substr(at + kBox.size());
    if (size.size() < 8) return;
    CheckPictureSize(path, BigEndian(size.substr(0, 4)), BigEndian(size.substr(4, 4)), 3);
  }
}

}  // namespace nightmap
