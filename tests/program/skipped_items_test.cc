// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/skipped_items.h"

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::skipped_items_test {

TEST(SkippedItems, AreFoldedByCauseTheMostFrequentFirst) {
  SkippedItems skipped;
  EXPECT_TRUE(skipped.Add("rgb/1.png: no such image file"));
  EXPECT_TRUE(skipped.Add("rgb/2.png: truncated png file: copy it again"));
  EXPECT_FALSE(skipped.Add("rgb/3.png: truncated png file: copy it again"));
  EXPECT_EQ(skipped.Count(), 3U);
  EXPECT_EQ(skipped.Texts()[0], "rgb/1.png: no such image file");
  const auto causes = skipped.Causes();
  ASSERT_EQ(causes.size(), 2U);
  EXPECT_EQ(CauseText(causes[0]),
            "2 items skipped: truncated png file: copy it again; the first is rgb/2.png");
  EXPECT_EQ(CauseText(causes[1]), "1 item skipped: no such image file; the first is rgb/1.png");
}

TEST(SkippedItems, CausesThatDifferInNumbersOnlyAreOne) {
  SkippedItems skipped;
  EXPECT_TRUE(skipped.Add("frame-08.color.png: frame-08.depth.png is missing"));
  EXPECT_FALSE(skipped.Add("frame-9.color.png: frame-9.depth.png is missing"));
  EXPECT_TRUE(skipped.Add("frame-9.color.png: frame.depth.png is missing"));
  EXPECT_TRUE(skipped.Add("a text without an item"));
  EXPECT_EQ(CauseText(skipped.Causes()[2]), "1 item skipped: a text without an item");
}

TEST(SkippedItems, TooManyAreAnErrorWithTheMostFrequentCause) {
  SkippedItems skipped;
  skipped.Check(0, 0);
  skipped.Add("a.png: dark");
  skipped.Add("b.png: truncated");
  skipped.Add("c.png: truncated");
  skipped.Check(10, 0.3);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        skipped.Check(10, 0.29),
                        "3 of 10 items were skipped, more than max_failed_ratio = 0.29 allows; 2 "
                        "items skipped: truncated; the first is b.png (1 other cause); repair them "
                        "or raise max_failed_ratio; with");
}

TEST(SkippedItems, NoRatioHelpsWhereAllItemsFail) {
  SkippedItems skipped;
  skipped.Add("a.png: truncated");
  skipped.Add("b.png: truncated");
  NIGHTMAP_EXPECT_ERROR(DataError, skipped.Check(2, 0.2), "is a.png; repair them; with");
  NIGHTMAP_EXPECT_ERROR(DataError, skipped.Check(3, 0.2), "or raise max_failed_ratio");
}

TEST(SkippedItems, OfAnInputAreAnErrorOfTheInput) {
  SkippedItems skipped;
  skipped.Add("scan at 1.0: fits nowhere");
  skipped.Check(2, 0.5, {{"scans"}});
  NIGHTMAP_EXPECT_ERROR(InputError,
                        skipped.Check(2, 0.4, {{"scans"}, {"trajectory"}}),
                        "scans, trajectory: 1 of 2 items were skipped");
}

}  // namespace nightmap::skipped_items_test
