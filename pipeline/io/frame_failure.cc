// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/frame_failure.h"

#include <new>
#include <opencv2/core.hpp>
#include <stdexcept>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

std::string DoesNotFit(const std::string& path) {
  return fmt::format(
      "{}: does not fit into memory; make the picture smaller or run on fewer threads", path);
}

}  // namespace

std::string FrameFailure(const std::string& path, const std::function<void()>& work) {
  try {
    work();
    return "";
  } catch (const DataError& error) {
    return error.what();
  } catch (const cv::Exception& error) {
    if (error.code == cv::Error::StsNoMem) return DoesNotFit(path);
    return fmt::format("{}: OpenCV: {}; repair or remove the picture", path, error.err);
  } catch (const std::bad_alloc&) {
    return DoesNotFit(path);
  } catch (const std::length_error&) {  // a vector larger than any memory
    return DoesNotFit(path);
  }
}

}  // namespace nightmap
