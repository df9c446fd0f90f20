// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/hash_cache.h"

#include <thread>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::hash_cache_test {

namespace fs = std::filesystem;

class HashCacheTest : public testing::Test {
 protected:
  HashCacheTest() {
    folder_.Write("data/a, \"b\".png", "aaaa");
    folder_.Write("data/c.png", "cccc");
    // Status change times are the system's: what was just written is settled after two seconds.
    std::this_thread::sleep_for(std::chrono::milliseconds(2100));
  }

  FileFacts Get(HashCache& files, const std::string& name) {
    return files.Get(name, [&](const fs::path& path) {
      read_.push_back(path.filename());
      return FileFacts{HashFile(path), 3, 2, 1, 16, true};
    });
  }
  // The files that a run reads, which saves what it knows.
  std::vector<std::string> Run() {
    read_.clear();
    HashCache files(folder_ / "hashes.csv", folder_ / "data");
    for (const char* name : {"a, \"b\".png", "c.png"}) {
      EXPECT_EQ(Get(files, name),
                (FileFacts{HashFile(folder_ / "data" / name), 3, 2, 1, 16, true}));
    }
    EXPECT_EQ(files.NumRead(), read_.size());
    files.Save();
    return read_;
  }

  using Names = std::vector<std::string>;
  const Names all_ = {"a, \"b\".png", "c.png"};
  TemporaryFolder folder_;
  Names read_;
};

TEST_F(HashCacheTest, OnlyNewAndChangedFilesAreRead) {
  EXPECT_EQ(Run(), all_);
  EXPECT_EQ(Run(), Names{});
  const auto time = fs::last_write_time(folder_ / "data/c.png");
  folder_.Write("data/c.png", "CCCC");
  fs::last_write_time(folder_ / "data/c.png", time);  // same size and time of modification
  EXPECT_EQ(Run(), Names{"c.png"});
  EXPECT_EQ(Run(), Names{"c.png"});  // it has just changed, and may again within a tick
}

TEST_F(HashCacheTest, ADamagedCacheIsMadeAnew) {
  Run();
  const std::string text = ReadBytes(folder_ / "hashes.csv");
  for (const std::string& damaged : {std::string(),
                                     std::string("hello\n"),
                                     text.substr(0, text.size() - 3),
                                     text.substr(0, text.find('\n') + 1),
                                     "\xff" + text}) {
    folder_.Write("hashes.csv", damaged);
    EXPECT_EQ(Run(), all_) << damaged;
    EXPECT_EQ(ReadBytes(folder_ / "hashes.csv"), text);
  }
  std::string flipped = text;  // a digit of the first row's hash
  const std::size_t digit = flipped.find(HashFile(folder_ / "data" / all_[0]));
  flipped[digit] = flipped[digit] == '0' ? '1' : '0';
  folder_.Write("hashes.csv", flipped);
  EXPECT_EQ(Run(), Names{all_[0]});
}

TEST_F(HashCacheTest, WhatIsWrongWithAFileIsSaidEachTime) {
  HashCache files(folder_ / "hashes.csv", folder_ / "data");
  const auto fail = [](const fs::path& path) -> FileFacts {
    throw DataError("{}: truncated", path.filename().string());
  };
  for (int i = 0; i < 2; ++i) {
    NIGHTMAP_EXPECT_ERROR(DataError, files.Get("c.png", fail), "c.png: truncated");
    NIGHTMAP_EXPECT_ERROR(DataError, files.Get("missing.png", fail), "missing.png: truncated");
  }
  files.Save();
  EXPECT_EQ(Run(), all_);
}

TEST_F(HashCacheTest, AFolderThatCannotBeWrittenIsNoError) {
  HashCache files("/proc/nowhere/hashes.csv", folder_ / "data");
  Get(files, "c.png");
  EXPECT_NO_THROW(files.Save());
}

}  // namespace nightmap::hash_cache_test
