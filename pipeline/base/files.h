// SPDX-License-Identifier: Apache-2.0
// Reads, writes and hashes whole files.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace nightmap {

// Returns the whole file as bytes. Throws DataError naming the file; also for a folder, a FIFO, a
// socket or a device, which it never opens.
std::string ReadFile(const std::filesystem::path& path);

// XXH3 64-bit hash of a file's bytes, `begin` and all after it, as 16 hex digits. Throws DataError
// as ReadFile does.
std::string HashFile(const std::filesystem::path& path, std::int64_t begin = 0);
std::string HashBytes(std::string_view bytes);

// Writes bytes to a path. Not atomic: meant for the temporary paths of OutputSet. Throws DataError
// naming the file and the system's reason, such as a full disk.
void WriteFile(const std::filesystem::path& path, std::string_view bytes);

}  // namespace nightmap
