// SPDX-License-Identifier: Apache-2.0
// Functions that a program finds in the module when it has loaded it (pipeline/io/media.cc).
#include <media_sources.h>

#include "pipeline/io/media.h"
#include "pipeline/media/any_picture.h"
#include "pipeline/media/videos.h"

namespace nightmap::media {
namespace {

class MediaOfModule : public Media {
 public:
  std::unique_ptr<PictureFile> OpenPicture(const std::filesystem::path& path,
                                           std::string_view format) override {
    return OpenAnyPicture(path, format);
  }
  ColorImage ReadVideoFrame(const std::filesystem::path& video, int frame_idx) override {
    return media::ReadVideoFrame(video, frame_idx);
  }
  VideoInfo InspectVideo(const std::filesystem::path& path) override {
    return media::InspectVideo(path);
  }
  std::int64_t NumDecodedVideoFrames() override { return media::NumDecodedVideoFrames(); }
};

}  // namespace
}  // namespace nightmap::media

extern "C" {
const char* NightmapMediaSources();
const char* NightmapMediaSources() { return NIGHTMAP_MEDIA_SOURCES; }
nightmap::Media* NightmapMedia();
nightmap::Media* NightmapMedia() {
  static nightmap::media::MediaOfModule media;
  return &media;
}
}
