// SPDX-License-Identifier: Apache-2.0
// Animated GIF with giflib. OpenImageIO's writer chooses a palette of its own for each image and
// dithers, which leaves smudges where the robot was.
#include <gif_lib.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/image_io.h"

namespace nightmap {
namespace {

constexpr std::size_t kMaxColors = 256;

// Images as numbers of colors, numbered by their first appearance.
class Palette {
 public:
  std::string Index(const ColorImage& image) {
    std::string indices;
    indices.reserve(image.pixels.size() / 3);
    for (std::size_t i = 0; i + 2 < image.pixels.size(); i += 3) {
      const GifColorType color = {image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]};
      const int key = color.Red << 16 | color.Green << 8 | color.Blue;
      if (key != last_key_) {
        const auto [found, is_new] = index_of_.emplace(key, colors_.size());
        if (is_new) colors_.push_back(color);
        last_key_ = key;
        last_index_ = static_cast<char>(found->second);
      }
      indices.push_back(last_index_);
    }
    return indices;
  }
  std::size_t Size() const { return colors_.size(); }
  // With a power of two of entries, as the format has it.
  std::vector<GifColorType> Padded() const {
    auto padded = colors_;
    padded.resize(std::max<std::size_t>(2, std::bit_ceil(colors_.size())));
    return padded;
  }

 private:
  std::map<int, std::size_t> index_of_;
  std::vector<GifColorType> colors_;
  int last_key_ = -1;
  char last_index_ = 0;
};

struct Part {
  int left = 0;
  int top = 0;
  int width = 1;  // an image has at least one pixel
  int height = 1;
};

// The rectangle of what differs.
Part ChangedPart(const std::string& before, const std::string& now, int width) {
  int left = width, right = -1, top = -1, bottom = -1;
  const auto row_length = static_cast<std::size_t>(width);
  for (std::size_t begin = 0; begin < now.size(); begin += row_length) {
    if (now.compare(begin, row_length, before, begin, row_length) == 0) continue;
    bottom = static_cast<int>(begin / row_length);
    if (top < 0) top = bottom;
    for (int x = 0; x < width; ++x) {
      const std::size_t i = begin + static_cast<std::size_t>(x);
      if (now[i] == before[i]) continue;
      left = std::min(left, x);
      right = std::max(right, x);
    }
  }
  if (right < 0) return {};
  return {left, top, right - left + 1, bottom - top + 1};
}

int AppendBytes(GifFileType* gif, const GifByteType* bytes, int size) {
  static_cast<std::string*>(gif->UserData)->append(bytes, bytes + size);
  return size;
}

// Encodes into memory. A failed call leaves the writer failed.
class GifWriter {
 public:
  GifWriter(int width, int height, const Palette& palette)
      : gif_(EGifOpen(&bytes_, AppendBytes, &error_)) {
    auto colors = palette.Padded();
    map_.reset(GifMakeMapObject(static_cast<int>(colors.size()), colors.data()));
    if (!gif_ || !map_) return;
    EGifSetGifVersion(gif_, true);
    Check(EGifPutScreenDesc(gif_, width, height, map_->BitsPerPixel, 0, map_.get()));
  }
  ~GifWriter() {
    if (gif_) EGifCloseFile(gif_, nullptr);
  }
  GifWriter(const GifWriter&) = delete;
  GifWriter& operator=(const GifWriter&) = delete;

  void RepeatForEver() {
    constexpr char kName[] = "NETSCAPE2.0";
    constexpr GifByteType kRepeat[] = {1, 0, 0};
    if (!ok_) return;
    Check(EGifPutExtensionLeader(gif_, APPLICATION_EXT_FUNC_CODE));
    Check(EGifPutExtensionBlock(gif_, static_cast<int>(std::strlen(kName)), kName));
    Check(EGifPutExtensionBlock(gif_, sizeof kRepeat, kRepeat));
    Check(EGifPutExtensionTrailer(gif_));
  }

  // What was there stays under it.
  void Append(std::string indices, int width, const Part& part, int delay_cs) {
    if (!ok_) return;
    const GraphicsControlBlock control{DISPOSE_DO_NOT, false, delay_cs, NO_TRANSPARENT_COLOR};
    GifByteType extension[4];
    const std::size_t size = EGifGCBToExtension(&control, extension);
    Check(EGifPutExtension(gif_, GRAPHICS_EXT_FUNC_CODE, static_cast<int>(size), extension));
    Check(EGifPutImageDesc(gif_, part.left, part.top, part.width, part.height, false, nullptr));
    for (int y = part.top; ok_ && y < part.top + part.height; ++y) {
      char* row = indices.data() + static_cast<std::ptrdiff_t>(y) * width + part.left;
      Check(EGifPutLine(gif_, reinterpret_cast<GifPixelType*>(row), part.width));
    }
  }

  // The file, or nothing when a call has failed.
  std::string Take() {
    if (gif_ && EGifCloseFile(std::exchange(gif_, nullptr), nullptr) == GIF_ERROR) ok_ = false;
    return ok_ ? std::move(bytes_) : std::string();
  }

 private:
  struct FreeMap {
    void operator()(ColorMapObject* map) const { GifFreeMapObject(map); }
  };
  void Check(int result) { ok_ = ok_ && result == GIF_OK; }

  std::string bytes_;
  int error_ = 0;
  GifFileType* gif_;
  std::unique_ptr<ColorMapObject, FreeMap> map_;
  bool ok_ = true;
};

}  // namespace

void WriteGif(const std::filesystem::path& path,
              const std::vector<ColorImage>& images,
              double images_per_s) {
  const int width = images.at(0).width;
  const int height = images[0].height;
  Palette palette;
  std::vector<std::string> indices;
  for (const ColorImage& image : images) {
    if (image.width != width || image.height != height) {
      throw DataError("{}: the images of an animation differ in size", path.string());
    }
    indices.push_back(palette.Index(image));
  }
  if (palette.Size() > kMaxColors) {
    throw DataError(
        "{}: a GIF holds {} colors, the images have {}", path.string(), kMaxColors, palette.Size());
  }
  GifWriter writer(width, height, palette);
  writer.RepeatForEver();
  const int delay_cs = static_cast<int>(std::lround(100 / images_per_s));
  for (std::size_t i = 0; i < indices.size(); ++i) {
    const Part part =
        i == 0 ? Part{0, 0, width, height} : ChangedPart(indices[i - 1], indices[i], width);
    writer.Append(indices[i], width, part, delay_cs);
  }
  const std::string bytes = writer.Take();
  if (bytes.empty()) throw DataError("{}: giflib cannot encode the animation", path.string());
  WriteFile(path, bytes);
}

}  // namespace nightmap
