// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/vocabulary_io.h"

#include <limits>

#include "pipeline/base/parallel.h"
#include "pipeline/base/random.h"
#include "pipeline/io/hdf5_file.h"
#include "tests/test_data.h"

namespace nightmap::vocabulary_io_test {

// The arrays of a small valid file.
struct RawFile {
  void Write(const std::filesystem::path& path) const {
    Hdf5Writer writer(path, "nightmap.vocabulary", 2, "", "none");
    writer.WriteList<std::int32_t>("tree/kind", {kind});
    writer.WriteList<std::int32_t>("tree/depth", {depth});
    writer.Write("tree/nodes", Array<std::int32_t>{nodes.size() / 3, 3, nodes});
    writer.Write("tree/centres", Array<std::uint8_t>{3, 32, std::vector<std::uint8_t>(96)});
    writer.WriteList("frames/word_offsets", offsets);
    writer.WriteList("frames/words", words);
    writer.WriteList("postings/begins", begins);
    writer.WriteList("postings/frame_idx", posting_frames);
    writer.WriteList("postings/weight", weights);
    writer.Close();
  }

  std::int32_t kind = 1;
  std::int32_t depth = 2;
  std::vector<std::int32_t> nodes{1, 2, 0, 0, 0, 1, 0, 0, 1};
  std::vector<std::int64_t> offsets{0, 1, 3};
  std::vector<std::int32_t> words{1, 2, 1};
  std::vector<std::int64_t> begins{0, 0, 2, 3};
  std::vector<std::int32_t> posting_frames{0, 1, 1};
  std::vector<float> weights{1, 0.5F, 0.8F};
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

TEST_F(VocabularyIoTest, NamesThePostingsThatAreSpoilt) {
  const auto expect = [&](const std::string& field, const auto& spoil) {
    RawFile raw;
    spoil(raw);
    raw.Write(path_);
    NIGHTMAP_EXPECT_ERROR(
        ArtifactError, OpenVocabulary(path_).frames.Query({1, 2}, 5), field, "vocabulary.h5");
  };
  expect("postings/begins", [](RawFile& raw) { raw.begins = {0, 2, 1, 3}; });
  expect("postings/begins", [](RawFile& raw) { raw.begins = {0, 0, 2, 4}; });
  expect("postings/begins", [](RawFile& raw) { raw.begins = {0, 0, 2, 3, 3}; });  // a fourth word
  expect("postings/weight", [](RawFile& raw) { raw.weights.pop_back(); });
  expect("postings/weight' is not in (0, 1]", [](RawFile& raw) { raw.weights[2] = 2; });
  expect("postings/weight' is not in (0, 1]", [](RawFile& raw) { raw.weights[0] = 0; });
  for (const auto& [i, frame] : {std::pair{1, 2}, {2, -1}, {1, 0}}) {
    expect("postings/frame_idx' has frames out of order, or not in [0, 2)",
           [&](RawFile& raw) { raw.posting_frames[static_cast<std::size_t>(i)] = frame; });
  }
}

// A file of an older nightmap has no postings.
TEST_F(VocabularyIoTest, OpensNoFileWithoutPostings) {
  Hdf5Writer writer(path_, "nightmap.vocabulary", 1, "", "none");
  writer.WriteList<std::int32_t>("tree/kind", {1});
  writer.WriteList<std::int32_t>("tree/depth", {2});
  writer.Write("tree/nodes", Array<std::int32_t>{3, 3, RawFile().nodes});
  writer.Write("tree/centres", Array<std::uint8_t>{3, 32, std::vector<std::uint8_t>(96)});
  writer.WriteList("frames/word_offsets", RawFile().offsets);
  writer.Close();
  NIGHTMAP_EXPECT_ERROR(
      ArtifactError, OpenVocabulary(path_), "'postings/frame_idx' is missing", "run make");
}

// Postings left on disk give the scores of those in memory, bit for bit, from any thread.
TEST_F(VocabularyIoTest, PostingsOnDiskScoreAsThoseInMemory) {
  constexpr int kNumNodes = 301;
  std::vector<VocabularyTree::Node> nodes(kNumNodes, {0, 0, 1});
  nodes[0] = {1, kNumNodes - 1, 0};
  Random random(3);
  Vocabulary vocabulary{{DescriptorKind::kOrb, 1, nodes, std::vector<std::uint8_t>(32 * kNumNodes)},
                        std::vector<std::vector<int>>(80)};
  const auto draw = [&](std::size_t count) {
    std::vector<int> words;
    for (std::size_t i = 0; i < count; ++i) {
      words.push_back(1 + static_cast<int>(random.Index(random.Index(2) == 0 ? 10 : 250)));
    }
    return words;
  };
  for (auto& words : vocabulary.words) words = draw(random.Index(200));
  WriteVocabulary(path_, vocabulary, "");
  const VocabularyIndex on_disk = OpenVocabulary(path_);
  std::filesystem::remove(path_);  // it stays open
  const InvertedFile in_memory(vocabulary.words);
  std::vector<std::vector<int>> queries(50);
  for (auto& query : queries) query = draw(100);
  queries.push_back({-1, 0, kNumNodes - 1, kNumNodes});  // that no frame has
  ParallelFor(queries.size(), 4, [&](std::size_t i) {
    for (const int before : {-1, 40}) {
      const auto expected = in_memory.Query(queries[i], 20, before);
      const auto found = on_disk.frames.Query(queries[i], 20, before);
      ASSERT_EQ(found.size(), expected.size());
      for (std::size_t k = 0; k < found.size(); ++k) {
        EXPECT_EQ(found[k].frame_idx, expected[k].frame_idx);
        EXPECT_EQ(found[k].score, expected[k].score);
      }
    }
  });
}

}  // namespace nightmap::vocabulary_io_test
