// SPDX-License-Identifier: Apache-2.0
// Caches facts of a recording's files by size and time, so that they are not read again.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>

namespace nightmap {

// Hash of a file's bytes, and the picture or video properties from its header.
struct FileFacts {
  std::string hash;
  int width = 0;
  int height = 0;
  int num_channels = 0;
  int num_bits = 0;  // per channel
  bool is_float = false;
  bool operator==(const FileFacts&) const = default;
};

// Remembers the facts of files from one run to the next, so that a run reads only new or changed
// files. A file counts as unchanged while its size, modification time and status change time stay
// (the last changes even when a tool sets the modification time back). Facts of a file that changed
// less than two seconds before it was read are not kept, because it may change again within one
// tick of the file system's clock. The cache is no artifact: results are the same with it, without
// it, and with a damaged one, whose rows are checked one by one.
//
// CSV: path,size_bytes,mtime_ns,ctime_ns,hash,width,height,num_channels,num_bits,is_float,
// row_hash; paths relative to the data folder, row_hash is that of the row before it.
class HashCache {
 public:
  // Reads the cache of an earlier run; a missing or invalid file counts as empty.
  HashCache(std::filesystem::path cache, std::filesystem::path data_root);

  // Returns the facts of `file` (relative to the data folder): the cached ones, else those that
  // read(path) returns. Exceptions of read pass through. Thread safe.
  FileFacts Get(const std::string& file,
                const std::function<FileFacts(const std::filesystem::path&)>& read);

  // Logs how many files were read. Writes the facts of exactly the files asked for since the
  // constructor, atomically. If the folder cannot be written, this run's result stays valid and the
  // next run takes longer.
  void Save() const;

  std::size_t NumRead() const { return num_read_; }
  std::size_t NumAsked() const { return num_asked_; }

 private:
  struct Row {
    std::uintmax_t size_bytes = 0;
    std::int64_t mtime_ns = 0;
    std::int64_t ctime_ns = 0;
    FileFacts facts;
  };
  static std::string RowText(const std::string& file, const Row& row);
  void ReadRows();

  std::filesystem::path cache_;
  std::filesystem::path data_root_;
  std::map<std::string, Row> known_;
  std::map<std::string, Row> asked_;
  std::size_t num_read_ = 0;
  std::size_t num_asked_ = 0;
  std::mutex mutex_;
};

}  // namespace nightmap
