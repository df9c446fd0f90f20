// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/ply_io.h"

#include <pcl/io/ply_io.h>
#include <pcl/point_types.h>

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/base/random.h"
#include "tests/test_data.h"

namespace nightmap::ply_io_test {

class PlyIoTest : public testing::Test {
 protected:
  void ExpectError(const std::string& part) const {
    NIGHTMAP_EXPECT_ERROR(DataError, ReadPly(path_), part, path_.string());
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "a.ply";
};

std::vector<CloudPoint> RandomCloud(int num_points) {
  std::vector<CloudPoint> points;
  for (int i = 0; i < num_points; ++i) {
    Random random(7, static_cast<std::uint64_t>(i));
    CloudPoint point;
    for (int axis = 0; axis < 3; ++axis) {
      point.position_in_map[axis] = static_cast<float>(random.Uniform(-50, 50));
      point.normal_in_map[axis] = static_cast<float>(random.Uniform(-1, 1));
    }
    for (auto& channel : point.rgb) channel = static_cast<std::uint8_t>(random.Index(256));
    point.label = static_cast<std::uint16_t>(random.Index(65536));
    points.push_back(point);
  }
  return points;
}

TEST_F(PlyIoTest, WhatIsWrittenIsReadWhateverItsLabelsAre) {
  const auto written = RandomCloud(1000);
  for (const PlyLabels labels : {PlyLabels::kUshort, PlyLabels::kUintAndScalar}) {
    WritePly(path_, written, labels);
    const auto read = ReadPly(path_);
    ASSERT_EQ(read.size(), written.size());
    for (std::size_t i = 0; i < read.size(); ++i) {
      EXPECT_EQ(read[i].position_in_map, written[i].position_in_map);
      EXPECT_EQ(read[i].normal_in_map, written[i].normal_in_map);
      EXPECT_EQ(read[i].rgb, written[i].rgb);
      EXPECT_EQ(read[i].label, written[i].label);
    }
  }
}

TEST_F(PlyIoTest, PclReadsTheLabels) {
  const auto written = RandomCloud(100);
  WritePly(path_, written, PlyLabels::kUintAndScalar);
  pcl::PCLPointCloud2 fields;
  pcl::PLYReader reader;
  ASSERT_EQ(reader.read(path_.string(), fields), 0);
  pcl::PointCloud<pcl::PointXYZL> cloud;
  pcl::fromPCLPointCloud2(fields, cloud);
  const auto scalar = std::ranges::find(fields.fields, "scalar_label", &pcl::PCLPointField::name);
  ASSERT_NE(scalar, fields.fields.end());
  ASSERT_EQ(scalar->datatype, pcl::PCLPointField::FLOAT32);
  ASSERT_EQ(cloud.size(), written.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_EQ(cloud[i].x, written[i].position_in_map.x());
    EXPECT_EQ(cloud[i].label, written[i].label);
    EXPECT_EQ(fields.at<float>(static_cast<pcl::uindex_t>(i), scalar->offset), written[i].label);
  }
}

TEST_F(PlyIoTest, EmptyCloudIsValid) {
  WritePly(path_, {});
  EXPECT_TRUE(ReadPly(path_).empty());
}

TEST_F(PlyIoTest, EveryTruncationIsRefused) {
  for (const PlyLabels labels : {PlyLabels::kUshort, PlyLabels::kUintAndScalar}) {
    WritePly(path_, RandomCloud(3), labels);
    const std::string bytes = ReadFile(path_);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      WriteFile(path_, bytes.substr(0, size));
      EXPECT_THROW(ReadPly(path_), DataError) << size << " of " << bytes.size() << " bytes";
    }
  }
}

TEST_F(PlyIoTest, BytesAfterTheLastPointAreRefused) {
  WritePly(path_, RandomCloud(3));
  WriteFile(path_, ReadFile(path_) + "x");
  ExpectError("3 points need");
}

TEST_F(PlyIoTest, NanIsRefused) {
  auto points = RandomCloud(3);
  points[1].position_in_map.y() = std::numeric_limits<float>::quiet_NaN();
  WritePly(path_, points);
  ExpectError("vertex 1 is not finite");
}

TEST_F(PlyIoTest, OtherLayoutsAreRefused) {
  WriteFile(path_, "ply\nformat ascii 1.0\nelement vertex 0\nend_header\n");
  ExpectError("not a PLY file with nightmap's properties");
}

TEST_F(PlyIoTest, HugeCountIsRefusedWithoutAllocation) {
  WritePly(path_, {});
  std::string bytes = ReadFile(path_);
  bytes.replace(bytes.find("vertex 0"), 8, "vertex 999999999999");
  WriteFile(path_, bytes);
  ExpectError("999999999999 points need");
}

}  // namespace nightmap::ply_io_test
