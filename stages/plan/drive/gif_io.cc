// SPDX-License-Identifier: Apache-2.0
#include "stages/plan/drive/gif_io.h"

#include <fmt/format.h>
#include <gif_lib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <memory>
#include <string>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

namespace nightmap {
namespace {

using Color = std::array<std::uint8_t, 3>;

// The colors of all images, each with its index in the color map.
class Palette {
 public:
  static constexpr std::size_t kMaxColors = 256;

  explicit Palette(const std::vector<ColorImage>& images) {
    for (const ColorImage& image : images) {
      for (std::size_t i = 0; i + 2 < image.pixels.size() && Size() <= kMaxColors; i += 3) {
        places_.try_emplace(ColorAt(image, i), static_cast<GifPixelType>(places_.size()));
      }
    }
  }

  std::size_t Size() const { return places_.size(); }

  std::vector<GifPixelType> Indices(const ColorImage& image) const {
    std::vector<GifPixelType> indices(image.pixels.size() / 3);
    for (std::size_t i = 0; i < indices.size(); ++i) indices[i] = places_.at(ColorAt(image, 3 * i));
    return indices;
  }

  using ColorMap = std::unique_ptr<ColorMapObject, void (*)(ColorMapObject*)>;
  // Padded, because GIF requires a power of two.
  ColorMap MakeColorMap() const {
    const int size = static_cast<int>(std::bit_ceil(std::max<std::size_t>(2, Size())));
    ColorMap colors(GifMakeMapObject(size, nullptr), GifFreeMapObject);
    for (const auto& [color, place] : places_) {
      if (colors) colors->Colors[place] = {color[0], color[1], color[2]};
    }
    return colors;
  }

 private:
  static Color ColorAt(const ColorImage& image, std::size_t i) {
    return {image.pixels[i], image.pixels[i + 1], image.pixels[i + 2]};
  }

  std::map<Color, GifPixelType> places_;
};

struct Box {
  int left = 0, top = 0, width = 0, height = 0;
};

// The smallest box that holds every pixel in which two images differ; one pixel when none does.
Box ChangedBox(const std::vector<GifPixelType>& before,
               const std::vector<GifPixelType>& after,
               int width) {
  int left = width, right = -1, top = -1, bottom = -1;
  for (std::size_t i = 0; i < after.size(); ++i) {
    if (before[i] == after[i]) continue;
    const int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
    left = std::min(left, x);
    right = std::max(right, x);
    if (top < 0) top = y;
    bottom = y;
  }
  if (right < 0) return {0, 0, 1, 1};
  return {left, top, right - left + 1, bottom - top + 1};
}

int Append(GifFileType* gif, const GifByteType* bytes, int size) {
  static_cast<std::string*>(gif->UserData)
      ->append(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
  return size;
}

// A GIF under construction. Its functions return false when the library refuses.
class Encoder {
 public:
  Encoder() : gif_(EGifOpen(&bytes_, Append, &error_)) {}
  ~Encoder() {
    if (gif_) EGifCloseFile(gif_, &error_);
  }
  Encoder(const Encoder&) = delete;
  Encoder& operator=(const Encoder&) = delete;

  bool Begin(int width, int height, const Palette& palette) {
    const auto colors = palette.MakeColorMap();
    if (!gif_ || !colors) return false;
    EGifSetGifVersion(gif_, true);
    return EGifPutScreenDesc(gif_, width, height, 8, 0, colors.get()) != GIF_ERROR && Repeat();
  }

  bool Add(std::vector<GifPixelType> image, int width, const Box& box, int delay_cs) {
    const GraphicsControlBlock control{DISPOSE_DO_NOT, false, delay_cs, NO_TRANSPARENT_COLOR};
    std::array<GifByteType, 4> extension{};
    EGifGCBToExtension(&control, extension.data());
    bool done =
        EGifPutExtension(gif_, GRAPHICS_EXT_FUNC_CODE, extension.size(), extension.data()) !=
            GIF_ERROR &&
        EGifPutImageDesc(gif_, box.left, box.top, box.width, box.height, false, nullptr) !=
            GIF_ERROR;
    for (int y = box.top; done && y < box.top + box.height; ++y) {
      GifPixelType* row =
          image.data() + static_cast<std::size_t>(y) * static_cast<std::size_t>(width);
      done = EGifPutLine(gif_, row + box.left, box.width) != GIF_ERROR;
    }
    return done;
  }

  bool Finish() {
    GifFileType* gif = std::exchange(gif_, nullptr);
    return EGifCloseFile(gif, &error_) != GIF_ERROR;
  }

  const std::string& Bytes() const { return bytes_; }
  std::string Reason() const {
    const char* text = GifErrorString(gif_ ? gif_->Error : error_);
    return text ? text : "unknown error";
  }

 private:
  // Repeats for ever, by the extension that browsers understand.
  bool Repeat() {
    static constexpr std::array<GifByteType, 3> kForEver = {1, 0, 0};
    return EGifPutExtensionLeader(gif_, APPLICATION_EXT_FUNC_CODE) != GIF_ERROR &&
           EGifPutExtensionBlock(gif_, 11, "NETSCAPE2.0") != GIF_ERROR &&
           EGifPutExtensionBlock(gif_, kForEver.size(), kForEver.data()) != GIF_ERROR &&
           EGifPutExtensionTrailer(gif_) != GIF_ERROR;
  }

  std::string bytes_;
  int error_ = 0;
  GifFileType* gif_;
};

void CheckImages(const std::filesystem::path& path, const std::vector<ColorImage>& images) {
  if (images.empty()) throw DataError("{}: an animation needs an image", path.string());
  for (const ColorImage& image : images) {
    if (image.width == images[0].width && image.height == images[0].height) continue;
    throw DataError("{}: images of an animation must have one size", path.string());
  }
}

}  // namespace

void WriteGif(const std::filesystem::path& path,
              const std::vector<ColorImage>& images,
              double images_per_s) {
  CheckImages(path, images);
  const Palette palette(images);
  if (palette.Size() > Palette::kMaxColors) {
    throw DataError("{}: an animation has at most 256 colors; draw without smooth edges",
                    path.string());
  }
  const int width = images[0].width, height = images[0].height;
  const int delay_cs = std::max(1, static_cast<int>(std::lround(100 / images_per_s)));
  Encoder encoder;
  bool done = encoder.Begin(width, height, palette);
  std::vector<GifPixelType> before;
  for (std::size_t i = 0; done && i < images.size(); ++i) {
    auto image = palette.Indices(images[i]);
    const Box box = i == 0 ? Box{0, 0, width, height} : ChangedBox(before, image, width);
    before = image;
    done = encoder.Add(std::move(image), width, box, delay_cs);
  }
  if (!done || !encoder.Finish()) {
    throw DataError("{}: cannot make the animation: {}", path.string(), encoder.Reason());
  }
  WriteFile(path, encoder.Bytes());
}

}  // namespace nightmap
