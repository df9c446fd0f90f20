// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/data_paths.h"

#include <gtest/gtest.h>

namespace nightmap::data_paths_test {

TEST(WithoutDataRoot, IsDoneWhereverThePathStands) {
  EXPECT_EQ(
      WithoutDataRoot("/d/data/a/b.png: Empty file \"/d/data/a/b.png\"", "/d/data", "a/b.png"),
      "a/b.png: Empty file \"a/b.png\"");
  EXPECT_EQ(WithoutDataRoot("data/a.png: bad", "data", "a.png"), "a.png: bad");
  EXPECT_EQ(WithoutDataRoot("olddata/b.png: bad", "data", "a.png"), "olddata/b.png: bad");
}

}  // namespace nightmap::data_paths_test
