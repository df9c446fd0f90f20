// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/colmap_io.h"

#include <sqlite3.h>

#include <cstring>

#include "pipeline/base/error.h"
#include "tests/test_data.h"

namespace nightmap::colmap_io_test {

// Two cameras, one distorted; two images that see three points, the first image one alone.
ColmapModel MakeModel() {
  ColmapModel model;
  model.cameras = {{640, 480, 500, 501, 319.5, 239.5}, {32, 24, 30, 31, 15.5, 11.5}};
  model.cameras[1].k1 = 0.25;
  model.cameras[1].k2 = -0.5;
  model.cameras[1].p1 = 0.125;
  model.cameras[1].p2 = 0.0625;
  model.cameras[1].k3 = 2;
  const Rigid3 half_turn{Eigen::Quaterniond(0, 0, 1, 0), {1, 2, 3}};
  model.images.push_back({"a/1.png", 0, {}});
  model.images.push_back({"a/2.png", 1, half_turn});
  model.features = [](std::size_t i) {
    return i == 0
               ? ColmapFeatures{{{0, 0}, {10, 20.25}}, std::vector<std::uint8_t>(2 * 128, 7)}
               : ColmapFeatures{{{5, 6}, {7, 8}, {9, 10}}, std::vector<std::uint8_t>(3 * 128, 9)};
  };
  model.AddPoint({0.5, 1, 2}, 0.75, {{0, 1}});
  model.AddPoint({-1, 0, 4}, 0.25, {{0, 0}, {1, 2}});
  return model;
}

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
  ColmapModel model = MakeModel();
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
  const auto files = ColmapFiles(MakeModel());
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
  Bytes bytes(ColmapFiles(MakeModel()).at("cameras.bin"));
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
  Bytes bytes(ColmapFiles(MakeModel()).at("images.bin"));
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
  Bytes bytes(ColmapFiles(MakeModel()).at("points3D.bin"));
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
  const std::string points = ColmapFiles(MakeModel()).at("points3D.bin");
  const TemporaryFolder folder;
  WriteColmapFiles(MakeModel(), {{"points3D.bin", folder / "p"}});
  EXPECT_EQ(ReadBytes(folder / "p"), points);
  NIGHTMAP_EXPECT_ERROR(DataError,
                        WriteColmapFiles(MakeModel(), {{"images.txt", folder / "missing/i.txt"}}),
                        "missing/i.txt");
}

TEST(ColmapIoTest, MeanErrorIsThatOfThePoints) {
  EXPECT_EQ(MakeModel().MeanReprojectionError_px(), 0.5);
  EXPECT_EQ(ColmapModel{}.MeanReprojectionError_px(), 0);
}

TEST(ColmapIoTest, TellsOfNamesThatColmapCannotUse) {
  ColmapModel model = MakeModel();
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
  ColmapModel model = MakeModel();
  model.images[0].name = "a b/1.png";
  Bytes bytes(ColmapFiles(model).at("images.bin"));
  bytes.Take<std::uint64_t>();
  bytes.Take<std::uint32_t>();
  bytes.TakeDoubles(7);
  bytes.Take<std::uint32_t>();
  EXPECT_EQ(bytes.TakeText(), "a b/1.png");
}

class ColmapDatabaseTest : public testing::Test {
 protected:
  void SetUp() override { WriteColmapDatabase(path_, model_); }
  void TearDown() override { sqlite3_close(database_); }

