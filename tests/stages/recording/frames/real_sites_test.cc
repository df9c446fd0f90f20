// SPDX-License-Identifier: Apache-2.0
// The lists of the sites whose recordings are public.
#include <gtest/gtest.h>

#include "pipeline/recording/inspect_frames.h"
#include "stages/recording/frames/frames.h"
#include "tests/test_data.h"

namespace nightmap::real_sites_test {

struct RealSite {
  const char* name;
  std::size_t num_frames, num_held_out, num_with_truth;
};

class RealSiteTest : public testing::TestWithParam<RealSite> {};

TEST_P(RealSiteTest, EveryFrameIsUsable) {
  const SiteConfig site = ReadSiteConfig(std::string("configs/sites/") + GetParam().name + ".toml");
  NIGHTMAP_REQUIRE_DATA(site.root);
  const auto data_root = TestDataPath("");
  auto sequences = ReadSequences(site, data_root);
  Progress progress("test", false);
  const TemporaryFolder folder;
  HashCache files(folder / "hashes.csv", data_root);
  InspectFrames(site.cameras, data_root, files, progress, 2, &sequences);
  const FrameLists lists = RunFrames(sequences, site.hold_out_every);
  EXPECT_TRUE(lists.skipped.empty()) << lists.skipped.front();
  EXPECT_EQ(lists.frames.size(), GetParam().num_frames);
  EXPECT_EQ(lists.held_out.size(), GetParam().num_held_out);
  EXPECT_EQ(lists.ground_truth.size(), GetParam().num_with_truth);
}

INSTANTIATE_TEST_SUITE_P(Sites,
                         RealSiteTest,
                         testing::Values(RealSite{"hololens_office", 373, 0, 373},
                                         RealSite{"hololens_office_queries", 299, 74, 299},
                                         RealSite{"tum_fr1_xyz_15hz", 399, 0, 397}),
                         [](const auto& param) { return param.param.name; });

}  // namespace nightmap::real_sites_test
