// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/scan_localize/template_search.h"

#include <algorithm>
#include <numbers>
#include <opencv2/imgproc.hpp>
#include <tuple>

#include "stages/laser/scan_localize/scan_candidates.h"
#include "stages/laser/scan_localize/search_box.h"
#include "stages/laser/scan_localize/submap_image.h"

namespace nightmap {
namespace {

constexpr int kFollow_px = 2;  // how far a maximum may lie from that of the level above

cv::Mat ToMat(const SubmapImage& submap) {
  return {submap.image.height,
          submap.image.width,
          CV_8U,
          const_cast<std::uint8_t*>(submap.image.pixels.data())};
}

// The similarity at each pixel of the map that the robot may be at, 0 .. 1.
class LevelMatcher {
 public:
  LevelMatcher(const TemplateOptions& options,
               const ScanMap& map,
               const ScanQuery& query,
               const SearchBox& box,
               int level)
      : options_(options),
        query_(query),
        resolution_m_(options.resolution_m * (1 << level)),
        image_(ImageOfMap(map.Grid(), resolution_m_, box.low - Margin(), box.high + Margin())) {}

  double Resolution_m() const { return resolution_m_; }
  Eigen::Vector2i PixelOf(const Eigen::Vector2d& point_in_map) const {
    return image_.PixelOf(point_in_map);
  }
  Eigen::Vector2d CenterOf(const Eigen::Vector2i& pixel) const {
    return image_.origin + resolution_m_ * (pixel.cast<double>().array() + 0.5).matrix();
  }

  // At the pixels from `first` to `last`, for a robot in the middle of each.
  cv::Mat Match(double heading_rad,
                const Eigen::Vector2i& first,
                const Eigen::Vector2i& last) const {
    const SubmapImage submap =
        ImageOfSubmap(query_, heading_rad, resolution_m_, options_.max_range_m);
    const Eigen::Vector2i corner = first - submap.PixelOf({0, 0}), size = last - first;
    const cv::Rect window(
        corner.x(), corner.y(), size.x() + submap.image.width, size.y() + submap.image.height);
    const cv::Mat seen = ToMat(submap) != kNonFreePixel;
    cv::Mat scores;
    cv::matchTemplate(ToMat(image_)(window), ToMat(submap), scores, cv::TM_CCOEFF_NORMED, seen);
    // Where the map has one value alone, a coefficient is a quotient of rounding errors.
    scores.setTo(0, (scores > 1.001) | (scores < 0) | (scores != scores));
    return scores;
  }

 private:
  // Holds the template wherever the robot is, and what is followed beyond the box.
  Eigen::Vector2d Margin() const {
    double margin_m = options_.max_range_m + (2 * kFollow_px + 2) * resolution_m_;
    double farthest_laser_m = 0;
    for (const QueryScan& scan : query_.scans) {
      farthest_laser_m = std::max(farthest_laser_m, scan.query_from_laser.translation.norm());
    }
    return Eigen::Vector2d::Constant(margin_m + farthest_laser_m +
                                     2 * options_.resolution_m * (1 << options_.num_levels));
  }

  const TemplateOptions& options_;
  const ScanQuery& query_;
  double resolution_m_;
  SubmapImage image_;
};

// The best first, by place and heading where they are equal; of those at one place the best.
std::vector<TemplateMatch> SuppressNonMaxima(std::vector<TemplateMatch> matches,
                                             const TemplateOptions& options) {
  std::ranges::sort(matches, [](const TemplateMatch& a, const TemplateMatch& b) {
    const auto key = [](const TemplateMatch& match) {
      const Rigid2& pose = match.map_from_query;
      return std::tuple(-match.score, pose.heading_rad, pose.translation.x(), pose.translation.y());
    };
    return key(a) < key(b);
  });
  std::vector<TemplateMatch> maxima;
  for (const TemplateMatch& match : matches) {
    if (match.score < options.min_share_of_best * matches.front().score) break;
    if (maxima.size() == static_cast<std::size_t>(options.max_candidates)) break;
    const auto is_same = [&](const TemplateMatch& other) {
      return IsSamePlace(match.map_from_query, other.map_from_query, options.suppression_radius_m);
    };
    if (std::ranges::none_of(maxima, is_same)) maxima.push_back(match);
  }
  return maxima;
}

double AngleStep_rad(const TemplateOptions& options) {
  return 2 * std::numbers::pi / options.num_angles;
}

std::vector<TemplateMatch> MatchEverywhere(const TemplateOptions& options,
                                           const ScanMap& map,
                                           const ScanQuery& query,
                                           const SearchBox& box) {
  const LevelMatcher matcher(options, map, query, box, options.num_levels - 1);
  const Eigen::Vector2i first = matcher.PixelOf(box.low), last = matcher.PixelOf(box.high);
  std::vector<TemplateMatch> matches;
  for (int angle = 0; angle < options.num_angles; ++angle) {
    const double heading_rad = WrapAngle_rad(angle * AngleStep_rad(options));
    const cv::Mat scores = matcher.Match(heading_rad, first, last);
    cv::Mat largest;
    cv::dilate(scores, largest, cv::Mat());
    for (int y = 0; y < scores.rows; ++y) {
      for (int x = 0; x < scores.cols; ++x) {
        const double score = scores.at<float>(y, x);
        if (score <= 0 || scores.at<float>(y, x) < largest.at<float>(y, x)) continue;
        const Eigen::Vector2d place = matcher.CenterOf(first + Eigen::Vector2i(x, y));
        if (CanBeAt(map, query, place)) matches.push_back({{heading_rad, place}, score});
      }
    }
  }
  return SuppressNonMaxima(std::move(matches), options);
}

TemplateMatch Follow(const LevelMatcher& matcher, const TemplateMatch& above, double step_rad) {
  const Eigen::Vector2i middle = matcher.PixelOf(above.map_from_query.translation);
  const Eigen::Vector2i reach(kFollow_px, kFollow_px);
  TemplateMatch best;
  for (const double turn_rad : {0.0, -step_rad, step_rad}) {
    const double heading_rad = WrapAngle_rad(above.map_from_query.heading_rad + turn_rad);
    const cv::Mat scores = matcher.Match(heading_rad, middle - reach, middle + reach);
    double score = 0;
    cv::Point at;
    cv::minMaxLoc(scores, nullptr, &score, nullptr, &at);
    if (score <= best.score) continue;
    const Eigen::Vector2i pixel = middle - reach + Eigen::Vector2i(at.x, at.y);
    best = {{heading_rad, matcher.CenterOf(pixel)}, score};
  }
  return best;
}

}  // namespace

std::vector<TemplateMatch> SearchTemplate(const TemplateOptions& options,
                                          const ScanMap& map,
                                          const ScanQuery& query) {
  const SearchBox box = BoxOf(map, query);
  std::vector<TemplateMatch> matches = MatchEverywhere(options, map, query, box);
  double step_rad = AngleStep_rad(options);
  for (int level = options.num_levels - 2; level >= 0; --level) {
    step_rad /= 2;
    const LevelMatcher matcher(options, map, query, box, level);
    for (TemplateMatch& match : matches) match = Follow(matcher, match, step_rad);
    std::erase_if(matches, [](const TemplateMatch& match) { return match.score <= 0; });
    matches = SuppressNonMaxima(std::move(matches), options);
  }
  return matches;
}

}  // namespace nightmap
