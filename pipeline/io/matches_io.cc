// SPDX-License-Identifier: Apache-2.0
// Arrays (P pairs, M inlier matches in all): frame P x 2; status, num_putative P; score P;
// b_from_a P x 7; covariance P x 36; first_match P+1; match M x 2 (feature in a, in b).
#include "pipeline/io/matches_io.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/pose_arrays.h"

namespace nightmap {
namespace {

constexpr char kMatchesFormat[] = "nightmap matches";
constexpr int kMatchesVersion = 1;

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
  Array<std::int32_t> frame{pairs.size(), 2, {}};
  Array<std::int32_t> match{0, 2, {}};
  std::vector<std::int32_t> status, num_putative, first_match = {0};
  std::vector<double> score;
  Array<double> pose{0, 7, {}};
  Array<double> covariance{0, 36, {}};
  for (const FramePair& pair : pairs) {
    frame.values.insert(frame.values.end(), {pair.frame_a, pair.frame_b});
    status.push_back(static_cast<std::int32_t>(pair.status));
    num_putative.push_back(pair.num_putative);
    score.push_back(pair.score);
    AppendPose(pair.b_from_a, &pose);
    AppendCovariance(pair.covariance, &covariance);
    for (const FeatureMatch& inlier : pair.inliers) {
      match.values.insert(match.values.end(), {inlier.a, inlier.b});
    }
    match.rows += pair.inliers.size();
    first_match.push_back(static_cast<std::int32_t>(match.rows));
  }
  Hdf5Writer file(path,
                  kMatchesFormat,
                  kMatchesVersion,
                  config,
                  "metres; rad; b_from_a: camera b from camera a");
  file.Write("frame", frame);
  file.WriteList("status", status);
  file.WriteList("num_putative", num_putative);
  file.WriteList("score", score);
  file.Write("b_from_a", pose);
  file.Write("covariance", covariance);
  file.WriteList("first_match", first_match);
  file.Write("match", match);
  file.Close();
}

std::vector<FramePair> ReadPairs(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kMatchesFormat, kMatchesVersion);
  const auto frame = file.Read<std::int32_t>("frame", 2);
  const auto status = file.ReadList<std::int32_t>("status");
  const auto num_putative = file.ReadList<std::int32_t>("num_putative");
  const auto score = file.ReadList<double>("score");
  const auto pose = file.Read<double>("b_from_a", 7);
  const auto covariance = file.Read<double>("covariance", 36);
  const auto first_match = file.ReadList<std::int32_t>("first_match");
  const auto match = file.Read<std::int32_t>("match", 2);
  const std::size_t count = frame.rows;
  file.Demand(status.size() == count, "status");
  file.Demand(num_putative.size() == count, "num_putative");
  file.Demand(score.size() == count, "score");
  file.Demand(pose.rows == count, "b_from_a");
  file.Demand(covariance.rows == count, "covariance");
  file.Demand(first_match.size() == count + 1 && first_match.front() == 0 &&
                  static_cast<std::size_t>(first_match.back()) == match.rows &&
                  std::ranges::is_sorted(first_match),
              "first_match");
  std::vector<FramePair> pairs(count);
  for (std::size_t i = 0; i < count; ++i) {
    FramePair& pair = pairs[i];
    pair.frame_a = frame.values[2 * i];
    pair.frame_b = frame.values[2 * i + 1];
    file.Demand(pair.frame_a >= 0 && pair.frame_a < pair.frame_b, "frame");
    file.Demand(status[i] >= 0 && status[i] <= static_cast<int>(PairStatus::kUncertain), "status");
    file.Demand(num_putative[i] >= 0, "num_putative");
    pair.status = static_cast<PairStatus>(status[i]);
    pair.num_putative = num_putative[i];
    pair.score = score[i];
    pair.b_from_a = PoseAt(pose, i, path);
    pair.covariance = CovarianceAt(covariance, i);
    for (auto k = static_cast<std::size_t>(first_match[i]);
         k < static_cast<std::size_t>(first_match[i + 1]);
         ++k) {
      file.Demand(match.values[2 * k] >= 0 && match.values[2 * k + 1] >= 0, "match");
      pair.inliers.push_back({match.values[2 * k], match.values[2 * k + 1]});
    }
  }
  return pairs;
}

}  // namespace nightmap
