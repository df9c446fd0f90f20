// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/colmap_io.h"

#include <cstring>

#include "pipeline/base/error.h"
#include "tests/io/colmap_model.h"
#include "tests/test_data.h"

namespace nightmap::colmap_io_test {

std::map<std::string, std::string> ColmapFiles(const ColmapModel& model) {
  const TemporaryFolder folder;
  std::map<std::string, std::filesystem::path> paths;
  for (const std::string name : {"cameras", "images", "points3D"}) {
    for (const std::string suffix : {".txt", ".bin"})
      paths[name + suffix] = folder / (name + suffix);
  }
  WriteColmapFiles(model, paths);
  std::map<std::string, std::string> files;
  for (const auto& [name, path] : paths) files[name] = ReadBytes(path);
  return files;
}

// Takes values off the front of the bytes.
class Bytes {
 public:
  explicit Bytes(std::string bytes) : bytes_(std::move(bytes)) {}
  template <typename T>
  T Take() {
    T value{};
    EXPECT_LE(at_ + sizeof(T), bytes_.size());
    std::memcpy(&value, bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    return value;
  }
  std::string TakeText() {
    const std::string text = bytes_.c_str() + at_;
    at_ += text.size() + 1;
    return text;
  }
  std::vector<double> TakeDoubles(int count) {
    std::vector<double> values;
    for (int i = 0; i < count; ++i) values.push_back(Take<double>());
    return values;
  }
  bool IsAtEnd() const { return at_ == bytes_.size(); }

 private:
  std::string bytes_;
  std::size_t at_ = 0;
};

std::string WithoutRemarks(const std::string& text) {
  std::string kept;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with('#')) kept += line + "\n";
  }
  return kept;
}

TEST(ColmapIoTest, EachLensHasItsModel) {
  ColmapModel model = MakeColmapModelOfTwo();
  Camera& fisheye = model.cameras[0];
  fisheye.lens = Lens::kFisheye;
  for (double Camera::*k : {&Camera::k1, &Camera::k2, &Camera::k3, &Camera::k4}) fisheye.*k = 0.5;
  model.cameras[1].k4 = 3;
  model.cameras[1].k5 = 4;
  model.cameras[1].k6 = 5;
  EXPECT_EQ(WithoutRemarks(ColmapFiles(model).at("cameras.txt")),
            "1 OPENCV_FISHEYE 640 480 500 501 320 240 0.5 0.5 0.5 0.5\n"
            "2 FULL_OPENCV 32 24 30 31 16 12 0.25 -0.5 0.125 0.0625 2 3 4 5\n");
}

TEST(ColmapIoTest, TextIsAsColmapReadsIt) {
  const auto files = ColmapFiles(MakeColmapModelOfTwo());
  EXPECT_EQ(WithoutRemarks(files.at("cameras.txt")),
            "1 PINHOLE 640 480 500 501 320 240\n"
            "2 FULL_OPENCV 32 24 30 31 16 12 0.25 -0.5 0.125 0.0625 2 0 0 0\n");
  EXPECT_EQ(WithoutRemarks(files.at("images.txt")),
            "1 1 0 0 0 0 0 0 1 a/1.png\n0.5 0.5 2 10.5 20.75 1\n"
            "2 0 0 1 0 1 2 3 2 a/2.png\n5.5 6.5 -1 7.5 8.5 -1 9.5 10.5 2\n");
  EXPECT_EQ(WithoutRemarks(files.at("points3D.txt")),
            "1 0.5 1 2 0 0 0 0.75 1 1\n2 -1 0 4 0 0 0 0.25 1 0 2 2\n");
}

TEST(ColmapIoTest, BinaryCamerasHoldTheSameAsText) {
  Bytes bytes(ColmapFiles(MakeColmapModelOfTwo()).at("cameras.bin"));
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 2U);
  EXPECT_EQ(bytes.Take<std::uint32_t>(), 1U);
  EXPECT_EQ(bytes.Take<std::int32_t>(), 1);  // PINHOLE
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 640U);
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 480U);
  EXPECT_EQ(bytes.TakeDoubles(4), (std::vector<double>{500, 501, 320, 240}));
  EXPECT_EQ(bytes.Take<std::uint32_t>(), 2U);
  EXPECT_EQ(bytes.Take<std::int32_t>(), 6);  // FULL_OPENCV
  bytes.TakeDoubles(2);                      // width and height
  EXPECT_EQ(bytes.TakeDoubles(12),
            (std::vector<double>{30, 31, 16, 12, 0.25, -0.5, 0.125, 0.0625, 2, 0, 0, 0}));
  EXPECT_TRUE(bytes.IsAtEnd());
}

