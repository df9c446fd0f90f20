// SPDX-License-Identifier: Apache-2.0
// Opens HDF5 files for Hdf5Reader.
#pragma once

#include <hdf5.h>

#include <filesystem>

namespace nightmap {

// Opens a file for reading like H5Fopen, but without HDF5's metadata accumulator, which copies past
// its end when a damaged file declares odd sizes (HDF5 1.10.8). Negative if HDF5 cannot open it.
hid_t OpenHdf5ToRead(const std::filesystem::path& path);

}  // namespace nightmap
