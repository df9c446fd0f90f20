// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frame_failure.h"

#include <cstddef>
#include <new>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap {
namespace {

TEST(FrameFailure, IsEmptyWhenTheWorkIsDone) {
  bool is_done = false;
  EXPECT_EQ(FrameFailure("a.png", [&] { is_done = true; }), "");
  EXPECT_TRUE(is_done);
}

TEST(FrameFailure, IsWhatTheDataErrorSays) {
  EXPECT_EQ(FrameFailure("a.png", [] { throw DataError("b.png: truncated"); }), "b.png: truncated");
}

TEST(FrameFailure, NamesThePictureThatOpenCvRefuses) {
  const auto resize_nothing = [] {
    cv::Mat resized;
    cv::resize(cv::Mat(), resized, {10, 10});
  };
  EXPECT_THAT(FrameFailure("a.png", resize_nothing), testing::StartsWith("a.png: OpenCV: "));
}

TEST(FrameFailure, NamesThePictureThatDoesNotFitIntoMemory) {
  constexpr std::size_t kQuarterOfAllAddresses = std::size_t{1} << 62;
  const std::vector<std::function<void()>> works = {
      [] { throw std::bad_alloc(); },
      [] { CV_Error(cv::Error::StsNoMem, "failed to allocate"); },
      [&] { std::vector<double> pixels(kQuarterOfAllAddresses); }};
  for (const auto& work : works) {
    EXPECT_THAT(FrameFailure("a.png", work),
                testing::StartsWith("a.png: does not fit into memory"));
  }
}

TEST(FrameFailure, ADefectOfTheProgramPasses) {
  const auto defect = [] {
    return FrameFailure("a.png", [] { throw std::logic_error("defect"); });
  };
  EXPECT_THROW((void)defect(), std::logic_error);
}

}  // namespace
}  // namespace nightmap
