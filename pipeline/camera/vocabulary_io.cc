// SPDX-License-Identifier: Apache-2.0
#include "pipeline/camera/vocabulary_io.h"

#include <stdexcept>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kVocabularyFormat[] = "nightmap.vocabulary";
constexpr int kVocabularyVersion = 1;
constexpr char kUnits[] = "node indices; descriptors as in the features artifact";

DescriptorKind ReadKind(const Hdf5Reader& reader) {
  const auto kind = reader.ReadList<std::int32_t>("tree/kind");
  if (kind.size() != 1 || kind[0] < 0 || kind[0] > 2) {
    throw DataError("{}: tree/kind is no known descriptor; rebuild it", reader.Path().string());
  }
  return static_cast<DescriptorKind>(kind[0]);
}

int ReadDepth(const Hdf5Reader& reader) {
  const auto depth = reader.ReadList<std::int32_t>("tree/depth");
  if (depth.size() != 1 || depth[0] < 1 || depth[0] > VocabularyTreeOptions::kMaxDepth) {
    throw DataError("{}: tree/depth is not one number in [1, {}]; rebuild it",
                    reader.Path().string(),
                    VocabularyTreeOptions::kMaxDepth);
  }
  return depth[0];
}

VocabularyTree ReadTree(const Hdf5Reader& reader) {
  const DescriptorKind kind = ReadKind(reader);
  const auto node_rows = reader.Read<std::int32_t>("tree/nodes", 3);
  auto centres =
      reader.Read<std::uint8_t>("tree/centres", static_cast<std::size_t>(DescriptorSize(kind)));
  std::vector<VocabularyTree::Node> nodes(node_rows.rows);
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    const std::int32_t* row = &node_rows.values[3 * i];
    nodes[i] = {row[0], row[1], row[2]};
  }
  try {
    return {kind, ReadDepth(reader), std::move(nodes), std::move(centres.values)};
  } catch (const std::invalid_argument& error) {
    throw DataError("{}: tree/{}; rebuild it", reader.Path().string(), error.what());
  }
}

std::vector<std::vector<int>> ReadWords(const Hdf5Reader& reader, const VocabularyTree& tree) {
  const auto offsets = reader.ReadList<std::int64_t>("frames/word_offsets");
  const auto words = reader.ReadList<std::int32_t>("frames/words");
  const std::string file = reader.Path().string();
  if (offsets.empty() || offsets[0] != 0 ||
      offsets.back() != static_cast<std::int64_t>(words.size())) {
    throw DataError("{}: frames/word_offsets do not cover frames/words", file);
  }
  for (std::size_t i = 1; i < offsets.size(); ++i) {
    if (offsets[i] < offsets[i - 1]) throw DataError("{}: frames/word_offsets decrease", file);
  }
  for (const std::int32_t word : words) {
    if (word < 0 || word >= tree.NumNodes()) {
      throw DataError("{}: frames/words has index {} out of range", file, word);
    }
  }
  std::vector<std::vector<int>> frames(offsets.size() - 1);
  for (std::size_t i = 0; i < frames.size(); ++i) {
    frames[i].assign(words.begin() + offsets[i], words.begin() + offsets[i + 1]);
  }
  return frames;
}

}  // namespace

void WriteVocabulary(const std::filesystem::path& path,
                     const Vocabulary& vocabulary,
                     const std::string& config) {
  const VocabularyTree& tree = vocabulary.tree;
  Hdf5Writer writer(path, kVocabularyFormat, kVocabularyVersion, config, kUnits);
  writer.WriteList<std::int32_t>("tree/kind", {static_cast<std::int32_t>(tree.Kind())});
  writer.WriteList<std::int32_t>("tree/depth", {tree.Depth()});
  Array<std::int32_t> nodes{tree.Nodes().size(), 3, {}};
  for (const auto& node : tree.Nodes()) {
    nodes.values.insert(nodes.values.end(), {node.first_child, node.num_children, node.level});
  }
  writer.Write("tree/nodes", nodes);
  writer.Write("tree/centres",
               Array<std::uint8_t>{tree.Nodes().size(),
                                   static_cast<std::size_t>(DescriptorSize(tree.Kind())),
                                   tree.Centres()});
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int32_t> words;
  for (const auto& frame : vocabulary.inverted_file.Words()) {
    words.insert(words.end(), frame.begin(), frame.end());
    offsets.push_back(static_cast<std::int64_t>(words.size()));
  }
  writer.WriteList("frames/word_offsets", offsets);
  writer.WriteList("frames/words", words);
  writer.Close();
}

Vocabulary ReadVocabulary(const std::filesystem::path& path) {
  const Hdf5Reader reader(path, kVocabularyFormat, kVocabularyVersion);
  Vocabulary vocabulary;
  vocabulary.tree = ReadTree(reader);
  vocabulary.inverted_file = InvertedFile(ReadWords(reader, vocabulary.tree));
  return vocabulary;
}

}  // namespace nightmap
