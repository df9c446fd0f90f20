// SPDX-License-Identifier: Apache-2.0
// A list that an HDF5 artifact holds in one piece, left in the file and read in parts, by need.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace nightmap {

// Keeps the file open, also after its Hdf5Reader is gone. Thread-safe. The hash of a list covers
// all of it, so parts are read unchecked: a reader of a format checks what it uses.
template <typename T>
class Hdf5ListInFile {
 public:
  // Hdf5Reader::LeaveInFile makes one. Takes the file descriptor.
  Hdf5ListInFile(int file,
                 std::filesystem::path path,
                 std::string name,
                 std::uint64_t offset,
                 std::size_t size);

  std::size_t Size() const { return size_; }
  // Replaces `values`, whose memory it uses again, by elements [begin, end). Throws ArtifactError
  // naming file and field when the list has no such elements, when they cannot be read, and on NaN
  // or infinity.
  void Read(std::size_t begin, std::size_t end, std::vector<T>* values) const;
  // Throws ArtifactError naming file and field, for checks of a format.
  [[noreturn]] void Fail(std::string_view why) const;

 private:
  std::shared_ptr<const int> file_;  // closed by the last copy
  std::filesystem::path path_;
  std::string name_;
  std::uint64_t offset_;
  std::size_t size_;
};

}  // namespace nightmap
