// SPDX-License-Identifier: Apache-2.0
// Thin layer over HDF5: named arrays in one file with a checked header. Equal content gives equal
// bytes (no object times, no compression), and a reader refuses bytes that changed since
// (hdf5_hashes.h). Not thread-safe.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/base/memory.h"
#include "pipeline/io/hdf5_list_in_file.h"

namespace nightmap {

// A matrix of `rows` x `cols` elements, row by row; cols = 1 for a list.
template <typename T>
struct Array {
  std::size_t rows = 0;
  std::size_t cols = 1;
  std::vector<T> values;
};

// T: uint8_t, int32_t, uint32_t, int64_t, float, double.
class Hdf5Writer {
 public:
  // Hdf5Reader checks `format` and `version`. `config` is the effective TOML config; `units` states
  // in one line the units and frames of the arrays.
  Hdf5Writer(const std::filesystem::path& path,
             const std::string& format,
             int version,
             const std::string& config,
             const std::string& units);
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  // Names of arrays are below this group from now on ("a/b/"; empty: those of the file).
  void SetGroup(std::string group) { group_ = std::move(group); }
  // `name` may hold slashes; missing groups are created.
  template <typename T>
  void Write(const std::string& name, const Array<T>& array);
  template <typename T>
  void WriteList(const std::string& name, const std::vector<T>& values) {
    Write(name, Array<T>{values.size(), 1, values});
  }
  // Writes a text beside the arrays, as an attribute of the file. Throws DataError naming file and
  // text when it is too long for HDF5 (64 kB or more); this holds for `config` and the other texts
  // too.
  void WriteText(const std::string& name, const std::string& text);
  // Flushes and closes; throws DataError naming the file (full disk included).
  void Close();

 private:
  explicit Hdf5Writer(const std::filesystem::path& path);

  std::filesystem::path path_;
  std::int64_t file_ = -1;
  std::string group_;
  std::string text_hashes_;
};

// All its errors are ArtifactErrors.
class Hdf5Reader {
 public:
  // Throws DataError naming file and field on another format, a version newer than `version`, or a
  // file that HDF5 cannot open.
  Hdf5Reader(const std::filesystem::path& path, const std::string& format, int version);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  // Names of arrays, also in errors, are below this group from now on ("a/b/"; empty: those of the
  // file).
  void SetGroup(std::string group) { group_ = std::move(group); }
  bool Has(const std::string& name) const;
  // Throws DataError naming file and field on a missing array, another element type, NaN or
  // infinity, another number of columns (cols = 0: any), values that are not as they were written,
  // or anything but a contiguous uncompressed array of this file. Allocates memory only for values
  // that the file holds.
  template <typename T>
  Array<T> Read(const std::string& name, std::size_t cols = 0) const;
  template <typename T>
  std::vector<T> ReadList(const std::string& name) const {
    return Read<T>(name, 1).values;
  }
  // A list to be read by need: checked like Read but for its values, which have no hash of their
  // own part by part.
  template <typename T>
  Hdf5ListInFile<T> LeaveInFile(const std::string& name) const;
  // The only number of an array. Throws DataError naming file and field on any other size.
  template <typename T>
  T ReadOne(const std::string& name) const {
    const auto values = ReadList<T>(name);
    Demand(values.size() == 1, name, "is not one number");
    return values[0];
  }
  // Where each of `count` lists (none: any number) starts in a flat one of `end` elements (none:
  // any number), and `end`. Throws DataError naming file and field unless they start at 0, never
  // decrease, and end with `end`. T: int32_t, int64_t.
  template <typename T = std::int64_t>
  std::vector<std::size_t> ReadOffsets(const std::string& name,
                                       std::optional<std::size_t> count,
                                       std::optional<std::size_t> end) const;
  // Reads a text of WriteText, or "config". Throws DataError naming file and field when it is
  // missing, not one text of fixed length, not UTF-8, or not as it was written.
  std::string ReadText(const std::string& name) const;
  // Throws DataError naming file and field unless `condition` holds. Readers of a format use it for
  // checks beyond the types.
  void Demand(bool condition,
              std::string_view field,
              std::string_view why = "is out of range or does not fit the others") const {
    if (!condition) Fail(field, why);
  }
  // Likewise unless they are indices of `size` things.
  void DemandIndices(const std::vector<std::vector<int>>& lists,
                     std::size_t size,
                     std::string_view field) const;
  [[noreturn]] void Fail(std::string_view field, std::string_view why) const;
  // Likewise, with the row of `field` that holds `what`.
  [[noreturn]] void FailRow(std::string_view field, std::size_t row, std::string_view what) const;
  const std::filesystem::path& Path() const { return path_; }

 private:
  struct OpenArray;
  explicit Hdf5Reader(const std::filesystem::path& path);
  // Opens an array whose declaration is as Read demands.
  template <typename T>
  OpenArray Open(const std::string& name, std::size_t cols) const;
  std::int64_t ReadInteger(const std::string& name) const;
  std::string ReadTextOf(std::int64_t object, const std::string& name) const;
  void CheckText(const std::string& name, const std::string& text) const;
  // The path of an array in the file. Fails unless it and the groups on it are members of the file.
  std::string PathOf(const std::string& name) const;

  std::filesystem::path path_;
  MemoryWatch memory_;
  std::string group_;
  std::int64_t file_ = -1;
  std::uintmax_t file_bytes_ = 0;
};

}  // namespace nightmap
