// SPDX-License-Identifier: Apache-2.0
// The arrays of hdf5_file.h's reader: whole, or left in the file to be read by need.
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>

#include "pipeline/base/input_error.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/hdf5_handle.h"
#include "pipeline/io/hdf5_hashes.h"

namespace nightmap {
namespace {

template <typename T>
bool AllFinite(const std::vector<T>& values) {
  if constexpr (!std::is_floating_point_v<T>) return true;
  bool are_finite = true;
  for (const T value : values) are_finite &= std::isfinite(value);
  return are_finite;
}

// Whether the array is contiguous, uncompressed, and wholly inside this file, as Hdf5Writer writes
// it.
bool HoldsBytes(hid_t dataset, std::uintmax_t num_bytes, std::uintmax_t file_bytes) {
  const Hdf5Handle properties(H5Dget_create_plist(dataset), H5Pclose);
  if (H5Pget_layout(properties) != H5D_CONTIGUOUS || H5Pget_external_count(properties) != 0) {
    return false;
  }
  if (num_bytes == 0) return true;
  const haddr_t begin = H5Dget_offset(dataset);
  return H5Dget_storage_size(dataset) == num_bytes && begin != HADDR_UNDEF && begin <= file_bytes &&
         num_bytes <= file_bytes - begin;
}

// A file descriptor of its own of a file that HDF5 has open.
int DuplicateOf(hid_t file) {
  void* handle = nullptr;
  if (H5Fget_vfd_handle(file, H5P_DEFAULT, &handle) < 0) return -1;
  return dup(*static_cast<int*>(handle));
}

bool ReadAt(int file, std::uint64_t offset, char* to, std::size_t size) {
  while (size > 0) {
    const ssize_t count = pread(file, to, size, static_cast<off_t>(offset));
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    offset += static_cast<std::uint64_t>(count);
    to += count;
    size -= static_cast<std::size_t>(count);
  }
  return true;
}

}  // namespace

struct Hdf5Reader::OpenArray {
  std::string path;
  Hdf5Handle dataset;
  std::size_t rows = 0;
  std::size_t cols = 0;
};

template <typename T>
Hdf5Reader::OpenArray Hdf5Reader::Open(const std::string& name, std::size_t cols) const {
  const std::string path = PathOf(name);
  const hid_t dataset = H5Dopen2(file_, path.c_str(), H5P_DEFAULT);
  OpenArray array{path, {dataset, H5Dclose}};
  if (!array.dataset.Valid()) Fail(name, "is missing");
  const Hdf5Handle type(H5Dget_type(dataset), H5Tclose);
  if (H5Tequal(type, NativeHdf5Type<T>()) <= 0) Fail(name, "has another element type");
  const Hdf5Handle space(H5Dget_space(dataset), H5Sclose);
  hsize_t sizes[2] = {0, 0};
  if (H5Sget_simple_extent_ndims(space) != 2) Fail(name, "is not a matrix");
  H5Sget_simple_extent_dims(space, sizes, nullptr);
  if (cols != 0 && sizes[1] != cols) {
    Fail(name, fmt::format("has {} columns, {} are needed", sizes[1], cols));
  }
  const std::uintmax_t max_values = file_bytes_ / sizeof(T);
  if (sizes[1] > max_values || sizes[0] > max_values / std::max<hsize_t>(sizes[1], 1) ||
      !HoldsBytes(dataset, sizes[0] * sizes[1] * sizeof(T), file_bytes_)) {
    Fail(name,
         fmt::format("declares {} x {} values, which the file of {} bytes does not hold in one "
                     "uncompressed piece",
                     sizes[0],
                     sizes[1],
                     file_bytes_));
  }
  array.rows = sizes[0];
  array.cols = sizes[1];
  return array;
}

template <typename T>
Array<T> Hdf5Reader::Read(const std::string& name, std::size_t cols) const {
  const OpenArray open = Open<T>(name, cols);
  Array<T> array{open.rows, open.cols, std::vector<T>(open.rows * open.cols)};
  if (!array.values.empty() &&
      H5Dread(
          open.dataset, NativeHdf5Type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) <
          0) {
    Fail(name, "cannot be read (truncated file?)");
  }
  const std::string_view bytes(reinterpret_cast<const char*>(array.values.data()),
                               array.values.size() * sizeof(T));
  Demand(ReadTextOf(open.dataset, kHdf5HashName) ==
             HashOfHdf5Array(open.path, array.rows, array.cols, bytes),
         name,
         kHdf5IsNotAsWritten);
  if (!AllFinite(array.values)) Fail(name, "holds NaN or infinity");
  return array;
}

template <typename T>
Hdf5ListInFile<T> Hdf5Reader::LeaveInFile(const std::string& name) const {
  const OpenArray open = Open<T>(name, 1);
  const std::uint64_t offset = open.rows == 0 ? 0 : H5Dget_offset(open.dataset);
  const int file = DuplicateOf(file_);
  if (file < 0) Fail(name, "cannot be read");
  return {file, path_, open.path, offset, open.rows};
}

template <typename T>
Hdf5ListInFile<T>::Hdf5ListInFile(
    int file, std::filesystem::path path, std::string name, std::uint64_t offset, std::size_t size)
    : file_(new int(file),
            [](const int* descriptor) {
              close(*descriptor);
              delete descriptor;
            }),
      path_(std::move(path)),
      name_(std::move(name)),
      offset_(offset),
      size_(size) {}

template <typename T>
void Hdf5ListInFile<T>::Read(std::size_t begin, std::size_t end, std::vector<T>* values) const {
  if (begin > end || end > size_) Fail(fmt::format("has no elements {} to {}", begin, end));
  values->resize(end - begin);
  if (!ReadAt(*file_,
              offset_ + begin * sizeof(T),
              reinterpret_cast<char*>(values->data()),
              values->size() * sizeof(T))) {
    Fail("cannot be read (truncated file?)");
  }
  if (!AllFinite(*values)) Fail("holds NaN or infinity");
}

template <typename T>
void Hdf5ListInFile<T>::Fail(std::string_view why) const {
  throw ArtifactError(
      "{}: field '{}' {}; delete the file and run make", path_.string(), name_, why);
}

#define NIGHTMAP_INSTANTIATE(T)                                                    \
  template Array<T> Hdf5Reader::Read<T>(const std::string&, std::size_t) const;    \
  template Hdf5ListInFile<T> Hdf5Reader::LeaveInFile<T>(const std::string&) const; \
  template class Hdf5ListInFile<T>;
NIGHTMAP_INSTANTIATE(std::uint8_t)
NIGHTMAP_INSTANTIATE(std::int32_t)
NIGHTMAP_INSTANTIATE(std::uint32_t)
NIGHTMAP_INSTANTIATE(std::int64_t)
NIGHTMAP_INSTANTIATE(float)
NIGHTMAP_INSTANTIATE(double)
#undef NIGHTMAP_INSTANTIATE

}  // namespace nightmap
