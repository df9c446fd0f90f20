// SPDX-License-Identifier: Apache-2.0
#include "stages/localize/localize_report.h"

#include <algorithm>
#include <map>
#include <string>

namespace nightmap {
namespace {

double Median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace

nlohmann::json SummarizeQueries(const std::vector<QueryResult>& queries) {
  std::vector<double> num_inliers;
  std::vector<double> errors_px;
  std::map<std::string, int> failures{
      {"no_features", 0}, {"too_few_inliers", 0}, {"too_few_matches", 0}, {"unreadable_image", 0}};
  for (const QueryResult& query : queries) {
    if (query.IsLocated()) {
      num_inliers.push_back(query.num_inliers);
      errors_px.push_back(query.reprojection_error_px);
    } else {
      ++failures[query.reason];
    }
  }
  nlohmann::json report;
  report["num_queries"] = queries.size();
  report["num_located"] = num_inliers.size();
  report["num_failed"] = queries.size() - num_inliers.size();
  report["num_failed_by_reason"] = failures;
  report["median_num_inliers"] = Median(num_inliers);
  report["median_reprojection_error_px"] = Median(errors_px);
  return report;
}

}  // namespace nightmap
