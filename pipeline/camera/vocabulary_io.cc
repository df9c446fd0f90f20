// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/vocabulary_io.h"

#include <stdexcept>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kVocabularyFormat[] = "nightmap.vocabulary";
constexpr int kVocabularyVersion = 1;
constexpr char kUnits[] = "node indices; descriptors as in the features artifact";

using Node = VocabularyTree::Node;
constexpr auto kNodes = Hdf5Table<Node>(
    Hdf5Column("tree/nodes", &Node::first_child, &Node::num_children, &Node::level));

constexpr auto kWords = Hdf5Table<std::vector<int>>(
    Hdf5Lists("frames/word_offsets", kItself, Hdf5Table<int>(Hdf5Column("frames/words", kItself))));

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
  writer.Close();
}

Vocabulary ReadVocabulary(const std::filesystem::path& path) {
  const Hdf5Reader reader(path, kVocabularyFormat, kVocabularyVersion);
  Vocabulary vocabulary{ReadTree(reader), kWords.Read(reader)};
  reader.DemandIndices(
      vocabulary.words, static_cast<std::size_t>(vocabulary.tree.NumNodes()), "frames/words");
  return vocabulary;
}

VocabularyTree ReadVocabularyTree(const std::filesystem::path& path) {
  return ReadTree(Hdf5Reader(path, kVocabularyFormat, kVocabularyVersion));
}

}  // namespace nightmap
