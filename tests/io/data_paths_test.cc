// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/data_paths.h"

#include <gtest/gtest.h>

namespace nightmap {
namespace data_paths_test {

TEST(WithoutDataRoot, IsDoneWhereverThePathStands) {
  EXPECT_EQ(
      WithoutDataRoot("/d/data/a/b.png: Empty file \"/d/data/a/b.png\"", "/d/data", "a/b.png"),
      "a/b.png: Empty file \"a/b.png\"");
  EXPECT_EQ(WithoutDataRoot("data/a.png: bad", "data", "a.png"), "a.png: bad");
  EXPECT_EQ(WithoutDataRoot("olddata/b.png: bad", "data", "a.png"), "olddata/b.png: bad");
}

TEST(AsText, LeavesTextAsItIs) {
  for (const char* text : {"a/b 1.png", "Küche,\"2\".jpg", "écran\u202f12.png", "日本.png", ""}) {
    EXPECT_TRUE(IsText(text)) << text;
    EXPECT_EQ(AsText(text), text);
  }
}

TEST(AsText, WritesOtherBytesSoThatTextCanHoldThem) {
  EXPECT_EQ(AsText("a/\xff\xfe.png"), "a/\\xff\\xfe.png");
  EXPECT_EQ(AsText("a\nb\t.png"), "a\\x0ab\\x09.png");
  EXPECT_EQ(AsText("K\xfc"
                   "che.png"),  // Latin-1
            "K\\xfcche.png");
  EXPECT_EQ(AsText("\xc3.png"), "\\xc3.png");           // a letter cut in two
  EXPECT_EQ(AsText("\xc0\xaf.png"), "\\xc0\\xaf.png");  // an overlong '/'
  EXPECT_FALSE(IsText("\x7f"));
}

}  // namespace data_paths_test
}  // namespace nightmap
