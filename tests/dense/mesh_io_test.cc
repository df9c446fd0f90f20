// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/mesh_io.h"

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::mesh_io_test {

MeshVertex VertexAt(float x_m) {
  return {{x_m, 2 * x_m, -x_m}, {0, 0, 1}, {10, 20, static_cast<std::uint8_t>(x_m)}};
}

// Two components; the first has a vertex on a seam.
TileMesh TwoComponents() {
  TileMesh mesh;
  for (int i = 0; i < 7; ++i) mesh.vertices.push_back(VertexAt(static_cast<float>(i)));
  mesh.triangles = {{0, 1, 2}, {2, 1, 3}, {4, 5, 6}};
  mesh.components = {{4, 1, 2, 0.5}, {3, 0, 1, 0.25}};
  return mesh;
}

class MeshIoTest : public testing::Test {
 protected:
  void ExpectRefused(const TileMesh& mesh, const std::string& part) const {
    WriteTileMesh(path_, mesh);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadTileMesh(path_), part, path_.string());
  }

  // Puts other text in place of the first `from` of the file of TwoComponents.
  void ExpectRefusedWith(const std::string& from,
                         const std::string& to,
                         const std::string& part) const {
    WriteTileMesh(path_, TwoComponents());
    std::string bytes = ReadFile(path_);
    bytes.replace(bytes.find(from), from.size(), to);
    WriteFile(path_, bytes);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadTileMesh(path_), part, path_.string());
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "a.ply";
};

TEST_F(MeshIoTest, WhatIsWrittenIsRead) {
  const TileMesh written = TwoComponents();
  WriteTileMesh(path_, written);
  const TileMesh read = ReadTileMesh(path_);
  ASSERT_EQ(read.vertices.size(), written.vertices.size());
  for (std::size_t i = 0; i < read.vertices.size(); ++i) {
    EXPECT_EQ(read.vertices[i].position_in_map, written.vertices[i].position_in_map);
    EXPECT_EQ(read.vertices[i].normal_in_map, written.vertices[i].normal_in_map);
    EXPECT_EQ(read.vertices[i].rgb, written.vertices[i].rgb);
  }
  EXPECT_EQ(read.triangles, written.triangles);
  ASSERT_EQ(read.components.size(), 2U);
  EXPECT_EQ(read.components[0].num_vertices, 4U);
  EXPECT_EQ(read.components[0].num_seam_vertices, 1U);
  EXPECT_EQ(read.components[0].num_triangles, 2U);
  EXPECT_EQ(read.components[1].area_m2, 0.25);
}

TEST_F(MeshIoTest, AnEmptyMeshIsValid) {
  WriteTileMesh(path_, {});
  EXPECT_TRUE(ReadTileMesh(path_).vertices.empty());
}

TEST_F(MeshIoTest, EveryTruncationIsRefused) {
  WriteTileMesh(path_, TwoComponents());
  const std::string bytes = ReadFile(path_);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    WriteFile(path_, bytes.substr(0, size));
    EXPECT_THROW(ReadTileMesh(path_), DataError) << size << " of " << bytes.size() << " bytes";
  }
  WriteFile(path_, bytes + "x");
  EXPECT_THROW(ReadTileMesh(path_), DataError);
}

TEST_F(MeshIoTest, OtherLayoutsVersionsAndCountsAreRefused) {
  ExpectRefusedWith("version 1", "version 2", "not a PLY file of the mesh of a tile, version 1");
  ExpectRefusedWith("little", "big", "not a PLY file");
  ExpectRefusedWith("vertex 7", "vertex 999999999999", "its elements need");
  ExpectRefusedWith("face 3", "face 03", "not a PLY file");
}

TEST_F(MeshIoTest, AFaceThatIsNoTriangleIsRefused) {
  const std::string first_face{3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0};
  ExpectRefusedWith(first_face, "\4" + first_face.substr(1), "face 0 is no triangle");
}

TEST_F(MeshIoTest, NumbersThatMeanNothingAreRefused) {
  TileMesh mesh = TwoComponents();
  mesh.vertices[2].position_in_map.y() = std::numeric_limits<float>::quiet_NaN();
  ExpectRefused(mesh, "vertex 2 is not finite");
  mesh = TwoComponents();
  mesh.triangles[2][1] = 7;
  ExpectRefused(mesh, "face 2: vertex 7 is out of range");
  mesh.triangles[2][1] = 3;  // of the other component
  ExpectRefused(mesh, "face 2: vertex 3 is out of range");
}

TEST_F(MeshIoTest, ComponentsThatDoNotAddUpAreRefused) {
  for (const MeshComponent& component : {MeshComponent{4, 0, 1, 0.25},
                                         MeshComponent{3, 4, 1, 0.25},
                                         MeshComponent{3, 0, 2, 0.25},
                                         MeshComponent{3, 0, 1, -1}}) {
    TileMesh mesh = TwoComponents();
    mesh.components[1] = component;
    ExpectRefused(mesh, "a component does not fit");
  }
  TileMesh mesh = TwoComponents();
  mesh.components.pop_back();
  ExpectRefused(mesh, "fewer vertices or triangles");
}

}  // namespace nightmap::mesh_io_test
