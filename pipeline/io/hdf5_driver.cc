// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/hdf5_driver.h"

#include "pipeline/io/hdf5_handle.h"

namespace nightmap {
namespace {

// Registers HDF5's driver of plain files without its optional features, one of which is the
// accumulator. HDF5 gives access to a driver's class only through an open file.
hid_t RegisterDriver(const std::filesystem::path& path, hid_t access) {
  H5FD_t* file = H5FDopen(path.c_str(), H5F_ACC_RDONLY, access, HADDR_UNDEF);
  if (!file) return -1;
  static H5FD_class_t driver = *file->cls;
  H5FDclose(file);
  driver.name = "nightmap";
  driver.terminate = nullptr;
  driver.query = [](const H5FD_t*, unsigned long* features) -> herr_t {
    if (features) *features = 0;
    return 0;
  };
  return H5FDregister(&driver);
}

}  // namespace

hid_t OpenHdf5ToRead(const std::filesystem::path& path) {
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_sec2(access);
  static hid_t driver = -1;
  if (driver < 0) driver = RegisterDriver(path, access);
  if (driver < 0 || H5Pset_driver(access, driver, nullptr) < 0) return -1;
  return H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
}

}  // namespace nightmap
