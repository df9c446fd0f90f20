// SPDX-License-Identifier: Apache-2.0
// The database of colmap_io.h.
#include <sqlite3.h>

#include "pipeline/base/error.h"
#include "tests/io/colmap_model.h"
#include "tests/test_data.h"

namespace nightmap::colmap_database_test {

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
  ColmapModel model_ = MakeColmapModelOfTwo();
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

}  // namespace nightmap::colmap_database_test
