// SPDX-License-Identifier: Apache-2.0
// VocabularyTree::Train against the same tree made with cv::kmeans in each node: k-means++ and as
// many iterations.
#include <fmt/format.h>

#include <cmath>
#include <opencv2/core.hpp>

#include "pipeline/camera/vocabulary_tree.h"
#include "tests/bench/libraries/compare.h"
#include "tests/bench/libraries/comparisons.h"

namespace nightmap {
namespace {

constexpr std::size_t kNumDescriptors = 30000;
constexpr int kDescriptorSize = 128;
const VocabularyTreeOptions kOptions{.depth = 3};

std::vector<std::uint8_t> Descriptors(const MappedSite& site) {
  std::vector<std::uint8_t> all;
  for (const FrameFeatures& frame : site.features.frames) {
    all.insert(all.end(), frame.descriptors.begin(), frame.descriptors.end());
    if (all.size() >= kNumDescriptors * kDescriptorSize) break;
  }
  all.resize(std::min(all.size(), kNumDescriptors * kDescriptorSize));
  return all;
}

// Sum over the rows of the squared distance to the centre of the leaf that each falls into.
double Cluster(const cv::Mat& rows, int level) {
  const int k = level < kOptions.depth ? kOptions.branching : 1;
  if (k == 1 || rows.rows < kOptions.min_node_descriptors) {
    cv::Mat mean;
    cv::reduce(rows, mean, 0, cv::REDUCE_AVG);
    return std::pow(cv::norm(rows, cv::NORM_L2), 2) - rows.rows * std::pow(cv::norm(mean), 2);
  }
  cv::Mat labels;
  const cv::TermCriteria end(cv::TermCriteria::COUNT, kOptions.num_kmeans_iterations, 0);
  cv::kmeans(rows, k, labels, end, 1, cv::KMEANS_PP_CENTERS);
  std::vector<std::vector<int>> members(static_cast<std::size_t>(k));
  for (int row = 0; row < rows.rows; ++row) {
    members[static_cast<std::size_t>(labels.at<int>(row))].push_back(row);
  }
  double sum = 0;
  for (const std::vector<int>& of_centre : members) {
    cv::Mat gathered(static_cast<int>(of_centre.size()), rows.cols, CV_32F);
    for (int i = 0; i < gathered.rows; ++i) {
      rows.row(of_centre[static_cast<std::size_t>(i)]).copyTo(gathered.row(i));
    }
    if (!of_centre.empty()) sum += Cluster(gathered, level + 1);
  }
  return sum;
}

double SquaredDistances(const VocabularyTree& tree, const std::vector<std::uint8_t>& descriptors) {
  const std::vector<int> words = tree.LeafWords(descriptors, 1);
  double sum = 0;
  for (std::size_t i = 0; i < words.size(); ++i) {
    const std::uint8_t* centre =
        &tree.Centres()[static_cast<std::size_t>(words[i]) * kDescriptorSize];
    for (std::size_t k = 0; k < kDescriptorSize; ++k) {
      const int difference = descriptors[i * kDescriptorSize + k] - centre[k];
      sum += difference * difference;
    }
  }
  return sum;
}

}  // namespace

void CompareKMeans(const MappedSite& site) {
  std::vector<std::uint8_t> descriptors = Descriptors(site);
  const int count = static_cast<int>(descriptors.size()) / kDescriptorSize;
  cv::Mat rows;
  cv::Mat(count, kDescriptorSize, CV_8U, descriptors.data()).convertTo(rows, CV_32F);
  VocabularyTree tree;
  double other_sum = 0;
  const auto rms = [&](double sum) { return std::sqrt(sum / count); };
  PrintComparison({.ours = "`VocabularyTree::Train`",
                   .other = "`cv::kmeans` in each node",
                   .input = fmt::format("{}: {} RootSIFT, {} levels of {}",
                                        site.name,
                                        count,
                                        kOptions.depth,
                                        kOptions.branching),
                   .run_ours =
                       [&](int num_threads) {
                         tree = VocabularyTree::Train(
                             descriptors, DescriptorKind::kRootSift, kOptions, num_threads);
                       },
                   .run_other =
                       [&](int) {
                         cv::theRNG().state = 1;
                         other_sum = Cluster(rows, 0);
                       },
                   .difference =
                       [&] {
                         return fmt::format(
                             "RMS distance to the own word {:.1f} and {:.1f} (of 512)",
                             rms(SquaredDistances(tree, descriptors)),
                             rms(other_sum));
                       }});
}

}  // namespace nightmap
