// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frame_failure.h"

#include <cstddef>
#include <new>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <vector>

#include "pipeline/base/input_error.h"
#include "pipeline/base/memory.h"
#include "tests/test_data.h"

namespace nightmap::frame_failure_test {

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

TEST(FrameFailure, NamesThePictureThatNeedsMoreThanAnyMemory) {
  constexpr std::size_t kQuarterOfAllAddresses = std::size_t{1} << 62;
  EXPECT_THAT(FrameFailure("a.png", [&] { std::vector<double> pixels(kQuarterOfAllAddresses); }),
              testing::StartsWith("a.png: needs more than any memory"));
}

TEST(FrameFailure, MemoryThatRunsOutIsNoFailureOfTheFrame) {
  const std::vector<std::function<void()>> works = {
      [] { throw std::bad_alloc(); },
      [] { throw OutOfMemory("a.png"); },
      [] { CV_Error(cv::Error::StsNoMem, "failed to allocate"); }};
  for (const auto& work : works) {
    try {
      std::ignore = FrameFailure("a.png", work);
      ADD_FAILURE() << "memory that ran out was counted as a bad frame";
    } catch (const OutOfMemory& error) {
      EXPECT_STREQ(error.what(), "out of memory at a.png");
    }
  }
}

TEST(FrameFailure, ADamagedArtifactPasses) {
  const auto run = [](const std::function<void()>& work) { return FrameFailure("a.png", work); };
  EXPECT_THROW((void)run([] { throw ArtifactError("masks.h5: truncated"); }), ArtifactError);
  EXPECT_THROW((void)run([] { throw InputError({{"masks"}}, "truncated"); }), InputError);
}

TEST(FrameFailure, ADefectOfTheProgramPasses) {
  const auto defect = [] {
    return FrameFailure("a.png", [] { throw std::logic_error("defect"); });
  };
  EXPECT_THROW((void)defect(), std::logic_error);
}

}  // namespace nightmap::frame_failure_test
