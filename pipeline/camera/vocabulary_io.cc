// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/vocabulary_io.h"

#include <numeric>
#include <optional>
#include <stdexcept>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kVocabularyFormat[] = "nightmap.vocabulary";
constexpr int kVocabularyVersion = 2;  // 2: postings
constexpr char kUnits[] = "node indices; descriptors as in the features artifact";

using Node = VocabularyTree::Node;
constexpr auto kNodes = Hdf5Table<Node>(
    Hdf5Column("tree/nodes", &Node::first_child, &Node::num_children, &Node::level));

constexpr auto kWords = Hdf5Table<std::vector<int>>(
    Hdf5Lists("frames/word_offsets", kItself, Hdf5Table<int>(Hdf5Column("frames/words", kItself))));

constexpr char kBegins[] = "postings/begins";
constexpr char kFrames[] = "postings/frame_idx";
constexpr char kWeights[] = "postings/weight";

void WritePostings(const InvertedFile& frames, Hdf5Writer* writer) {
  const std::vector<std::size_t>& begins = frames.Begins();
  writer->WriteList(kBegins, std::vector<std::int64_t>(begins.begin(), begins.end()));
  writer->WriteList(kFrames, frames.AllPostings().frames);
  writer->WriteList(kWeights, frames.AllPostings().weights);
}

// Without a branch per element, as most pictures read hundreds of thousands.
void CheckFrames(const std::vector<std::int32_t>& frames,
                 std::size_t num_frames,
                 const Hdf5ListInFile<std::int32_t>& list) {
  if (frames.empty()) return;
  bool ascend = true;
  for (std::size_t i = 1; i < frames.size(); ++i) ascend &= frames[i - 1] < frames[i];
  if (!ascend || frames.front() < 0 || static_cast<std::size_t>(frames.back()) >= num_frames) {
    list.Fail(fmt::format("has frames out of order, or not in [0, {})", num_frames));
  }
}

InvertedFile OpenPostings(const Hdf5Reader& reader, std::size_t num_words) {
  const std::size_t num_frames =
      reader.ReadOffsets("frames/word_offsets", std::nullopt, std::nullopt).size() - 1;
  const auto frames = reader.LeaveInFile<std::int32_t>(kFrames);
  const auto weights = reader.LeaveInFile<float>(kWeights);
  auto begins = reader.ReadOffsets(kBegins, std::nullopt, frames.Size());
  reader.Demand(begins.size() - 1 <= num_words, kBegins);
  reader.Demand(weights.Size() == frames.Size(), kWeights, "has another length");
  const auto read = [=](std::size_t begin, std::size_t end, InvertedFile::Postings* postings) {
    frames.Read(begin, end, &postings->frames);
    weights.Read(begin, end, &postings->weights);
    CheckFrames(postings->frames, num_frames, frames);
    const auto is_weight = [](bool are, float weight) {
      return are & (weight > 0) & (weight < 1.001F);
    };
    if (!std::accumulate(postings->weights.begin(), postings->weights.end(), true, is_weight)) {
      weights.Fail("is not in (0, 1]");
    }
  };
  return {num_frames, std::move(begins), read};
}

VocabularyTree ReadTree(const Hdf5Reader& reader) {
  const auto kind = reader.ReadOne<std::int32_t>("tree/kind");
  reader.Demand(kind >= 0 && kind <= 2, "tree/kind", "is no known descriptor");
  const auto size = static_cast<std::size_t>(DescriptorSize(static_cast<DescriptorKind>(kind)));
  auto centres = reader.Read<std::uint8_t>("tree/centres", size);
  const auto depth = reader.ReadList<std::int32_t>("tree/depth");
  constexpr int kMaxDepth = VocabularyTreeOptions::kMaxDepth;
  reader.Demand(depth.size() == 1 && depth[0] >= 1 && depth[0] <= kMaxDepth,
                "tree/depth",
                fmt::format("is not one number in [1, {}]", kMaxDepth));
  try {
    return {static_cast<DescriptorKind>(kind),
            depth[0],
            kNodes.Read(reader),
            std::move(centres.values)};
  } catch (const std::invalid_argument& error) {
    throw DataError("{}: tree/{}; rebuild it", reader.Path().string(), error.what());
  }
}

}  // namespace

void WriteVocabulary(const std::filesystem::path& path,
                     const Vocabulary& vocabulary,
                     const std::string& config) {
  const VocabularyTree& tree = vocabulary.tree;
  Hdf5Writer writer(path, kVocabularyFormat, kVocabularyVersion, config, kUnits);
  writer.WriteList<std::int32_t>("tree/kind", {static_cast<std::int32_t>(tree.Kind())});
  writer.WriteList<std::int32_t>("tree/depth", {tree.Depth()});
  kNodes.Write(tree.Nodes(), &writer);
  writer.Write("tree/centres",
               Array<std::uint8_t>{tree.Nodes().size(),
                                   static_cast<std::size_t>(DescriptorSize(tree.Kind())),
                                   tree.Centres()});
  kWords.Write(vocabulary.words, &writer);
  WritePostings(InvertedFile(vocabulary.words), &writer);
  writer.Close();
}

Vocabulary ReadVocabulary(const std::filesystem::path& path) {
  const Hdf5Reader reader(path, kVocabularyFormat, kVocabularyVersion);
  Vocabulary vocabulary{ReadTree(reader), kWords.Read(reader)};
  reader.DemandIndices(
      vocabulary.words, static_cast<std::size_t>(vocabulary.tree.NumNodes()), "frames/words");
  return vocabulary;
}

VocabularyIndex OpenVocabulary(const std::filesystem::path& path) {
  const Hdf5Reader reader(path, kVocabularyFormat, kVocabularyVersion);
  VocabularyTree tree = ReadTree(reader);
  const auto num_words = static_cast<std::size_t>(tree.NumNodes());
  return {std::move(tree), OpenPostings(reader, num_words)};
}

VocabularyTree ReadVocabularyTree(const std::filesystem::path& path) {
  return ReadTree(Hdf5Reader(path, kVocabularyFormat, kVocabularyVersion));
}

}  // namespace nightmap
