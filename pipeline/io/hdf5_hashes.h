// SPDX-License-Identifier: Apache-2.0
// The hashes that Hdf5Writer keeps as attributes `xxh3` of a file and of each of its arrays, so
// that Hdf5Reader tells a file whose bytes changed since (scripts/nightmap_eval/sealed_hdf5.py has
// the same in Python).
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace nightmap {

inline constexpr const char* kHdf5HashName = "xxh3";
inline constexpr std::string_view kHdf5IsNotAsWritten =
    "is not as it was written (its hash differs)";

// Hash of an array with its place in the file and its shape.
std::string HashOfHdf5Array(const std::string& name,
                            std::size_t rows,
                            std::size_t cols,
                            std::string_view bytes);

// The line of a text or of the version, of which the attribute of the file has one each. (Readers
// look for the lines of what they read: HDF5 1.10.8 crashes when it lists the attributes of a
// damaged file.)
std::string LineOfHdf5Text(const std::string& name, const std::string& text);

}  // namespace nightmap
