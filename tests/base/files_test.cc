// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/files.h"
#include "pipeline/base/atomic_outputs.h"

#include <sys/stat.h>

#include <set>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::files_test {

namespace fs = std::filesystem;

std::set<std::string> NamesIn(const fs::path& folder) {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.insert(entry.path().filename());
  return names;
}

class OutputSetTest : public InFolder {};

TEST_F(OutputSetTest, NothingAppearsBeforeCommitAndEverythingAfter) {
  OutputSet outputs;
  WriteFile(outputs.Create(folder_ / "a/one.txt"), "1");
  WriteFile(outputs.Create(folder_ / "two.txt"), "2");
  EXPECT_FALSE(fs::exists(folder_ / "a/one.txt"));
  EXPECT_FALSE(fs::exists(folder_ / "two.txt"));
  outputs.Commit();
  EXPECT_EQ(ReadFile(folder_ / "a/one.txt"), "1");
  EXPECT_EQ(ReadFile(folder_ / "two.txt"), "2");
  EXPECT_EQ(NamesIn(folder_.Path()), (std::set<std::string>{"a", "two.txt"}));
}

TEST_F(OutputSetTest, WithoutCommitTheOldFilesStayAndNoTemporaryIsLeft) {
  folder_.Write("one.txt", "old");
  {
    OutputSet outputs;
    WriteFile(outputs.Create(folder_ / "one.txt"), "new");
  }
  EXPECT_EQ(ReadFile(folder_ / "one.txt"), "old");
  EXPECT_EQ(NamesIn(folder_.Path()), std::set<std::string>{"one.txt"});
}

TEST_F(OutputSetTest, AnAnnouncedButUnwrittenFileStopsTheCommitOfAll) {
  folder_.Write("one.txt", "old");
  OutputSet outputs;
  WriteFile(outputs.Create(folder_ / "one.txt"), "new");
  outputs.Create(folder_ / "two.txt");
  NIGHTMAP_EXPECT_ERROR(DataError, outputs.Commit(), "two.txt");
  EXPECT_EQ(ReadFile(folder_ / "one.txt"), "old");
}

TEST_F(OutputSetTest, TwoRunsOfOneOutputEachWriteTheirOwnFile) {
  OutputSet first, second;
  const fs::path of_first = first.Create(folder_ / "one.txt");
  const fs::path of_second = second.Create(folder_ / "one.txt");
  WriteFile(of_first, "first");
  WriteFile(of_second, "half of the sec");
  const std::string hash = HashFile(first.CurrentPath(folder_ / "one.txt"));
  first.Commit();
  EXPECT_EQ(HashFile(folder_ / "one.txt"), hash);
  EXPECT_EQ(ReadFile(of_second), "half of the sec");
  WriteFile(of_second, "second");
  second.Commit();
  EXPECT_EQ(ReadFile(folder_ / "one.txt"), "second");
  EXPECT_EQ(NamesIn(folder_.Path()), std::set<std::string>{"one.txt"});
}

TEST_F(OutputSetTest, ALinkInPlaceOfAnOutputIsReplacedAndItsFileStays) {
  folder_.Write("elsewhere/old.txt", "old");
  fs::create_symlink("elsewhere/old.txt", folder_ / "link");
  fs::create_symlink("nothing", folder_ / "dangling");
  OutputSet outputs;
  WriteFile(outputs.Create(folder_ / "link"), "new");
  WriteFile(outputs.Create(folder_ / "dangling"), "new");
  outputs.Commit();
  for (const char* name : {"link", "dangling"}) {
    EXPECT_FALSE(fs::is_symlink(folder_ / name));
    EXPECT_EQ(ReadFile(folder_ / name), "new");
  }
  EXPECT_EQ(ReadFile(folder_ / "elsewhere/old.txt"), "old");
  EXPECT_FALSE(fs::exists(folder_ / "nothing"));
}

TEST_F(OutputSetTest, KeepIfEqualKeepsTheTimeOfEqualBytesOnly) {
  const auto then = fs::file_time_type::clock::now() - std::chrono::hours(1);
  for (const char* name : {"same", "other"}) {
    fs::last_write_time(folder_.Write(name, "old"), then);
  }
  OutputSet outputs;
  WriteFile(outputs.Create(folder_ / "same", true), "old");
  WriteFile(outputs.Create(folder_ / "other", true), "new");
  outputs.Commit();
  EXPECT_EQ(fs::last_write_time(folder_ / "same"), then);
  EXPECT_GT(fs::last_write_time(folder_ / "other"), then);
  EXPECT_EQ(ReadFile(folder_ / "other"), "new");
}

