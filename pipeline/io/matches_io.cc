// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/matches_io.h"

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kMatchesFormat[] = "nightmap matches";
constexpr int kMatchesVersion = 1;

constexpr auto kMatches = Hdf5Table<FeatureMatch>(
    Hdf5Column("match", &FeatureMatch::a, &FeatureMatch::b).Elements(kNotNegative));

// Columns of FramePair, or of what is one.
template <typename Row, typename... Lists>
constexpr auto PairTable(Lists... lists) {
  return Hdf5Table<Row>(
      Hdf5Column("frame", &FramePair::frame_a, &FramePair::frame_b).Rows([](const FramePair& pair) {
        return pair.frame_a >= 0 && pair.frame_a < pair.frame_b;
      }),
      Hdf5Column("status", &FramePair::status).Elements([](int status) {
        return status >= 0 && status <= static_cast<int>(PairStatus::kUncertain);
      }),
      Hdf5Column("num_putative", &FramePair::num_putative).Elements(kNotNegative),
      Hdf5Column("score", &FramePair::score),
      Hdf5Column("b_from_a", &FramePair::b_from_a),
      Hdf5Column("covariance", &FramePair::covariance),
      lists...);
}

constexpr char kFirstMatch[] = "first_match";

constexpr auto kPairs =
    PairTable<FramePair>(Hdf5Lists<std::int32_t>(kFirstMatch, &FramePair::inliers, kMatches));
constexpr auto kCountedPairs = PairTable<CountedPair>();

}  // namespace

const char* PairStatusText(PairStatus status) {
  switch (status) {
    case PairStatus::kAccepted:
      return "accepted";
    case PairStatus::kTooFewMatches:
      return "too few matches with depth";
    case PairStatus::kTooFewInliers:
      return "too few inliers";
    case PairStatus::kPoorSpread:
      return "inliers cover too little of the image";
    case PairStatus::kInconsistent:
      return "neighbouring frames do not find this place";
    case PairStatus::kUncertain:
      return "pose too uncertain";
  }
  return "unknown";
}

void WritePairs(const std::filesystem::path& path,
                const std::vector<FramePair>& pairs,
                const std::string& config) {
  Hdf5Writer file(path,
                  kMatchesFormat,
                  kMatchesVersion,
                  config,
                  "metres; rad; b_from_a: camera b from camera a");
  kPairs.Write(pairs, &file);
  file.Close();
}

std::vector<FramePair> ReadPairs(const std::filesystem::path& path) {
  return kPairs.Read(Hdf5Reader(path, kMatchesFormat, kMatchesVersion));
}

std::vector<CountedPair> ReadCountedPairs(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kMatchesFormat, kMatchesVersion);
  std::vector<CountedPair> pairs = kCountedPairs.Read(file);
  const auto starts = file.ReadOffsets<std::int32_t>(kFirstMatch, pairs.size(), std::nullopt);
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    pairs[i].num_inliers = static_cast<int>(starts[i + 1] - starts[i]);
  }
  return pairs;
}

}  // namespace nightmap
