// SPDX-License-Identifier: Apache-2.0
#include <turbojpeg.h>

#include <memory>
#include <string_view>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/io/picture_file.h"

namespace nightmap {
namespace {

class JpegFile : public PictureFile {
 public:
  explicit JpegFile(std::string bytes) : bytes_(std::move(bytes)), decoder_(tjInitDecompress()) {}
  ~JpegFile() override {
    if (decoder_) tjDestroy(decoder_);
  }
  JpegFile(const JpegFile&) = delete;
  JpegFile& operator=(const JpegFile&) = delete;

  // Whether the picture is of a kind that this class reads.
  bool Open() {
    int subsampling = 0;
    int colors = 0;
    if (!decoder_) return false;
    const int failed = tjDecompressHeader3(
        decoder_, Bytes(), bytes_.size(), &info.width, &info.height, &subsampling, &colors);
    if (failed != 0 || (colors != TJCS_YCbCr && colors != TJCS_GRAY)) return false;
    info.num_channels = colors == TJCS_GRAY ? 1 : 3;
    info.num_bits = 8;
    format = "jpeg";
    type = "uint8";
    has_exif = bytes_.find(std::string_view("Exif\0", 5)) != std::string::npos;
    return true;
  }

  // Data that libjpeg warns of count as not decodable.
  bool Read(std::uint8_t* pixels) override {
    return tjDecompress2(decoder_,
                         Bytes(),
                         bytes_.size(),
                         pixels,
                         info.width,
                         0,
                         info.height,
                         info.num_channels == 1 ? TJPF_GRAY : TJPF_RGB,
                         TJFLAG_ACCURATEDCT) == 0;
  }
  bool Read(std::uint16_t*) override { return false; }
  bool Read(float*) override { return false; }

 private:
  const unsigned char* Bytes() const {
    return reinterpret_cast<const unsigned char*>(bytes_.data());
  }

  std::string bytes_;
  tjhandle decoder_;
};

}  // namespace

std::unique_ptr<PictureFile> OpenJpeg(std::string bytes) {
  auto file = std::make_unique<JpegFile>(std::move(bytes));
  if (!file->Open()) return nullptr;
  return file;
}

std::string EncodeJpeg(const ColorImage& image, int quality, JpegColors colors) {
  const int sampling = colors == JpegColors::kFull ? TJSAMP_444 : TJSAMP_420;
  const std::unique_ptr<void, int (*)(tjhandle)> encoder(tjInitCompress(), tjDestroy);
  unsigned char* bytes = nullptr;
  unsigned long size = 0;
  const int failed = !encoder ? -1
                              : tjCompress2(encoder.get(),
                                            image.pixels.data(),
                                            image.width,
                                            0,
                                            image.height,
                                            TJPF_RGB,
                                            &bytes,
                                            &size,
                                            sampling,
                                            quality,
                                            TJFLAG_ACCURATEDCT);
  const std::unique_ptr<unsigned char, void (*)(unsigned char*)> owner(bytes, tjFree);
  if (failed != 0) {
    throw DataError("cannot encode a picture of {} x {} pixels as JPEG: {}",
                    image.width,
                    image.height,
                    encoder ? tjGetErrorStr2(encoder.get()) : tjGetErrorStr());
  }
  return {reinterpret_cast<const char*>(bytes), size};
}

}  // namespace nightmap
