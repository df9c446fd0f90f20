// SPDX-License-Identifier: Apache-2.0
#include "pipeline/media/videos.h"

#include <atomic>
#include <cmath>
#include <condition_variable>
#include <list>
#include <memory>
#include <mutex>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <set>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/median.h"
#include "pipeline/base/memory.h"

namespace nightmap::media {
namespace {

// A frame of 8K video has 33 million pixels, and the decoder keeps several.
constexpr double kMaxVideoFrame_px = 1e8;

cv::VideoCapture OpenVideo(const std::filesystem::path& video) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(video, ignored)) {  // opening a pipe would block
    const bool is_there = std::filesystem::exists(video, ignored);
    throw DataError("{}: {}", video.string(), is_there ? "not a file" : "no such video file");
  }
  cv::VideoCapture capture;
  const MemoryWatch memory;
  try {
    capture.open(video.string(), cv::CAP_FFMPEG);
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw OutOfMemory(video.string());
    throw DataError("{}: {}", video.string(), error.what());
  }
  if (!capture.isOpened()) memory.Check(video.string());
  if (!capture.isOpened()) throw DataError("{}: not a readable video", video.string());
  // Before its size is asked for, which would be the turned one. Depth pictures are never turned.
  if (!capture.set(cv::CAP_PROP_ORIENTATION_AUTO, 0)) {
    throw DataError("{}: the decoder cannot leave pictures unturned", video.string());
  }
  const double width = capture.get(cv::CAP_PROP_FRAME_WIDTH);
  const double height = capture.get(cv::CAP_PROP_FRAME_HEIGHT);
  if (width < 1 || height < 1 || width * height > kMaxVideoFrame_px) {
    throw DataError("{}: header says {} x {} pixels", video.string(), width, height);
  }
  return capture;
}

std::atomic<std::int64_t> num_decoded{0};

// One open video. With some codecs, seeking in compressed video lands on the wrong frame, so frames
// are only ever reached by reading forward.
class ForwardReader {
 public:
  explicit ForwardReader(const std::filesystem::path& video)
      : video_(video), capture_(OpenVideo(video)) {}

  // Whether the frame is still ahead, or was just read.
  bool Reaches(const std::filesystem::path& video, int frame_idx) const {
    return video == video_ && position_ <= frame_idx;
  }
  int Position() const { return position_; }

  ColorImage Read(int frame_idx) {
    const MemoryWatch memory;
    for (; position_ < frame_idx; ++position_, ++num_decoded) {
      if (capture_.grab()) continue;
      memory.Check(video_.string());
      throw DataError(
          "{}: has {} readable frames, no frame {}", video_.string(), position_ + 1, frame_idx);
    }
    cv::Mat bgr;
    if (!capture_.retrieve(bgr) || bgr.type() != CV_8UC3) {
      memory.Check(video_.string());
      throw DataError("{}: frame {} cannot be decoded", video_.string(), frame_idx);
    }
    ColorImage image{bgr.cols, bgr.rows, 3, {}};
    image.pixels.resize(static_cast<std::size_t>(bgr.total()) * 3);
    cv::Mat rgb(bgr.rows, bgr.cols, CV_8UC3, image.pixels.data());
    cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
    return image;
  }

 private:
  std::filesystem::path video_;
  cv::VideoCapture capture_;
  int position_ = -1;  // index of the last decoded frame
};

// A mutex that the waiting thread with the lowest request gets first.
class OrderedMutex {
 public:
  using Request = std::pair<std::filesystem::path, int>;