  // The rows of a query; columns joined by '|', blobs as hex digits.
  std::vector<std::string> Select(const std::string& sql) {
    if (!database_) sqlite3_open(path_.c_str(), &database_);
    std::vector<std::string> rows;
    const auto add = [](void* target, int num_columns, char** values, char**) {
      std::string row;
      for (int i = 0; i < num_columns; ++i) {
        row += std::string(i ? "|" : "") + (values[i] ? values[i] : "");
      }
      static_cast<std::vector<std::string>*>(target)->push_back(row);
      return 0;
    };
    EXPECT_EQ(sqlite3_exec(database_, sql.c_str(), add, &rows, nullptr), SQLITE_OK) << sql;
    return rows;
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "database.db";
  ColmapModel model_ = MakeModel();
  sqlite3* database_ = nullptr;
};

std::string Hex(const void* bytes, std::size_t size) {
  std::string text;
  for (std::size_t i = 0; i < size; ++i) {
    text += fmt::format("{:02X}", static_cast<const unsigned char*>(bytes)[i]);
  }
  return text;
}

TEST_F(ColmapDatabaseTest, HoldsCamerasImagesAndFeatures) {
  EXPECT_EQ(Select("PRAGMA user_version"), std::vector<std::string>{"3800"});
  const double pinhole[] = {500, 501, 320, 240};
  EXPECT_EQ(Select("SELECT camera_id, model, width, height, hex(params) FROM cameras LIMIT 1"),
            std::vector<std::string>{"1|1|640|480|" + Hex(pinhole, sizeof(pinhole))});
  EXPECT_EQ(Select("SELECT image_id, name, camera_id FROM images"),
            (std::vector<std::string>{"1|a/1.png|1", "2|a/2.png|2"}));
  const float keypoints[] = {0.5F, 0.5F, 10.5F, 20.75F};
  EXPECT_EQ(Select("SELECT rows, cols, hex(data) FROM keypoints WHERE image_id = 1"),
            std::vector<std::string>{"2|2|" + Hex(keypoints, sizeof(keypoints))});
  EXPECT_EQ(Select("SELECT rows, cols, length(data), hex(substr(data, 1, 1)) FROM descriptors"),
            (std::vector<std::string>{"2|128|256|07", "3|128|384|09"}));
}

TEST_F(ColmapDatabaseTest, HoldsTheMatchesOfTheTracks) {
  const std::int64_t pair = 2147483647LL * 1 + 2;
  const std::uint32_t match[] = {0, 2};
  const std::string expected = fmt::format("{}|1|2|{}", pair, Hex(match, sizeof(match)));
  EXPECT_EQ(Select("SELECT pair_id, rows, cols, hex(data) FROM matches"),
            std::vector<std::string>{expected});
  const double translation[] = {1, 2, 3};
  EXPECT_EQ(
      Select("SELECT pair_id, rows, cols, hex(data), config, hex(tvec) FROM two_view_geometries"),
      std::vector<std::string>{expected + "|2|" + Hex(translation, sizeof(translation))});
}

TEST_F(ColmapDatabaseTest, ReplacesAFileAndGivesTheSameBytes) {
  const std::string first = ReadBytes(path_);
  WriteColmapDatabase(path_, model_);
  EXPECT_EQ(ReadBytes(path_), first);
}

TEST_F(ColmapDatabaseTest, LongTracksCostInProportion) {
  model_ = {model_.cameras, std::vector<ColmapImage>(50), {}, {}, {}};
  model_.features = [](std::size_t) { return ColmapFeatures{{{1, 1}}, {}}; };
  for (int i = 0; i < 50; ++i)
    model_.images[static_cast<std::size_t>(i)].name = fmt::format("{}", i);
  std::vector<ColmapObservation> track;
  for (int i = 0; i < 50; ++i) track.push_back({i, 0});
  model_.AddPoint({}, 0, track);
  WriteColmapDatabase(path_, model_);
  const int num_pairs = 50 * kMaxNextMatched - kMaxNextMatched * (kMaxNextMatched + 1) / 2;
  EXPECT_EQ(Select("SELECT count(*) FROM matches"),
            std::vector<std::string>{std::to_string(num_pairs)});
  EXPECT_TRUE(Select("SELECT image_id FROM descriptors").empty());
}

TEST_F(ColmapDatabaseTest, SaysWhereItCannotWrite) {
  NIGHTMAP_EXPECT_ERROR(DataError,
                        WriteColmapDatabase(folder_ / "missing/database.db", model_),
                        "missing/database.db");
}

}  // namespace nightmap::colmap_io_test
