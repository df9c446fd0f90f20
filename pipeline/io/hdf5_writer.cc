// SPDX-License-Identifier: Apache-2.0
// The writer of hdf5_file.h.
#include <cerrno>
#include <cstring>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/hdf5_handle.h"
#include "pipeline/io/hdf5_hashes.h"

namespace nightmap {
namespace {

// Without object times equal content gives equal bytes.
Hdf5Handle UntimedProperties(hid_t property_class) {
  Hdf5Handle properties(H5Pcreate(property_class), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  return Hdf5Handle(H5Pcopy(properties), H5Pclose);
}

constexpr std::size_t kMaxText_bytes = 64 << 10;  // of an attribute that every HDF5 can read

bool WriteStringAttribute(hid_t object, const char* name, const std::string& text) {
  if (text.size() + 1 >= kMaxText_bytes) return false;
  const Hdf5Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, text.size() + 1);
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT),
                             H5Aclose);
  return attribute.Valid() && H5Awrite(attribute, type, text.c_str()) >= 0;
}

void WriteIntAttribute(hid_t file, const char* name, int value) {
  const Hdf5Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Hdf5Handle attribute(
      H5Acreate2(file, name, H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  H5Awrite(attribute, H5T_NATIVE_INT, &value);
}

// The groups on the path of an array. (HDF5's own option for this gives them times.)
void CreateGroupsOf(hid_t file, const std::string& name) {
  const Hdf5Handle properties = UntimedProperties(H5P_GROUP_CREATE);
  for (std::size_t at = name.find('/', 1); at != std::string::npos; at = name.find('/', at + 1)) {
    const std::string group = name.substr(0, at);
    if (H5Lexists(file, group.c_str(), H5P_DEFAULT) > 0) continue;
    const Hdf5Handle created(H5Gcreate2(file, group.c_str(), H5P_DEFAULT, properties, H5P_DEFAULT),
                             H5Gclose);
  }
}

}  // namespace

Hdf5Writer::Hdf5Writer(const std::filesystem::path& path,
                       const std::string& format,
                       int version,
                       const std::string& config,
                       const std::string& units)
    : Hdf5Writer(path) {
  WriteText("format", format);
  WriteIntAttribute(file_, "version", version);
  text_hashes_ += LineOfHdf5Text("version", std::to_string(version));
  WriteText("config", config);
  WriteText("units", units);
}

Hdf5Writer::Hdf5Writer(const std::filesystem::path& path) : path_(path) {
  SilenceHdf5Errors();
  const Hdf5Handle properties = UntimedProperties(H5P_FILE_CREATE);
  const Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  // Since 1.8 headers of objects carry checksums. HDF5 1.10 reads beyond the end of damaged ones
  // without.
  H5Pset_libver_bounds(access, H5F_LIBVER_V18, H5F_LIBVER_V18);
  errno = 0;
  file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, properties, access);
  if (file_ < 0) {
    throw DataError(
        "{}: cannot create: {}; free space on that disk, or make the folder writable, and run "
        "again",
        path.string(),
        std::strerror(errno != 0 ? errno : EIO));
  }
}

Hdf5Writer::~Hdf5Writer() {
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5Writer::Close() {
  WriteText(kHdf5HashName, text_hashes_);
  const herr_t flushed = H5Fflush(file_, H5F_SCOPE_LOCAL);
  const herr_t closed = H5Fclose(file_);
  file_ = -1;
  if (flushed < 0 || closed < 0) {
    throw DataError("{}: cannot write; free space on that disk and run again", path_.string());
  }
}

template <typename T>
void Hdf5Writer::Write(const std::string& name_in_group, const Array<T>& array) {
  const std::string name = group_ + name_in_group;
  if (array.values.size() != array.rows * array.cols) {
    throw DataError("{}: array '{}' has {} values, {} x {} are announced",
                    path_.string(),
                    name,
                    array.values.size(),
                    array.rows,
                    array.cols);
  }
  const hsize_t sizes[2] = {array.rows, array.cols};
  const Hdf5Handle space(H5Screate_simple(2, sizes, nullptr), H5Sclose);
  CreateGroupsOf(file_, name);
  const Hdf5Handle properties = UntimedProperties(H5P_DATASET_CREATE);
  const Hdf5Handle dataset(
      H5Dcreate2(
          file_, name.c_str(), NativeHdf5Type<T>(), space, H5P_DEFAULT, properties, H5P_DEFAULT),
      H5Dclose);
  const std::string_view bytes(reinterpret_cast<const char*>(array.values.data()),
                               array.values.size() * sizeof(T));
  const bool written =
      dataset.Valid() &&
      (array.values.empty() ||
       H5Dwrite(dataset, NativeHdf5Type<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) >=
           0) &&
      WriteStringAttribute(
          dataset, kHdf5HashName, HashOfHdf5Array(name, array.rows, array.cols, bytes));
  if (!written) {
    throw DataError(
        "{}: cannot write array '{}'; free space on that disk and run again", path_.string(), name);
  }
}

void Hdf5Writer::WriteText(const std::string& name, const std::string& text) {
  if (WriteStringAttribute(file_, name.c_str(), text)) {
    text_hashes_ += LineOfHdf5Text(name, text);
    return;
  }
  throw DataError(
      "{}: cannot write text '{}' of {} bytes; shorten it to less than 64 kB, or free space on "
      "that disk, and run again",
      path_.string(),
      name,
      text.size());
}

#define NIGHTMAP_INSTANTIATE(T) \
  template void Hdf5Writer::Write<T>(const std::string&, const Array<T>&);
NIGHTMAP_INSTANTIATE(std::uint8_t)
NIGHTMAP_INSTANTIATE(std::int32_t)
NIGHTMAP_INSTANTIATE(std::uint32_t)
NIGHTMAP_INSTANTIATE(std::int64_t)
NIGHTMAP_INSTANTIATE(float)
NIGHTMAP_INSTANTIATE(double)
#undef NIGHTMAP_INSTANTIATE

}  // namespace nightmap