TEST(ColmapIoTest, BinaryImagesHoldTheSameAsText) {
  Bytes bytes(ColmapFiles(MakeColmapModelOfTwo()).at("images.bin"));
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 2U);
  EXPECT_EQ(bytes.Take<std::uint32_t>(), 1U);
  EXPECT_EQ(bytes.TakeDoubles(7), (std::vector<double>{1, 0, 0, 0, 0, 0, 0}));
  EXPECT_EQ(bytes.Take<std::uint32_t>(), 1U);
  EXPECT_EQ(bytes.TakeText(), "a/1.png");
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 2U);
  EXPECT_EQ(bytes.TakeDoubles(2), (std::vector<double>{0.5, 0.5}));
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 2U);
  bytes.TakeDoubles(3);
  EXPECT_EQ(bytes.Take<std::uint32_t>(), 2U);
  EXPECT_EQ(bytes.TakeDoubles(7), (std::vector<double>{0, 0, 1, 0, 1, 2, 3}));
  EXPECT_EQ(bytes.Take<std::uint32_t>(), 2U);
  EXPECT_EQ(bytes.TakeText(), "a/2.png");
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 3U);
  bytes.TakeDoubles(2);
  EXPECT_EQ(bytes.Take<std::uint64_t>(), ~std::uint64_t{0});  // no point
  bytes.TakeDoubles(3);
  bytes.TakeDoubles(2);
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 2U);
  EXPECT_TRUE(bytes.IsAtEnd());
}

TEST(ColmapIoTest, BinaryPointsHoldTheSameAsText) {
  Bytes bytes(ColmapFiles(MakeColmapModelOfTwo()).at("points3D.bin"));
  EXPECT_EQ(bytes.Take<std::uint64_t>(), 2U);
  for (const std::uint64_t id : {1U, 2U}) {
    EXPECT_EQ(bytes.Take<std::uint64_t>(), id);
    EXPECT_EQ(bytes.TakeDoubles(3),
              id == 1 ? (std::vector<double>{0.5, 1, 2}) : (std::vector<double>{-1, 0, 4}));
    for (int channel = 0; channel < 3; ++channel) EXPECT_EQ(bytes.Take<std::uint8_t>(), 0);
    EXPECT_EQ(bytes.Take<double>(), id == 1 ? 0.75 : 0.25);
    EXPECT_EQ(bytes.Take<std::uint64_t>(), id);  // as many observations
    EXPECT_EQ(bytes.Take<std::uint32_t>(), 1U);
    EXPECT_EQ(bytes.Take<std::uint32_t>(), id == 1 ? 1U : 0U);
  }
  EXPECT_EQ(bytes.Take<std::uint32_t>(), 2U);
  EXPECT_EQ(bytes.Take<std::uint32_t>(), 2U);
  EXPECT_TRUE(bytes.IsAtEnd());
}

TEST(ColmapIoTest, WritesOnlyWhatHasAPathAndSaysWhereItCannot) {
  const std::string points = ColmapFiles(MakeColmapModelOfTwo()).at("points3D.bin");
  const TemporaryFolder folder;
  WriteColmapFiles(MakeColmapModelOfTwo(), {{"points3D.bin", folder / "p"}});
  EXPECT_EQ(ReadBytes(folder / "p"), points);
  NIGHTMAP_EXPECT_ERROR(
      DataError,
      WriteColmapFiles(MakeColmapModelOfTwo(), {{"images.txt", folder / "missing/i.txt"}}),
      "missing/i.txt");
}

TEST(ColmapIoTest, MeanErrorIsThatOfThePoints) {
  EXPECT_EQ(MakeColmapModelOfTwo().MeanReprojectionError_px(), 0.5);
  EXPECT_EQ(ColmapModel{}.MeanReprojectionError_px(), 0);
}

TEST(ColmapIoTest, TellsOfNamesThatColmapCannotUse) {
  ColmapModel model = MakeColmapModelOfTwo();
  EXPECT_EQ(UnusableColmapNames(model), "");
  model.images[0].name = "a b/1.png";
  EXPECT_EQ(UnusableColmapNames(model),
            "COLMAP ends a name of the text model at a blank, use the binary one: 1 of 2 names");
  model.images[1].name = "a b/clip.avi#12";
  EXPECT_EQ(UnusableColmapNames(model),
            "COLMAP ends a name of the text model at a blank, use the binary one: 2 of 2 names; "
            "COLMAP cannot open frames of a video, store them as pictures: 1 of 2 names");
  model.images[0].name = "a#b.png";
  model.images[1].name = "clip.avi#12";
  EXPECT_EQ(UnusableColmapNames(model),
            "COLMAP cannot open frames of a video, store them as pictures: 1 of 2 names");
}

TEST(ColmapIoTest, BinaryKeepsNamesWithBlanks) {
  ColmapModel model = MakeColmapModelOfTwo();
  model.images[0].name = "a b/1.png";
  Bytes bytes(ColmapFiles(model).at("images.bin"));
  bytes.Take<std::uint64_t>();
  bytes.Take<std::uint32_t>();
  bytes.TakeDoubles(7);
  bytes.Take<std::uint32_t>();
  EXPECT_EQ(bytes.TakeText(), "a b/1.png");
}

}  // namespace nightmap::colmap_io_test
