// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/vocabulary_io.h"

#include <limits>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/landmark_scene.h"
#include "tests/test_data.h"

namespace nightmap::vocabulary_io_test {

class VocabularyIoTest : public testing::Test {
 protected:
  // The arrays of a small valid file, to be spoilt one at a time.
  void WriteRaw() const {
    Hdf5Writer writer(path_, "nightmap.vocabulary", 1, "", "none");
    writer.WriteList<std::int32_t>("tree/kind", {kind_});
    writer.WriteList<std::int32_t>("tree/depth", {depth_});
    writer.Write("tree/nodes", Array<std::int32_t>{nodes_.size() / 3, 3, nodes_});
    writer.Write("tree/centres", Array<std::uint8_t>{3, 32, std::vector<std::uint8_t>(96)});
    writer.WriteList("frames/word_offsets", offsets_);
    writer.WriteList("frames/words", words_);
    writer.Close();
  }
  void ExpectRefused(const std::string& field) const {
    WriteRaw();
    NIGHTMAP_EXPECT_ERROR(DataError, ReadVocabulary(path_), field, "vocabulary.h5");
  }

  TemporaryFolder folder_;
  std::filesystem::path path_ = folder_ / "vocabulary.h5";
  std::int32_t kind_ = 1;
  std::int32_t depth_ = 2;
  std::vector<std::int32_t> nodes_{1, 2, 0, 0, 0, 1, 0, 0, 1};
  std::vector<std::int64_t> offsets_{0, 1, 3};
  std::vector<std::int32_t> words_{1, 2, 1};
};

TEST_F(VocabularyIoTest, ReadsWhatItWrote) {
  const Vocabulary written = MakeSceneVocabulary(MakeLandmarkScene(200, 3));
  WriteVocabulary(path_, written, "branching = 10\n");
  const Vocabulary read = ReadVocabulary(path_);
  EXPECT_EQ(read.tree.Kind(), written.tree.Kind());
  EXPECT_EQ(read.tree.Depth(), written.tree.Depth());
  EXPECT_EQ(read.tree.Centres(), written.tree.Centres());
  EXPECT_EQ(read.inverted_file.Words(), written.inverted_file.Words());
  WriteVocabulary(folder_ / "again.h5", read, "branching = 10\n");
  EXPECT_EQ(ReadBytes(path_), ReadBytes(folder_ / "again.h5"));
}

TEST_F(VocabularyIoTest, AcceptsTheUnspoiltFile) {
  WriteRaw();
  EXPECT_EQ(ReadVocabulary(path_).inverted_file.Words(),
            (std::vector<std::vector<int>>{{1}, {2, 1}}));
}

TEST_F(VocabularyIoTest, RefusesUnknownKinds) {
  kind_ = 3;
  ExpectRefused("tree/kind");
}

TEST_F(VocabularyIoTest, RefusesBrokenTrees) {
  nodes_[0] = 7;
  ExpectRefused("tree/nodes");
  nodes_[0] = 0;  // its own child
  ExpectRefused("tree/nodes");
}

TEST_F(VocabularyIoTest, RefusesDepthsThatNoTreeHas) {
  // Each landmark has a word for each level.
  for (const std::int32_t depth : {0, -1, 9, std::numeric_limits<std::int32_t>::max()}) {
    depth_ = depth;
    ExpectRefused("tree/depth' is not one number in [1, 8]");
  }
}

TEST_F(VocabularyIoTest, RefusesWordsOutOfRange) {
  words_[1] = 3;
  ExpectRefused("frames/words' has index 3");
}

TEST_F(VocabularyIoTest, RefusesOffsetsThatDoNotAddUp) {
  offsets_ = {0, 2, 1, 3};
  ExpectRefused("frames/word_offsets");
  offsets_ = {0, 4};
  ExpectRefused("frames/word_offsets");
}

}  // namespace nightmap::vocabulary_io_test
