// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/hash_cache.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <sys/stat.h>

#include <ctime>
#include <optional>

#include "pipeline/base/atomic_outputs.h"
#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/csv.h"

namespace nightmap {
namespace {

constexpr const char* kCacheHeader =
    "path,size_bytes,mtime_ns,ctime_ns,hash,width,height,num_channels,num_bits,is_float,"
    "row_hash";
constexpr std::size_t kCheck = 10;  // column
constexpr std::int64_t kSettled_ns = 2'000'000'000;

std::int64_t Nanoseconds(const timespec& time) {
  return time.tv_sec * 1'000'000'000 + time.tv_nsec;
}

std::int64_t Now_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return Nanoseconds(now);
}

std::optional<struct stat> Status(const std::filesystem::path& path) {
  struct stat status {};
  if (stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return std::nullopt;
  return status;
}

}  // namespace

HashCache::HashCache(std::filesystem::path cache, std::filesystem::path data_root)
    : cache_(std::move(cache)), data_root_(std::move(data_root)) {
  try {
    if (std::filesystem::exists(cache_)) ReadRows();
  } catch (const std::exception& error) {  // the cache only saves time, so a damaged one is ignored
    spdlog::debug("every file is read again: {}", error.what());
    known_.clear();
  }
}

std::string HashCache::RowText(const std::string& file, const Row& row) {
  return fmt::format("{},{},{},{},{},{},{},{},{},{}",
                     CsvField(file),
                     row.size_bytes,
                     row.mtime_ns,
                     row.ctime_ns,
                     row.facts.hash,
                     row.facts.width,
                     row.facts.height,
                     row.facts.num_channels,
                     row.facts.num_bits,
                     row.facts.is_float ? 1 : 0);
}

void HashCache::ReadRows() {
  const CsvFile csv(cache_, kCacheHeader);
  for (const CsvRow& line : csv.Rows()) {
    Row row{static_cast<std::uintmax_t>(line.Integer(1)),
            line.Integer(2),
            line.Integer(3),
            {line.Text(4),
             line.Index(5),
             line.Index(6),
             line.Index(7),
             line.Index(8),
             line.Index(9) != 0}};
    if (HashBytes(RowText(line.Text(0), row)) != line.Text(kCheck)) continue;
    known_[line.Text(0)] = std::move(row);
  }
}

FileFacts HashCache::Get(const std::string& file,
                         const std::function<FileFacts(const std::filesystem::path&)>& read) {
  const std::filesystem::path path = data_root_ / file;
  const auto status = Status(path);
  if (!status) return read(path);  // read reports the problem
  Row row{static_cast<std::uintmax_t>(status->st_size),
          Nanoseconds(status->st_mtim),
          Nanoseconds(status->st_ctim),
          {}};
  const auto known = known_.find(file);
  const bool is_same = known != known_.end() && known->second.size_bytes == row.size_bytes &&
                       known->second.mtime_ns == row.mtime_ns &&
                       known->second.ctime_ns == row.ctime_ns;
  const bool is_settled = std::max(row.mtime_ns, row.ctime_ns) < Now_ns() - kSettled_ns;
  row.facts = is_same ? known->second.facts : read(path);
  const std::lock_guard lock(mutex_);
  num_read_ += is_same ? 0 : 1;
  ++num_asked_;
  if (is_settled) asked_[file] = row;
  return row.facts;
}

void HashCache::Save() const {
  spdlog::info("{} files, {} of them new or changed", num_asked_, num_read_);
  std::string text = std::string(kCacheHeader) + '\n';
  for (const auto& [file, row] : asked_) {
    const std::string facts = RowText(file, row);
    text += facts + ',' + HashBytes(facts) + '\n';
  }
  try {
    OutputSet files;
    WriteFile(files.Create(cache_, true), text);
    files.Commit();
  } catch (const Error& error) {
    spdlog::warn("the hashes of this run's files are not kept for the next: {}", error.what());
  }
}

}  // namespace nightmap
