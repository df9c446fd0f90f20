// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/text_file.h"

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/trajectory_io.h"
#include "tests/test_data.h"

namespace nightmap::text_file_test {

using namespace std::string_literals;

TEST(ReadTextFile, NulBytesAreToldWithTheirLine) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadTextFile(folder.Write("a.txt", "1 a\n2 b\n")), "1 a\n2 b\n");
  const auto cut = folder.Write("b.txt", "1 a\n2 b\n3 c" + std::string(500, '\0'));
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadTextFile(cut), "b.txt:3: holds 500 NUL bytes", "copy the file again");
}

TEST(ReadTextFile, TextOfWindowsIsReadOrTold) {
  const TemporaryFolder folder;
  EXPECT_EQ(ReadTextFile(folder.Write("a.txt",
                                      "\xEF\xBB\xBF"
                                      "1 a\n")),
            "1 a\n");
  const auto wide = folder.Write("b.txt",
                                 "\xFF\xFE"
                                 "1\0 \0"s);
  NIGHTMAP_EXPECT_ERROR(
      DataError, ReadTextFile(wide), "b.txt: is text in UTF-16: store it as UTF-8");
}

TEST(ReadTextFile, IsWhatListsTrajectoriesAndTablesAreReadBy) {
  const TemporaryFolder folder;
  const auto tum = folder.Write("t.tum", "0.1 1 2 3 0 0 0 1\n# end" + std::string(9, '\0'));
  NIGHTMAP_EXPECT_ERROR(DataError, ReadTum(tum), "t.tum:2: holds 9 NUL bytes");
  const auto csv = folder.Write("t.csv", "a,b\n1,2"s + '\0' + "\n"s);
  NIGHTMAP_EXPECT_ERROR(DataError, CsvFile(csv, "a,b"), "t.csv:2: holds 1 NUL bytes");
}

}  // namespace nightmap::text_file_test
