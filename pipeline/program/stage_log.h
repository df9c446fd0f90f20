// SPDX-License-Identifier: Apache-2.0
// The log of a stage: lines `time level stage: message` on standard error.
#pragma once

#include <string>

namespace nightmap {

// Sets spdlog's default logger. Messages show what a user's text could tell a terminal escaped.
void SetUpLog(const std::string& stage, const std::string& level);

}  // namespace nightmap
