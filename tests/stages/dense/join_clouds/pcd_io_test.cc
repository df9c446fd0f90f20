// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_clouds/pcd_io.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstring>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

namespace nightmap::pcd_io_test {

TEST(PcdIo, HasTheFieldsOfItsHeader) {
  const auto path =
      std::filesystem::temp_directory_path() / fmt::format("nightmap_{}.pcd", getpid());
  PcdWriter writer(path, 2);
  writer.Add({{1, 2, 3}, {0, 0, 1}, {10, 20, 30}, 7});
  writer.Add({{-4, 5, -6}, {1, 0, 0}, {255, 0, 1}, 65535});
  writer.Close();
  const std::string bytes = ReadFile(path);
  std::filesystem::remove(path);
  const std::size_t begin = bytes.find("DATA binary\n") + 12;
  const std::string header = bytes.substr(0, begin);
  EXPECT_THAT(header, testing::HasSubstr("\nFIELDS x y z normal_x normal_y normal_z rgb label\n"));
  EXPECT_THAT(header, testing::HasSubstr("\nTYPE F F F F F F F U\n"));
  EXPECT_THAT(header, testing::HasSubstr("\nWIDTH 2\nHEIGHT 1\n"));
  EXPECT_THAT(header, testing::HasSubstr("\nPOINTS 2\n"));
  ASSERT_EQ(bytes.size() - begin, 2U * 32);
  float numbers[6];
  std::memcpy(numbers, bytes.data() + begin + 32, sizeof(numbers));
  EXPECT_THAT(numbers, testing::ElementsAre(-4, 5, -6, 1, 0, 0));
  std::uint32_t words[2];
  std::memcpy(words, bytes.data() + begin + 24, sizeof(words));
  EXPECT_THAT(words, testing::ElementsAre(0x0A141EU, 7U));
}

TEST(PcdIo, AFolderThatIsNotThereIsAnErrorThatNamesTheFile) {
  PcdWriter writer("/nonexistent/cloud.pcd", 1);
  try {
    writer.Close();
    FAIL() << "no error";
  } catch (const DataError& error) {
    EXPECT_THAT(error.what(), testing::HasSubstr("/nonexistent/cloud.pcd"));
  }
}

}  // namespace nightmap::pcd_io_test
