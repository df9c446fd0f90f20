// SPDX-License-Identifier: Apache-2.0
// Checks a path before it is opened or written: opening a FIFO would block for ever, and renaming
// over a device would replace it by a file.
#pragma once

#include <filesystem>
#include <string>

namespace nightmap {

// Returns "is a folder", "is a FIFO", "is a socket" or "is a device". Empty for a plain file, for a
// missing path, and for a path that cannot be examined. Follows symbolic links.
std::string WhyNotPlain(const std::filesystem::path& path);

// Throws DataError when the path holds something other than a plain file.
void RequirePlain(const std::filesystem::path& path);

// Throws UsageError when no file can be put at the path: it, or one of its folders, is something
// else. `role` names the path in the message. A symbolic link to a plain file, or to nothing, is
// allowed: the link is replaced, never its target.
void RequirePlaceForFile(const std::filesystem::path& path, const std::string& role);

}  // namespace nightmap
