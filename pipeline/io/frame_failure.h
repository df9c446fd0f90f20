// SPDX-License-Identifier: Apache-2.0
// Contains the failure of work on one frame or picture, so that the stage goes on.
#pragma once

#include <functional>
#include <string>

namespace nightmap {

// Does the work and returns why it failed; empty when it did not. Catches DataError, OpenCV's
// exceptions and sizes beyond any memory; any other exception is a defect of the program and passes
// through. So does an ArtifactError (a file of masks, say), which is no fault of the picture.
// Throws OutOfMemory when memory ran out: the frame is good, and a run with more memory uses it. A
// picture that is itself too large is refused by its header (image_io.h). `path` names the picture
// where the failure does not.
[[nodiscard]] std::string FrameFailure(const std::string& path, const std::function<void()>& work);

}  // namespace nightmap