  void Lock(const Request& request) {
    std::unique_lock lock(mutex_);
    const auto place = waiting_.insert(request);
    released_.wait(lock, [&] { return !is_held_ && place == waiting_.begin(); });
    waiting_.erase(place);
    is_held_ = true;
  }
  void Unlock() {
    const std::lock_guard lock(mutex_);
    is_held_ = false;
    released_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable released_;
  std::multiset<Request> waiting_;
  bool is_held_ = false;
};

// Holds an OrderedMutex for its scope.
class Turn {
 public:
  Turn(OrderedMutex* mutex, const OrderedMutex::Request& request) : mutex_(mutex) {
    mutex_->Lock(request);
  }
  ~Turn() { mutex_->Unlock(); }
  Turn(const Turn&) = delete;
  Turn& operator=(const Turn&) = delete;

 private:
  OrderedMutex* mutex_;
};

// The videos that this process has open. Threads that work through a video in order share one
// reader, which decodes each frame once; several readers would each decode all of them. A frame
// that all readers have passed opens another one.
class ReaderPool {
 public:
  ColorImage Read(const std::filesystem::path& video, int frame_idx) {
    const Turn turn(&mutex_, {video, frame_idx});
    auto reader = Take(video, frame_idx);
    ColorImage image = reader->Read(frame_idx);  // a reader that fails is closed
    readers_.push_front(std::move(reader));
    if (readers_.size() > kMaxReaders) readers_.pop_back();
    return image;
  }

 private:
  static constexpr std::size_t kMaxReaders = 4;

  // The reader with the fewest frames left to the requested one.
  std::unique_ptr<ForwardReader> Take(const std::filesystem::path& video, int frame_idx) {
    auto nearest = readers_.end();
    for (auto reader = readers_.begin(); reader != readers_.end(); ++reader) {
      if (!(*reader)->Reaches(video, frame_idx)) continue;
      if (nearest == readers_.end() || (*reader)->Position() > (*nearest)->Position()) {
        nearest = reader;
      }
    }
    if (nearest == readers_.end()) return std::make_unique<ForwardReader>(video);
    auto reader = std::move(*nearest);
    readers_.erase(nearest);
    return reader;
  }

  OrderedMutex mutex_;
  std::list<std::unique_ptr<ForwardReader>> readers_;  // last used first
};

// Frames that the decoder still held at the end of the file have time 0 in OpenCV (4.6): as many as
// it reorders. They follow at the usual step.
void FillLastTimes(std::vector<std::int64_t>* times_ns) {
  std::size_t num_known = times_ns->size();
  while (num_known > 1 && (*times_ns)[num_known - 1] == 0) --num_known;
  if (num_known < 2) return;
  std::vector<std::int64_t> steps_ns;
  for (std::size_t i = 1; i < num_known; ++i) {
    steps_ns.push_back((*times_ns)[i] - (*times_ns)[i - 1]);
  }
  const std::int64_t step_ns = Median(std::move(steps_ns));
  for (std::size_t i = num_known; i < times_ns->size(); ++i) {
    (*times_ns)[i] = (*times_ns)[i - 1] + step_ns;
  }
}

}  // namespace

ColorImage ReadVideoFrame(const std::filesystem::path& video, int frame_idx) {
  static ReaderPool pool;
  return pool.Read(video, frame_idx);
}

std::int64_t NumDecodedVideoFrames() { return num_decoded; }

VideoInfo InspectVideo(const std::filesystem::path& path) {
  cv::VideoCapture capture = OpenVideo(path);
  VideoInfo info;
  info.width = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_WIDTH));
  info.height = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_HEIGHT));
  info.frame_rate_hz = capture.get(cv::CAP_PROP_FPS);
  const MemoryWatch memory;
  while (capture.grab()) {
    info.times_ns.push_back(std::llround(1e6 * capture.get(cv::CAP_PROP_POS_MSEC)));
  }
  memory.Check(path.string());
  info.num_frames = static_cast<int>(info.times_ns.size());
  FillLastTimes(&info.times_ns);
  const std::int64_t first_ns = info.times_ns.empty() ? 0 : info.times_ns.front();
  for (std::int64_t& time_ns : info.times_ns) time_ns -= first_ns;
  return info;
}

}  // namespace nightmap::media
