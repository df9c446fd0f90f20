// SPDX-License-Identifier: Apache-2.0
// Whole-file reading, hashing, and the atomic commit of a stage's outputs.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace nightmap {

// The whole file as bytes. Throws DataError naming the file, also when it is a folder, a FIFO, a
// socket or a device, which are never opened.
std::string ReadFile(const std::filesystem::path& path);

// XXH3 64-bit of the bytes of a file, as 16 hex digits. Throws DataError as ReadFile does.
std::string HashFile(const std::filesystem::path& path);
std::string HashBytes(std::string_view bytes);

// Writes bytes to a path (not atomically: for the temporary paths of OutputSet). Throws DataError
// naming the file and the system's reason, a full disk included.
void WriteFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace nightmap
