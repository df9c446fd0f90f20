// SPDX-License-Identifier: Apache-2.0
// Work on one frame or picture whose failure is its own, not the stage's.
#pragma once

#include <functional>
#include <string>

namespace nightmap {

// Does the work; returns why it failed, empty when it did not. Caught are DataError, what OpenCV
// throws, and too little memory; anything else is a defect of the program and passes. `path` names
// the picture where the failure does not.
[[nodiscard]] std::string FrameFailure(const std::string& path, const std::function<void()>& work);

}  // namespace nightmap
