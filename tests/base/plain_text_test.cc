// SPDX-License-Identifier: Apache-2.0
#include "pipeline/base/plain_text.h"

#include <gtest/gtest.h>

namespace nightmap::plain_text_test {

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
  EXPECT_EQ(AsText("a\xc2\x9b"
                   "31m"),
            "a\\xc2\\x9b31m");  // what begins a command to a terminal
  EXPECT_TRUE(
      IsText("a\xc2\xa0"
             "b"));
}

TEST(AsLines, KeepsLineBreaksAndNoOtherControl) {
  EXPECT_EQ(AsLines("a\nb\n"), "a\nb\n");
  EXPECT_EQ(AsLines(""), "");
  EXPECT_EQ(AsLines("\n\n"), "\n\n");
  EXPECT_EQ(AsLines("Küche\n\x1b[31m\a"), "Küche\n\\x1b[31m\\x07");
}

}  // namespace nightmap::plain_text_test