TEST_F(OutputSetTest, APathForTwoOutputsAndAFolderInPlaceOfAFileCommitNothing) {
  folder_.Write("one.txt", "old");
  folder_.Write("two/inside", "");
  OutputSet outputs;
  WriteFile(outputs.Create(folder_ / "one.txt"), "new");
  NIGHTMAP_EXPECT_ERROR(UsageError, outputs.Create(folder_ / "one.txt"), "two outputs");
  WriteFile(outputs.Create(folder_ / "two"), "new");
  NIGHTMAP_EXPECT_ERROR(UsageError, outputs.Commit(), "is a folder");
  EXPECT_EQ(ReadFile(folder_ / "one.txt"), "old");
}

TEST_F(OutputSetTest, AFileInPlaceOfAFolderIsNamed) {
  folder_.Write("a", "not a folder");
  OutputSet outputs;
  NIGHTMAP_EXPECT_ERROR(DataError, outputs.Create(folder_ / "a/b/one.txt"), "a/b");
}

// Not even root can write there, so the test holds in containers too.
TEST_F(OutputSetTest, AFolderThatCannotBeWrittenIsNamed) {
  OutputSet outputs;
  NIGHTMAP_EXPECT_ERROR(DataError, outputs.Create("/proc/one.txt"), "/proc: cannot write there");
  NIGHTMAP_EXPECT_ERROR(DataError, outputs.Create("/proc/a/one.txt"), "/proc/a");
}

TEST_F(OutputSetTest, KnowsWhereTheBytesAre) {
  OutputSet outputs;
  const fs::path temporary = outputs.Create(folder_ / "b.txt");
  WriteFile(temporary, "1");
  WriteFile(outputs.Create(folder_ / "a.txt"), "2");
  EXPECT_EQ(outputs.FinalPaths(), (std::vector<fs::path>{folder_ / "b.txt", folder_ / "a.txt"}));
  EXPECT_EQ(temporary.extension(), ".txt");
  EXPECT_EQ(outputs.CurrentPath(folder_ / "b.txt"), temporary);
  outputs.Commit();
  EXPECT_EQ(outputs.CurrentPath(folder_ / "b.txt"), folder_ / "b.txt");
}

TEST(Files, FullDiskIsNamed) {
  NIGHTMAP_EXPECT_ERROR(DataError, WriteFile("/dev/full", std::string(1 << 16, 'x')), "/dev/full");
}

TEST(Files, HashesDependOnEveryByteAndAgree) {
  const TemporaryFolder folder;
  std::string bytes(100000, 'a');
  const std::string hash = HashBytes(bytes);
  EXPECT_EQ(hash.size(), 16U);
  EXPECT_EQ(HashFile(folder.Write("a", bytes)), hash);
  bytes[77777] = 'b';
  EXPECT_NE(HashBytes(bytes), hash);
  NIGHTMAP_EXPECT_ERROR(DataError, HashFile(folder / "missing"), "missing");
  NIGHTMAP_EXPECT_ERROR(DataError, ReadFile(folder / "missing"), "missing");
}

// Opening the FIFO would wait for a writer for ever.
TEST(Files, WhatIsNoPlainFileIsNotRead) {
  const TemporaryFolder folder;
  ASSERT_EQ(mkfifo((folder / "fifo").c_str(), 0600), 0);
  fs::create_symlink("fifo", folder / "link");
  for (const auto& [path, why] : {std::pair{folder / "fifo", "is a FIFO"},
                                  std::pair{folder / "link", "is a FIFO"},
                                  std::pair{fs::path("/dev/null"), "is a device"},
                                  std::pair{folder.Path(), "is a folder"}}) {
    NIGHTMAP_EXPECT_ERROR(DataError, ReadFile(path), path.string() + ": " + why);
    NIGHTMAP_EXPECT_ERROR(DataError, HashFile(path), path.string() + ": " + why);
  }
}

}  // namespace nightmap::files_test
