// SPDX-License-Identifier: Apache-2.0
// What is known of a recording's files without reading them again: a cache by size and time.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <string>

namespace nightmap {

// Hash of a file's bytes, and what its header says of the picture or video.
struct FileFacts {
  std::string hash;
  int width = 0;
  int height = 0;
  int num_channels = 0;
  int num_bits = 0;  // of one channel
  bool operator==(const FileFacts&) const = default;
};

// Remembers the facts of files from one run to the next, so that a run reads only files that are
// new or changed. A file is the same while its size and its times of modification and of status
// change are (the second moves also when a tool sets the first back). Facts of a file that changed
// less than two seconds before it was read are not kept: it may change again within one tick of the
// file system's clock. The cache is no artifact: results are the same with it, without it, and with
// a damaged one, whose rows are checked one by one.
//
// CSV: path,size_bytes,mtime_ns,ctime_ns,hash,width,height,num_channels,num_bits,check; paths
// relative to the data folder, check is the hash of the row before it.
class FileFactsCache {
 public:
  // Reads the cache of an earlier run; one that is missing or no such file is empty.
  FileFactsCache(std::filesystem::path cache, std::filesystem::path data_root);

  // The facts of `file` (relative to the data folder): known ones, else those that read(path)
  // gives. What read throws is thrown on. May be called from several threads.
  FileFacts Get(const std::string& file,
                const std::function<FileFacts(const std::filesystem::path&)>& read);

  // Logs how many files were read, and writes the facts of the files asked for since the
  // constructor, those of no others: whole or not at all. A folder that cannot be written costs the
  // next run time, not this one its result.
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
