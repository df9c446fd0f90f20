// SPDX-License-Identifier: Apache-2.0
#include "stages/dense/join_meshes/textured_glb.h"

#include <cstring>
#include <nlohmann/json.hpp>

#include "pipeline/base/files.h"
#include "tests/stages/dense/join_meshes/two_squares.h"
#include "tests/test_data.h"

namespace nightmap::textured_glb_test {

// A file as its description says.
class Glb {
 public:
  explicit Glb(const std::string& bytes) {
    const std::size_t json_bytes = Number(bytes, 12);
    json_ = nlohmann::json::parse(bytes.substr(20, json_bytes));
    buffer_ = bytes.substr(28 + json_bytes);
    EXPECT_EQ(Number(bytes, 8), bytes.size());
    EXPECT_EQ(Number(bytes, 20 + json_bytes), buffer_.size());
    EXPECT_EQ(json_["buffers"][0]["byteLength"], buffer_.size());
  }

  const nlohmann::json& Json() const { return json_; }
  const nlohmann::json& Primitive(std::size_t i) const {
    return json_["meshes"][0]["primitives"][i];
  }

  // The values of a vertex, or an index.
  template <typename T, std::size_t kNum>
  std::array<T, kNum> At(const nlohmann::json& accessor_idx, std::size_t i) const {
    const auto& accessor = json_["accessors"][accessor_idx.get<std::size_t>()];
    const auto& view = json_["bufferViews"][accessor["bufferView"].get<std::size_t>()];
    EXPECT_LT(i, accessor["count"].get<std::size_t>());
    const std::size_t stride = view.value("byteStride", sizeof(T) * kNum);
    const std::size_t offset =
        view["byteOffset"].get<std::size_t>() + accessor.value("byteOffset", 0) + i * stride;
    EXPECT_EQ(offset % 4, 0U);
    std::array<T, kNum> values{};
    std::memcpy(values.data(), buffer_.substr(offset).data(), sizeof(values));
    return values;
  }

  // The position of the corner of a primitive's triangles.
  std::array<float, 3> Corner(std::size_t primitive, std::size_t i) const {
    const std::size_t vertex = At<std::uint32_t, 1>(Primitive(primitive)["indices"], i)[0];
    return At<float, 3>(Primitive(primitive)["attributes"]["POSITION"], vertex);
  }

  std::string PictureOf(std::size_t primitive) const {
    const auto& material = json_["materials"][Primitive(primitive)["material"].get<std::size_t>()];
    const auto& texture = material["pbrMetallicRoughness"]["baseColorTexture"]["index"];
    const auto& image = json_["textures"][texture.get<std::size_t>()]["source"];
    const auto& view = json_["images"][image.get<std::size_t>()]["bufferView"];
    const auto& bytes = json_["bufferViews"][view.get<std::size_t>()];
    return buffer_.substr(bytes["byteOffset"], bytes["byteLength"]);
  }

 private:
  static std::uint32_t Number(const std::string& bytes, std::size_t offset) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + offset, sizeof(value));
    return value;
  }

  nlohmann::json json_;
  std::string buffer_;
};

class TexturedGlbTest : public InFolder {
 protected:
  Glb Write(double min_component_m2) {
    const auto meshes = TwoSquares();
    const auto textures = TwoTextures();
    const auto load = [&](std::size_t tile) { return meshes[tile]; };
    const JoinedMesh joined =
        RunJoinMeshes({.min_component_m2 = min_component_m2},
                      2,
                      load,
                      {[](const JoinedMesh&) {}, [](const MeshVertex&) {}, [](const Triangle&) {}});
    size_ = WriteTexturedGlb(folder_ / "glb", joined, load, [&](std::size_t tile, const TileMesh&) {
      return textures[tile];
    });
    EXPECT_EQ(size_.num_triangles, joined.size.num_triangles);
    return Glb(ReadFile(folder_ / "glb"));
  }

  TexturedSize size_;
};

TEST_F(TexturedGlbTest, PagesAreOnTheirTriangles) {
  const Glb glb = Write(0.01);
  ASSERT_EQ(glb.Json()["meshes"][0]["primitives"].size(), 3U);  // the small triangle is dropped
  EXPECT_EQ(size_.num_pages, 2U);
  EXPECT_EQ(size_.num_textured_triangles, 3U);
  EXPECT_EQ(glb.PictureOf(0), "left");
  EXPECT_EQ(glb.PictureOf(2), "right");
  const auto& left = glb.Primitive(0);
  EXPECT_THAT(glb.Corner(0, 0), testing::ElementsAre(0, 7, 0));   // (0, 0, 7) of the map
  EXPECT_THAT(glb.Corner(0, 4), testing::ElementsAre(1, 7, -1));  // (1, 1, 7)
  EXPECT_THAT((glb.At<float, 2>(left["attributes"]["TEXCOORD_0"], 3)), testing::ElementsAre(1, 0));
  EXPECT_THAT(glb.Corner(2, 1), testing::ElementsAre(2, 7, -1));
}

TEST_F(TexturedGlbTest, TrianglesWithoutAPageHaveTheColorsOfTheirVertices) {
  const Glb glb = Write(0.01);
  const auto& attributes = glb.Primitive(1)["attributes"];
  EXPECT_FALSE(attributes.contains("TEXCOORD_0"));
  EXPECT_THAT((glb.At<std::uint16_t, 4>(attributes["COLOR_0"], 2)),
              testing::ElementsAre(65535, 0, 14146, 65535));  // sRGB 128 is 0.2158605 linear
  EXPECT_THAT(glb.Corner(1, 1), testing::ElementsAre(2, 7, 0));
}

TEST_F(TexturedGlbTest, KeptComponentsHaveTheirPages) {
  const Glb glb = Write(0);
  ASSERT_EQ(glb.Json()["meshes"][0]["primitives"].size(), 4U);
  EXPECT_EQ(glb.PictureOf(1), "small");
  const auto& position = glb.Json()["accessors"][3];
  EXPECT_EQ(position["min"], (nlohmann::json{0.5F, 7.0F, -5.01F}));
}

}  // namespace nightmap::textured_glb_test
