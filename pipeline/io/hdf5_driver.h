// SPDX-License-Identifier: Apache-2.0
// How Hdf5Reader has HDF5 read a file.
#pragma once

#include <hdf5.h>

#include <filesystem>

namespace nightmap {

// Opens a file to be read, as H5Fopen does but without HDF5's accumulator of metadata, which copies
// past its end when a damaged file declares odd sizes (HDF5 1.10.8). Negative: HDF5 cannot open it.
hid_t OpenHdf5ToRead(const std::filesystem::path& path);

}  // namespace nightmap
