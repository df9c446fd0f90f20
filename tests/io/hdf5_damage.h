// SPDX-License-Identifier: Apache-2.0
// Damage that every reader of an HDF5 artifact must refuse.
#pragma once

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap {

// Cut files and missing ones are refused by name. `read` takes a path.
template <typename Read>
void ExpectTruncationIsNamed(const TemporaryFolder& folder,
                             const std::filesystem::path& whole,
                             const Read& read) {
  const std::string bytes = ReadBytes(whole);
  for (const std::size_t size : {std::size_t{0}, bytes.size() / 2, bytes.size() - 1}) {
    folder.Write("cut.h5", bytes.substr(0, size));
    NIGHTMAP_EXPECT_ERROR(DataError, read(folder / "cut.h5"), "cut.h5");
  }
  NIGHTMAP_EXPECT_ERROR(DataError, read(folder / "missing.h5"), "missing.h5");
}

// So are other formats, and versions after the newest that is known.
template <typename Read>
void ExpectOtherFormatsAreRefused(const TemporaryFolder& folder,
                                  const std::string& format,
                                  int newest_version,
                                  const Read& read) {
  Hdf5Writer(folder / "a.h5", "nightmap something", 1, "", "").Close();
  NIGHTMAP_EXPECT_ERROR(
      DataError, read(folder / "a.h5"), "a.h5: field 'format' is 'nightmap something'");
  const int version = newest_version + 1;
  Hdf5Writer(folder / "b.h5", format, version, "", "").Close();
  NIGHTMAP_EXPECT_ERROR(
      DataError, read(folder / "b.h5"), "b.h5: field 'version' is " + std::to_string(version));
}

}  // namespace nightmap
