// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/point_cloud/place_quality.h"

#include <gtest/gtest.h>

namespace nightmap::place_quality_test {

TEST(PlaceQualities, HoldWhatLiesInTheirCubeWhateverTheOrder) {
  PlaceQualities forwards, backwards;
  const Eigen::Vector3d here(0.1, -0.1, 1.3), there(0.6, -0.1, 1.3);
  for (int i = 0; i < 5; ++i) forwards.AddFlat(here, 0.01F * static_cast<float>(i));
  forwards.AddRay(there, true);
  forwards.AddRay(there, false);
  backwards.AddRay(there, false);
  backwards.AddRay(there, true);
  for (int i = 4; i >= 0; --i) backwards.AddFlat(here, 0.01F * static_cast<float>(i));
  const auto places = forwards.Places();
  ASSERT_EQ(places.size(), 2U);
  EXPECT_TRUE(places[0].centre_in_map.isApprox(Eigen::Vector3d(0.25, -0.25, 1.25)));
  EXPECT_EQ(places[0].num_flat, 5U);
  EXPECT_FLOAT_EQ(static_cast<float>(places[0].thickness_m), 0.02F);
  EXPECT_EQ(places[0].num_rays, 0U);
  EXPECT_EQ(places[1].num_flat, 0U);
  EXPECT_EQ(places[1].num_rays, 2U);
  EXPECT_EQ(places[1].num_agreeing, 1U);
  EXPECT_EQ(PlacesToCsv(places), PlacesToCsv(backwards.Places()));
  EXPECT_EQ(PlacesToCsv(places),
            "x_m,y_m,z_m,num_flat,thickness_m,num_rays,num_rays_agreeing\n"
            "0.25,-0.25,1.25,5,0.0200,0,0\n"
            "0.75,-0.25,1.25,0,,2,1\n");
}

TEST(PlaceQualities, OfNothingAreNone) { EXPECT_TRUE(PlaceQualities().Places().empty()); }

}  // namespace nightmap::place_quality_test
