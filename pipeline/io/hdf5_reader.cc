// SPDX-License-Identifier: Apache-2.0
// The reader of hdf5_file.h. Checks every declaration of a file against its content before use:
// HDF5 itself reads a text or a number of another type past the end of its target, and allocates
// memory for any declared size.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "pipeline/base/input_error.h"
#include "pipeline/io/hdf5_driver.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/hdf5_handle.h"
#include "pipeline/io/hdf5_hashes.h"

namespace nightmap {
namespace {

constexpr std::size_t kMaxTextBytes = 64 * 1024;  // longest text of Hdf5Writer and its final zero

// No zeros or control characters except tab and line breaks, so that it prints unchanged.
bool IsPlainUtf8(const std::string& text) {
  const auto is_control = [](char c) {
    return static_cast<unsigned char>(c) < ' ' && c != '\t' && c != '\n' && c != '\r';
  };
  if (std::ranges::any_of(text, is_control)) return false;
  try {
    (void)nlohmann::json(text).dump();
    return true;
  } catch (const nlohmann::json::type_error&) {
    return false;
  }
}

bool IsScalar(hid_t attribute) {
  const Hdf5Handle space(H5Aget_space(attribute), H5Sclose);
  return H5Sget_simple_extent_type(space) == H5S_SCALAR;
}

}  // namespace

Hdf5Reader::Hdf5Reader(const std::filesystem::path& path) : path_(path) {
  SilenceHdf5Errors();
  file_ = OpenHdf5ToRead(path);
  if (file_ < 0) {
    memory_.Check(path.string());
    throw ArtifactError(
        "{}: not a readable HDF5 file (missing or truncated); delete it and run make",
        path.string());
  }
  file_bytes_ = std::filesystem::file_size(path);
}

Hdf5Reader::Hdf5Reader(const std::filesystem::path& path, const std::string& format, int version)
    : Hdf5Reader(path) {
  const std::string found_format = ReadText("format");
  if (found_format != format) {
    throw ArtifactError(
        "{}: field 'format' is '{}', '{}' is needed", path.string(), found_format, format);
  }
  const std::int64_t found_version = ReadInteger("version");
  if (found_version < 1 || found_version > version) {
    throw ArtifactError(
        "{}: field 'version' is {}, this program reads up to {}; update nightmap or "
        "delete the file and run make",
        path.string(),
        found_version,
        version);
  }
  CheckText("version", std::to_string(found_version));
}

Hdf5Reader::~Hdf5Reader() {
  if (file_ >= 0) H5Fclose(file_);
}

template <typename T>
std::vector<std::size_t> Hdf5Reader::ReadOffsets(const std::string& name,
                                                 std::optional<std::size_t> count,
                                                 std::optional<std::size_t> end) const {
  const auto values = ReadList<T>(name);
  Demand(count ? values.size() == *count + 1 : !values.empty(), name);
  Demand(std::ranges::is_sorted(values), name, "decreases");
  const auto last = static_cast<std::size_t>(values.back());
  Demand(values.front() == 0 && last == end.value_or(last), name);
  return {values.begin(), values.end()};
}

std::string Hdf5Reader::ReadText(const std::string& name) const {
  std::string text = ReadTextOf(file_, name);
  CheckText(name, text);
  return text;
}

std::string Hdf5Reader::ReadTextOf(std::int64_t object, const std::string& name) const {
  if (H5Aexists(object, name.c_str()) <= 0) {
    Fail(name,
         name == kHdf5HashName ? "is missing: an older nightmap or another program wrote the file"
                               : "is missing");
  }
  const Hdf5Handle attribute(H5Aopen(object, name.c_str(), H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
  const std::size_t size = H5Tget_size(type);
  if (H5Tget_class(type) != H5T_STRING || H5Tis_variable_str(type) != 0 || !IsScalar(attribute) ||
      size > kMaxTextBytes) {
    Fail(name, "is not one text of fixed length below 64 kB");
  }
  std::string text(size, '\0');
  if (H5Aread(attribute, type, text.data()) < 0) Fail(name, "cannot be read (truncated file?)");
  text.erase(text.find_last_not_of('\0') + 1);  // removes the padding to the fixed length
  if (!IsPlainUtf8(text)) Fail(name, "is not a text in UTF-8");
  return text;
}

std::int64_t Hdf5Reader::ReadInteger(const std::string& name) const {
  if (H5Aexists(file_, name.c_str()) <= 0) Fail(name, "is missing");
  const Hdf5Handle attribute(H5Aopen(file_, name.c_str(), H5P_DEFAULT), H5Aclose);
  const Hdf5Handle type(H5Aget_type(attribute), H5Tclose);
  std::int64_t value = 0;
  if (H5Tget_class(type) != H5T_INTEGER || H5Tget_size(type) > sizeof(value) ||
      !IsScalar(attribute) || H5Aread(attribute, H5T_NATIVE_INT64, &value) < 0) {
    Fail(name, "is not one integer");
  }
  return value;
}

void Hdf5Reader::CheckText(const std::string& name, const std::string& text) const {
  const std::string lines = '\n' + ReadTextOf(file_, kHdf5HashName);
  Demand(lines.find('\n' + LineOfHdf5Text(name, text)) != std::string::npos,
         name,
         kHdf5IsNotAsWritten);
}

bool Hdf5Reader::Has(const std::string& name) const {
  return H5Lexists(file_, (group_ + name).c_str(), H5P_DEFAULT) > 0;
}

void Hdf5Reader::Fail(std::string_view field, std::string_view why) const {
  memory_.Check(path_.string());
  throw ArtifactError(
      "{}: field '{}{}' {}; delete the file and run make", path_.string(), group_, field, why);
}

void Hdf5Reader::DemandIndices(const std::vector<std::vector<int>>& lists,
                               std::size_t size,
                               std::string_view field) const {
  for (const std::vector<int>& list : lists) {
    for (const int index : list) {
      if (index >= 0 && static_cast<std::size_t>(index) < size) continue;
      Fail(field, fmt::format("has index {} out of range", index));
    }
  }
}

void Hdf5Reader::FailRow(std::string_view field, std::size_t row, std::string_view what) const {
  memory_.Check(path_.string());
  throw ArtifactError("{}: row {} holds {} in field '{}{}'; delete the file and run make",
                      path_.string(),
                      row,
                      what,
                      group_,
                      field);
}

std::string Hdf5Reader::PathOf(const std::string& name) const {
  const std::string path = group_ + name;
  for (std::size_t end = 0; end != std::string::npos;) {
    end = path.find('/', end + 1);
    H5L_info_t link;
    if (H5Lget_info(file_, path.substr(0, end).c_str(), &link, H5P_DEFAULT) < 0) {
      Fail(name, "is missing");
    }
    if (link.type != H5L_TYPE_HARD) Fail(name, "is a link to elsewhere, not an array of this file");
  }
  return path;
}

template std::vector<std::size_t> Hdf5Reader::ReadOffsets<std::int32_t>(
    const std::string&, std::optional<std::size_t>, std::optional<std::size_t>) const;
template std::vector<std::size_t> Hdf5Reader::ReadOffsets<std::int64_t>(
    const std::string&, std::optional<std::size_t>, std::optional<std::size_t>) const;

}  // namespace nightmap
