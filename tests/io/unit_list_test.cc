// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/unit_list.h"

#include <gtest/gtest.h>

namespace nightmap::unit_list_test {

TEST(NameList, HasTheCountAndANamePerLine) {
  EXPECT_EQ(NameListToText("shards", {"0000", "0001"}),
            "nightmap shards, version 1, 2 names\n0000\n0001\n");
  EXPECT_EQ(NameListToText("tiles", {}), "nightmap tiles, version 1, 0 names\n");
}

}  // namespace nightmap::unit_list_test
