// SPDX-License-Identifier: Apache-2.0
// Checks that look at a path before it is opened or written: a program that opens a FIFO waits for
// ever, and one that renames over a device makes a file of it.
#pragma once

#include <filesystem>
#include <string>

namespace nightmap {

// "is a folder", "is a FIFO", "is a socket" or "is a device". Empty for a plain file, for nothing
// at all, and for what cannot be looked at. Symbolic links are followed.
std::string WhyNotPlain(const std::filesystem::path& path);

// Throws DataError when something else than a plain file is at the path.
void RequirePlain(const std::filesystem::path& path);

// Throws UsageError when no file can be put at the path: something else than a plain file is there,
// or at the place of one of its folders. `role` names the path in the message. A symbolic link to a
// plain file, or to nothing, may be there: the link is replaced, and never what it points at.
void RequirePlaceForFile(const std::filesystem::path& path, const std::string& role);

}  // namespace nightmap
