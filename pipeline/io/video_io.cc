// SPDX-License-Identifier: Apache-2.0
// Frames of video files, for image_io.h.
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/image_io.h"

namespace nightmap {
namespace {

cv::VideoCapture OpenVideo(const std::filesystem::path& video) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(video, ignored)) {
    throw DataError("{}: no such video file", video.string());
  }
  cv::VideoCapture capture;
  try {
    capture.open(video.string(), cv::CAP_FFMPEG);
  } catch (const cv::Exception& error) {
    throw DataError("{}: {}", video.string(), error.what());
  }
  if (!capture.isOpened()) throw DataError("{}: not a readable video", video.string());
  return capture;
}

// Seeking in compressed video lands on the wrong frame with some codecs, so frames are only ever
// reached by going forward; in order, as stages read them, each is decoded once.
class SequentialReader {
 public:
  ColorImage Read(const std::filesystem::path& video, int frame_idx) {
    if (video != video_ || frame_idx < next_idx_) {
      video_.clear();
      capture_ = OpenVideo(video);
      video_ = video;
      next_idx_ = 0;
    }
    for (; next_idx_ <= frame_idx; ++next_idx_) {
      if (capture_.grab()) continue;
      const int num_frames = next_idx_;
      video_.clear();
      throw DataError(
          "{}: has {} readable frames, no frame {}", video.string(), num_frames, frame_idx);
    }
    cv::Mat bgr;
    if (!capture_.retrieve(bgr) || bgr.type() != CV_8UC3) {
      throw DataError("{}: frame {} cannot be decoded", video.string(), frame_idx);
    }
    ColorImage image{bgr.cols, bgr.rows, 3, {}};
    image.pixels.resize(static_cast<std::size_t>(bgr.total()) * 3);
    cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.pixels.data());
    cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
    return image;
  }

 private:
  cv::VideoCapture capture_;
  std::filesystem::path video_;
  int next_idx_ = 0;
};

}  // namespace

ColorImage ReadVideoFrame(const std::filesystem::path& video, int frame_idx) {
  thread_local SequentialReader reader;
  return reader.Read(video, frame_idx);
}

VideoInfo InspectVideo(const std::filesystem::path& path) {
  cv::VideoCapture capture = OpenVideo(path);
  VideoInfo info;
  info.width = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_WIDTH));
  info.height = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_HEIGHT));
  info.frame_rate_hz = capture.get(cv::CAP_PROP_FPS);
  while (capture.grab()) ++info.num_frames;
  return info;
}

std::filesystem::path VideoFramePath(const std::filesystem::path& video, int frame_idx) {
  return video.string() + '#' + std::to_string(frame_idx);
}

std::optional<std::pair<std::filesystem::path, int>> SplitVideoFramePath(
    const std::filesystem::path& path) {
  const std::string text = path.string();
  const std::size_t hash = text.rfind('#');
  if (hash == std::string::npos) return std::nullopt;
  const auto frame_idx = ParseInteger(std::string_view(text).substr(hash + 1));
  if (!frame_idx || *frame_idx < 0 || *frame_idx > 1'000'000'000) return std::nullopt;
  return std::pair(std::filesystem::path(text.substr(0, hash)), static_cast<int>(*frame_idx));
}

}  // namespace nightmap
