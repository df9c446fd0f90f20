// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/hdf5_hashes.h"

#include <fmt/format.h>

#include "pipeline/base/files.h"

namespace nightmap {

std::string HashOfHdf5Array(const std::string& name,
                            std::size_t rows,
                            std::size_t cols,
                            std::string_view bytes) {
  return HashBytes(fmt::format("{} {} {} {}", name, rows, cols, HashBytes(bytes)));
}

std::string LineOfHdf5Text(const std::string& name, const std::string& text) {
  return fmt::format("{} {}\n", name, HashBytes(text));
}

}  // namespace nightmap
