// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frame_failure.h"

#include <new>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "pipeline/base/input_error.h"
#include "pipeline/base/memory.h"

namespace nightmap {
namespace {

std::string TooLarge(const std::string& path) {
  return fmt::format("{}: needs more than any memory; make the picture smaller", path);
}

}  // namespace

std::string FrameFailure(const std::string& path, const std::function<void()>& work) {
  try {
    work();
    return "";
  } catch (const ArtifactError&) {
    throw;
  } catch (const DataError& error) {
    return error.what();
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) throw OutOfMemory(path);
    return fmt::format("{}: OpenCV: {}; repair or remove the picture", path, error.err);
  } catch (const OutOfMemory&) {
    throw;
  } catch (const std::bad_alloc&) {
    throw OutOfMemory(path);
  } catch (const std::length_error&) {  // a vector larger than any memory
    return TooLarge(path);
  }
}

}  // namespace nightmap
