// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/vocabulary_io.h"

#include <limits>

#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::vocabulary_io_test {

// The arrays of a small valid file.
struct RawFile {
  void Write(const std::filesystem::path& path) const {
    Hdf5Writer writer(path, "nightmap.vocabulary", 1, "", "none");
    writer.WriteList<std::int32_t>("tree/kind", {kind});
    writer.WriteList<std::int32_t>("tree/depth", {depth});
    writer.Write("tree/nodes", Array<std::int32_t>{nodes.size() / 3, 3, nodes});
    writer.Write("tree/centres", Array<std::uint8_t>{3, 32, std::vector<std::uint8_t>(96)});
    writer.WriteList("frames/word_offsets", offsets);
    writer.WriteList("frames/words", words);
    writer.Close();
  }

  std::int32_t kind = 1;
  std::int32_t depth = 2;
  std::vector<std::int32_t> nodes{1, 2, 0, 0, 0, 1, 0, 0, 1};
  std::vector<std::int64_t> offsets{0, 1, 3};
  std::vector<std::int32_t> words{1, 2, 1};
};

// hdf5_formats_test.cc reads what was written.
class VocabularyIoTest : public InFolder {
 protected:
  const std::filesystem::path path_ = folder_ / "vocabulary.h5";
};

TEST_F(VocabularyIoTest, AcceptsTheUnspoiltFile) {
  RawFile().Write(path_);
  EXPECT_EQ(ReadVocabulary(path_).words, (std::vector<std::vector<int>>{{1}, {2, 1}}));
}

TEST_F(VocabularyIoTest, NamesTheArrayThatIsSpoilt) {
  const auto expect = [&](const std::string& field, const auto& spoil) {
    RawFile raw;
    spoil(raw);
    raw.Write(path_);
    NIGHTMAP_EXPECT_ERROR(DataError, ReadVocabulary(path_), field, "vocabulary.h5");
  };
  expect("tree/kind", [](RawFile& raw) { raw.kind = 3; });
  expect("tree/nodes", [](RawFile& raw) { raw.nodes[0] = 7; });
  expect("tree/nodes", [](RawFile& raw) { raw.nodes[0] = 0; });  // its own child
  // Each landmark has a word for each level.
  for (const std::int32_t depth : {0, -1, 9, std::numeric_limits<std::int32_t>::max()}) {
    expect("tree/depth' is not one number in [1, 8]", [&](RawFile& raw) { raw.depth = depth; });
  }
  expect("frames/words' has index 3", [](RawFile& raw) { raw.words[1] = 3; });
  expect("frames/word_offsets", [](RawFile& raw) { raw.offsets = {0, 2, 1, 3}; });
  expect("frames/word_offsets", [](RawFile& raw) { raw.offsets = {0, 4}; });
}

}  // namespace nightmap::vocabulary_io_test
