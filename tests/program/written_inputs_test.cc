// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/written_inputs.h"

#include <sys/stat.h>

#include <nlohmann/json.hpp>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "tests/test_data.h"

namespace nightmap::written_inputs_test {

class WrittenInputsTest : public testing::Test {
 protected:
  // A file of the job `tiles` and the receipt of its run, which was below `then`.
  std::filesystem::path Make(const std::string& name,
                             const std::string& receipt,
                             const std::string& bytes = "as written",
                             const std::string& then = "/then/site/tiles/") {
    const nlohmann::json entry{{"name", name}, {"path", then + name}, {"xxh3", HashBytes(bytes)}};
    const nlohmann::json content{{"format", "nightmap receipt"}, {"outputs", {entry}}};
    folder_.Write("site/tiles/" + receipt, content.dump());
    return folder_.Write("site/tiles/" + name, "as written");
  }

  std::string Hash(const std::filesystem::path& input, const std::string& run = "site/grid") const {
    return WrittenInputs(folder_ / run / "receipt.json").Hash(input);
  }

  void ExpectTaken(const std::filesystem::path& input) const {
    EXPECT_EQ(Hash(input), HashFile(input));
  }

  void ExpectRefused(const std::filesystem::path& input) const {
    NIGHTMAP_EXPECT_ERROR(DataError,
                          Hash(input),
                          input.string() +
                              ": is not the file that the job wrote (its receipt names "
                              "other bytes): damaged, edited or of another site; "
                              "delete it and run make again");
  }

  TemporaryFolder folder_;
};

TEST_F(WrittenInputsTest, WhatTheReceiptNamesIsTakenAndOtherBytesAreRefused) {
  const std::vector<std::pair<std::string, std::string>> names = {
      {"tiles.txt", "receipt.json"},
      {"shard_0003.csv", "receipt.json"},  // a job of the site that writes files of units
      {"shard_0003.h5", "receipt_0003.json"},
      {"tile_-1_2.ply", "receipt_-1_2.json"}};
  for (const auto& [name, receipt] : names) {
    const auto path = Make(name, receipt);
    ExpectTaken(path);
    folder_.Write("site/tiles/" + name, "as_written");
    ExpectRefused(path);
    std::filesystem::remove(folder_ / "site/tiles" / receipt);
    ExpectTaken(path);
  }
}

TEST_F(WrittenInputsTest, AFileThatNoReceiptListsIsTaken) {
  Make("tiles.txt", "receipt.json", "others");
  ExpectTaken(folder_.Write("site/tiles/more.txt", "by hand"));
  Make("colmap/tiles.txt", "receipt.json", "others");
  ExpectTaken(folder_.Write("site/tiles/tiles.txt", "by hand"));
}

TEST_F(WrittenInputsTest, AFileOfAnotherSiteMayBeEdited) {
  const auto path = Make("map.pgm", "receipt.json", "others");
  ExpectRefused(path);
  EXPECT_EQ(Hash(path, "another/grid"), HashFile(path));
  EXPECT_EQ(WrittenInputs({}).Hash(path), HashFile(path));
}

// Programs may share a folder, and one of them may be none of the site's now.
TEST_F(WrittenInputsTest, OneOfTheReceiptsIsEnough) {
  Make("tile_1_2.ply", "receipt.json", "others");
  const auto path = Make("tile_1_2.ply", "receipt_1_2.json");
  ExpectTaken(path);
  Make("tile_1_2.ply", "receipt_1_2.json", "others");
  ExpectRefused(path);
}

TEST_F(WrittenInputsTest, WhatIsNoReceiptListsNothing) {
  const auto path = Make("tiles.txt", "receipt.json", "others");
  for (const char* content :
       {"",
        "{",
        "[]",
        "5",
        R"({"format": "nightmap receipt"})",
        R"({"format": "a receipt", "outputs": [{"path": "tiles/tiles.txt", "xxh3": "0"}]})",
        R"({"format": "nightmap receipt", "outputs": [{"path": 5, "xxh3": "0"}]})",
        R"({"format": "nightmap receipt", "outputs": [{"path": "tiles/tiles.txt"}]})"}) {
    folder_.Write("site/tiles/receipt.json", content);
    ExpectTaken(path);
  }
  std::filesystem::remove(folder_ / "site/tiles/receipt.json");
  ASSERT_EQ(mkfifo((folder_ / "site/tiles/receipt.json").c_str(), 0600), 0);
  ExpectTaken(path);
}

TEST_F(WrittenInputsTest, AFileIsReadOnce) {
  const auto path = Make("tiles.txt", "receipt.json");
  WrittenInputs inputs(folder_ / "site/grid/receipt.json");
  EXPECT_EQ(inputs.Hash(path), HashBytes("as written"));
  folder_.Write("site/tiles/tiles.txt", "while the run reads it");
  EXPECT_EQ(inputs.Hash(path), HashBytes("as written"));
}

}  // namespace nightmap::written_inputs_test
