// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/writing_folder.h"

#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::writing_folder_test {

namespace fs = std::filesystem;

std::ptrdiff_t NumFiles(const fs::path& folder) {
  return std::distance(fs::directory_iterator(folder), fs::directory_iterator());
}

// Another process that writes a file in a WritingFolder and then waits.
class Writer {
 public:
  explicit Writer(const fs::path& parent) {
    std::array<int, 2> ends{};
    EXPECT_EQ(pipe(ends.data()), 0);
    process_ = fork();
    if (process_ == 0) {
      const WritingFolder folder(parent);
      WriteFile(folder.Path() / "half.txt", "half a fi");
      const bool is_told = write(ends[1], "x", 1) == 1;
      while (is_told) pause();
      _exit(1);
    }
    char ready = 0;
    EXPECT_EQ(read(ends[0], &ready, 1), 1);
    close(ends[0]);
    close(ends[1]);
  }
  ~Writer() { Kill(); }
  Writer(const Writer&) = delete;
  Writer& operator=(const Writer&) = delete;

  void Kill() {
    if (process_ <= 0) return;
    kill(process_, SIGKILL);
    waitpid(process_, nullptr, 0);
    process_ = 0;
  }

 private:
  pid_t process_ = 0;
};

TEST(WritingFolder, IsOfItsOwnAndGoneAfterwards) {
  const TemporaryFolder folder;
  {
    const WritingFolder first(folder.Path()), second(folder.Path());
    EXPECT_NE(first.Path(), second.Path());
    EXPECT_EQ(first.Path().parent_path(), folder.Path());
    WriteFile(first.Path() / "a.txt", "a");
    EXPECT_EQ(NumFiles(folder.Path()), 2);
  }
  EXPECT_EQ(NumFiles(folder.Path()), 0);
}

TEST(WritingFolder, TheFolderOfALivingRunSurvivesTheNextRunAndThatOfAKilledOneDoesNot) {
  const TemporaryFolder folder;
  Writer writer(folder.Path());
  { const WritingFolder next(folder.Path()); }
  ASSERT_EQ(NumFiles(folder.Path()), 1);
  const fs::path of_writer = fs::directory_iterator(folder.Path())->path();
  EXPECT_EQ(ReadFile(of_writer / "half.txt"), "half a fi");
  writer.Kill();
  EXPECT_TRUE(fs::exists(of_writer / "half.txt"));
  { const WritingFolder next(folder.Path()); }
  EXPECT_EQ(NumFiles(folder.Path()), 0);
}

TEST(WritingFolder, FoldersOfOtherHostsAndOtherFilesAreLeftAlone) {
  const TemporaryFolder folder;
  std::array<char, 256> host{};
  ASSERT_EQ(gethostname(host.data(), host.size() - 1), 0);
  const std::string ours = ".writing." + std::string(host.data());
  folder.Write(".writing.another-host.abcdef/half.txt", "");
  folder.Write(ours + ".example.org.abcdef/half.txt", "");  // of a host with a longer name
  folder.Write(ours + ".abcdef", "a file");
  folder.Write(ours + ".fedcba/half.txt", "");
  { const WritingFolder next(folder.Path()); }
  EXPECT_TRUE(fs::exists(folder / ".writing.another-host.abcdef/half.txt"));
  EXPECT_TRUE(fs::exists(folder / (ours + ".example.org.abcdef/half.txt")));
  EXPECT_TRUE(fs::exists(folder / (ours + ".abcdef")));
  EXPECT_FALSE(fs::exists(folder / (ours + ".fedcba")));
}

}  // namespace nightmap::writing_folder_test
