// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/localize/localize_report.h"

#include <algorithm>
#include <map>
#include <string>

#include "pipeline/base/median.h"

namespace nightmap {
namespace {}  // namespace

nlohmann::json SummarizeQueries(const std::vector<QueryResult>& queries) {
  std::vector<double> num_inliers;
  std::vector<double> errors_px;
  std::vector<double> sigmas_m;
  std::map<std::string, int> verdicts{
      {"located", 0}, {"ambiguous", 0}, {"not_in_map", 0}, {"no_features", 0}, {"unreadable", 0}};
  std::map<std::string, int> reasons;
  for (const QueryResult& query : queries) {
    ++verdicts[std::string(QueryVerdictText(query.verdict))];
    if (!query.IsLocated()) {
      ++reasons[query.reason];
      continue;
    }
    num_inliers.push_back(query.num_inliers);
    errors_px.push_back(query.reprojection_error_px);
    sigmas_m.push_back(query.position_sigma_m);
  }
  nlohmann::json report;
  report["num_queries"] = queries.size();
  report["num_by_verdict"] = verdicts;
  report["num_not_located_by_reason"] = reasons;
  report["median_num_inliers"] = Median(num_inliers);
  report["median_reprojection_error_px"] = Median(errors_px);
  report["median_position_sigma_m"] = Median(sigmas_m);
  return report;
}

}  // namespace nightmap
