// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/files_of_run.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <cstring>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::files_of_run_test {

namespace fs = std::filesystem;

class FilesOfRunTest : public testing::Test {
 protected:
  void ExpectRefused(const fs::path& path, const std::string& message) {
    NIGHTMAP_EXPECT_ERROR(UsageError, files_.AddWritten(path, "--out b"), message);
  }

  TemporaryFolder folder_;
  FilesOfRun files_;
};

TEST_F(FilesOfRunTest, PlainFilesLinksToThemAndNewPathsMayBeWritten) {
  folder_.Write("old", "old");
  fs::create_symlink("old", folder_ / "link");
  fs::create_symlink("nowhere", folder_ / "dangling");
  for (const char* name : {"old", "link", "dangling", "new", "new_folder/deeper/new"}) {
    files_.AddWritten(folder_ / name, name);
  }
}

TEST_F(FilesOfRunTest, WhatIsNoPlainFileIsNamed) {
  ASSERT_EQ(mkfifo((folder_ / "fifo").c_str(), 0600), 0);
  fs::create_symlink("fifo", folder_ / "to_fifo");
  fs::create_symlink("/dev/null", folder_ / "to_null");
  folder_.Write("file", "");
  const int server = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  const std::string name = (folder_ / "s").string();
  ASSERT_LT(name.size(), sizeof(address.sun_path));
  std::memcpy(address.sun_path, name.c_str(), name.size());
  ASSERT_EQ(bind(server, reinterpret_cast<const sockaddr*>(&address), sizeof(address)), 0);
  ExpectRefused("/dev/null", "--out b: is a device; give another path");
  ExpectRefused(folder_ / "to_null", "is a device");
  ExpectRefused(folder_ / "fifo", "is a FIFO");
  ExpectRefused(folder_ / "to_fifo", "is a FIFO");
  ExpectRefused(folder_ / "s", "is a socket");
  ExpectRefused(folder_.Path(), "is a folder");
  ExpectRefused(folder_ / "none/", "is a folder");
  ExpectRefused(folder_ / "file/b", "file is no folder");
  close(server);
}

TEST_F(FilesOfRunTest, OneFileOfTwoOutputsIsRefusedHoweverItIsWritten) {
  fs::create_directory(folder_ / "real");
  fs::create_directory_symlink("real", folder_ / "link");
  files_.AddWritten(folder_ / "real/q", "--out a");
  for (const char* other : {"real/q", "./real/q", "link/q", "real/none/../q", "link/../real/q"}) {
    ExpectRefused(folder_ / other, "--out a and --out b are one file");
  }
  fs::current_path(folder_ / "real");
  ExpectRefused("q", "--out a and --out b are one file");
  fs::current_path("/");
}

TEST_F(FilesOfRunTest, AnOutputIsNoFolderOfAnother) {
  files_.AddWritten(folder_ / "a/b", "--out a");
  ExpectRefused(folder_ / "a", "--out a and --out b: one is the folder of the other");
  ExpectRefused(folder_ / "a/b/c", "--out a and --out b: one is the folder of the other");
  files_.AddWritten(folder_ / "a/bc", "--out c");
}

TEST_F(FilesOfRunTest, AnInputIsNotOverwritten) {
  const fs::path input = folder_.Write("in", "bytes");
  fs::create_hard_link(input, folder_ / "hard_link");
  fs::create_symlink("in", folder_ / "link");
  files_.AddRead(input, "--in a");
  for (const char* name : {"in", "./in", "link", "hard_link"}) {
    ExpectRefused(folder_ / name, "--out b is the file of --in a; give the output another path");
  }
}

TEST_F(FilesOfRunTest, AnInputThatIsFoundLaterIsNoOutput) {
  folder_.Write("old", "");
  files_.AddWritten(folder_ / "old", "--out b");
  NIGHTMAP_EXPECT_ERROR(UsageError,
                        files_.AddRead(folder_ / "./old", "old, which map.yaml names"),
                        "--out b is the file of old, which map.yaml names");
}

}  // namespace nightmap::files_of_run_test
