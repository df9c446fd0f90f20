// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/hdf5_file.h"

#include <hdf5.h>

#include <cmath>
#include <type_traits>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

// Closes an HDF5 handle at the end of its scope.
class Handle {
 public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  ~Handle() {
    if (id_ >= 0) close_(id_);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id_; }
  bool Valid() const { return id_ >= 0; }

 private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

template <typename T>
hid_t NativeType() {
  if constexpr (std::is_same_v<T, std::uint8_t>) return H5T_NATIVE_UINT8;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_NATIVE_INT32;
  if constexpr (std::is_same_v<T, std::uint32_t>) return H5T_NATIVE_UINT32;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_NATIVE_INT64;
  if constexpr (std::is_same_v<T, float>) return H5T_NATIVE_FLOAT;
  if constexpr (std::is_same_v<T, double>) return H5T_NATIVE_DOUBLE;
}

// The library's own error stack would print to stderr; our messages name file and field instead.
void SilenceErrorStack() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

// Without object times equal content gives equal bytes.
Handle UntimedProperties(hid_t property_class) {
  Handle properties(H5Pcreate(property_class), H5Pclose);
  H5Pset_obj_track_times(properties, false);
  return Handle(H5Pcopy(properties), H5Pclose);
}

// HDF5 has no room for attributes of 64 kB and more.
bool WriteStringAttribute(hid_t file, const char* name, const std::string& text) {
  const Handle type(H5Tcopy(H5T_C_S1), H5Tclose);
  H5Tset_size(type, text.size() + 1);
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(file, name, type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  return attribute.Valid() && H5Awrite(attribute, type, text.c_str()) >= 0;
}

std::string ReadStringAttribute(hid_t file, const char* name) {
  const Handle attribute(H5Aopen(file, name, H5P_DEFAULT), H5Aclose);
  if (!attribute.Valid()) return "";
  const Handle type(H5Aget_type(attribute), H5Tclose);
  if (H5Tget_class(type) != H5T_STRING) return "";
  std::string text(H5Tget_size(type), '\0');
  H5Aread(attribute, type, text.data());
  return text.c_str();
}

void WriteIntAttribute(hid_t file, const char* name, int value) {
  const Handle space(H5Screate(H5S_SCALAR), H5Sclose);
  const Handle attribute(H5Acreate2(file, name, H5T_NATIVE_INT, space, H5P_DEFAULT, H5P_DEFAULT),
                         H5Aclose);
  H5Awrite(attribute, H5T_NATIVE_INT, &value);
}

int ReadIntAttribute(hid_t file, const char* name) {
  const Handle attribute(H5Aopen(file, name, H5P_DEFAULT), H5Aclose);
  int value = -1;
  if (attribute.Valid()) H5Aread(attribute, H5T_NATIVE_INT, &value);
  return value;
}

template <typename T>
bool AllFinite(const std::vector<T>& values) {
  if constexpr (std::is_floating_point_v<T>) {
    for (const T value : values) {
      if (!std::isfinite(value)) return false;
    }
  }
  return true;
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
  WriteText("config", config);
  WriteText("units", units);
}

Hdf5Writer::Hdf5Writer(const std::filesystem::path& path) : path_(path) {
  SilenceErrorStack();
  const Handle properties = UntimedProperties(H5P_FILE_CREATE);
  file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, properties, H5P_DEFAULT);
  if (file_ < 0) throw DataError("{}: cannot create; is the folder writable?", path.string());
}

Hdf5Writer::~Hdf5Writer() {
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5Writer::Close() {
  const herr_t flushed = H5Fflush(file_, H5F_SCOPE_LOCAL);
  const herr_t closed = H5Fclose(file_);
  file_ = -1;
  if (flushed < 0 || closed < 0) {
    throw DataError("{}: cannot write; free space on that disk and run again", path_.string());
  }
}

template <typename T>
void Hdf5Writer::Write(const std::string& name, const Array<T>& array) {
  if (array.values.size() != array.rows * array.cols) {
    throw DataError("{}: array '{}' has {} values, {} x {} are announced",
                    path_.string(),
                    name,
                    array.values.size(),
                    array.rows,
                    array.cols);
  }
  const hsize_t sizes[2] = {array.rows, array.cols};
  const Handle space(H5Screate_simple(2, sizes, nullptr), H5Sclose);
  const Handle links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  const Handle properties = UntimedProperties(H5P_DATASET_CREATE);
  const Handle dataset(
      H5Dcreate2(file_, name.c_str(), NativeType<T>(), space, links, properties, H5P_DEFAULT),
      H5Dclose);
  const bool written =
      dataset.Valid() &&
      (array.values.empty() ||
       H5Dwrite(dataset, NativeType<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) >= 0);
  if (!written) {
    throw DataError(
        "{}: cannot write array '{}'; free space on that disk and run again", path_.string(), name);
  }
}

Hdf5Reader::Hdf5Reader(const std::filesystem::path& path, const std::string& format, int version)
    : path_(path) {
  SilenceErrorStack();
  file_ = H5Fopen(path.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  if (file_ < 0) {
    throw DataError("{}: not a readable HDF5 file (missing or truncated); delete it and run make",
                    path.string());
  }
  const std::string found_format = ReadStringAttribute(file_, "format");
  const int found_version = ReadIntAttribute(file_, "version");
  if (found_format == format && found_version >= 1 && found_version <= version) return;
  H5Fclose(file_);
  file_ = -1;
  if (found_format != format) {
    throw DataError(
        "{}: field 'format' is '{}', '{}' is needed", path.string(), found_format, format);
  }
  throw DataError(
      "{}: field 'version' is {}, this program reads up to {}; update nightmap or "
      "delete the file and run make",
      path.string(),
      found_version,
      version);
}

Hdf5Reader::~Hdf5Reader() {
  if (file_ >= 0) H5Fclose(file_);
}

void Hdf5Writer::WriteText(const std::string& name, const std::string& text) {
  if (WriteStringAttribute(file_, name.c_str(), text)) return;
  throw DataError(
      "{}: cannot write text '{}' of {} bytes; shorten it to less than 64 kB, or free space on "
      "that "
      "disk, and run again",
      path_.string(),
      name,
      text.size());
}

std::string Hdf5Reader::ReadText(const std::string& name) const {
  if (H5Aexists(file_, name.c_str()) <= 0) Fail(name, "is missing");
  return ReadStringAttribute(file_, name.c_str());
}

bool Hdf5Reader::Has(const std::string& name) const {
  return H5Lexists(file_, name.c_str(), H5P_DEFAULT) > 0;
}

void Hdf5Reader::Fail(std::string_view field, std::string_view why) const {
  throw DataError("{}: field '{}' {}; delete the file and run make", path_.string(), field, why);
}

template <typename T>
Array<T> Hdf5Reader::Read(const std::string& name, std::size_t cols) const {
  const Handle dataset(H5Dopen2(file_, name.c_str(), H5P_DEFAULT), H5Dclose);
  if (!dataset.Valid()) Fail(name, "is missing");
  const Handle type(H5Dget_type(dataset), H5Tclose);
  if (H5Tequal(type, NativeType<T>()) <= 0) Fail(name, "has another element type");
  const Handle space(H5Dget_space(dataset), H5Sclose);
  hsize_t sizes[2] = {0, 0};
  if (H5Sget_simple_extent_ndims(space) != 2) Fail(name, "is not a matrix");
  H5Sget_simple_extent_dims(space, sizes, nullptr);
  if (cols != 0 && sizes[1] != cols) {
    Fail(name, fmt::format("has {} columns, {} are needed", sizes[1], cols));
  }
  Array<T> array{sizes[0], sizes[1], std::vector<T>(sizes[0] * sizes[1])};
  if (!array.values.empty() &&
      H5Dread(dataset, NativeType<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, array.values.data()) < 0) {
    Fail(name, "cannot be read (truncated file?)");
  }
  if (!AllFinite(array.values)) Fail(name, "holds NaN or infinity");
  return array;
}

#define NIGHTMAP_INSTANTIATE(T)                                            \
  template void Hdf5Writer::Write<T>(const std::string&, const Array<T>&); \
  template Array<T> Hdf5Reader::Read<T>(const std::string&, std::size_t) const;
NIGHTMAP_INSTANTIATE(std::uint8_t)
NIGHTMAP_INSTANTIATE(std::int32_t)
NIGHTMAP_INSTANTIATE(std::uint32_t)
NIGHTMAP_INSTANTIATE(std::int64_t)
NIGHTMAP_INSTANTIATE(float)
NIGHTMAP_INSTANTIATE(double)
#undef NIGHTMAP_INSTANTIATE

}  // namespace nightmap
