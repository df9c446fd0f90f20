// SPDX-License-Identifier: Apache-2.0
// Puts the files of a run into the message of code that knows no file.
#pragma once

#include <string>
#include <vector>

#include "pipeline/base/input_error.h"

namespace nightmap {

// The error's text on those of the files `texts`, NAME=PATH, that are its inputs, and the remedy.
std::string NameFiles(const InputError& error, const std::vector<std::string>& texts);

}  // namespace nightmap
