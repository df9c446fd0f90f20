// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/inspect/inspect.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "pipeline/recording/scan_points.h"

namespace nightmap {
namespace {

constexpr double kGapFactor = 3;  // in medians

// Smallest and largest of the added numbers.
struct Extent {
  double min = std::numeric_limits<double>::infinity();
  double max = -std::numeric_limits<double>::infinity();
  void Add(double value) {
    min = std::min(min, value);
    max = std::max(max, value);
  }
};

std::string DescribeValues(const Signal& signal) {
  const auto& values = RowOf(signal.kind).values;
  std::string text;
  for (std::size_t i = 0; i < values.size(); ++i) {
    Extent extent;
    for (const SignalSample& sample : signal.samples) {
      extent.Add(sample.value[static_cast<Eigen::Index>(i)]);
    }
    text += fmt::format("{}{} {:.4g} to {:.4g} {}",
                        i == 0 ? "" : ", ",
                        values[i].name,
                        extent.min,
                        extent.max,
                        values[i].unit);
  }
  return text;
}

std::string DescribeScans(const Signal& signal) {
  Extent beams, range_m, step_deg;
  std::size_t num_ranges = 0, num_hits = 0;
  for (const SignalSample& scan : signal.samples) {
    beams.Add(static_cast<double>(scan.ranges_m.size()));
    step_deg.Add(scan.value[1] * 180 / 3.14159265358979);
    for (const float range : scan.ranges_m) {
      ++num_ranges;
      if (!IsHit(scan, range)) continue;
      ++num_hits;
      range_m.Add(range);
    }
  }
  const std::string ranges =
      num_hits == 0 ? "" : fmt::format(", {:.3g} to {:.4g} m", range_m.min, range_m.max);
  return fmt::format("{} to {} beams, {:.3g} to {:.3g} deg apart{}, {:.1f} % hit nothing",
                     beams.min,
                     beams.max,
                     step_deg.min,
                     step_deg.max,
                     ranges,
                     100.0 * static_cast<double>(num_ranges - num_hits) /
                         static_cast<double>(std::max<std::size_t>(num_ranges, 1)));
}

ChannelSeries DescribeSignal(const Signal& signal) {
  std::vector<std::int64_t> times_ns;
  for (const SignalSample& sample : signal.samples) times_ns.push_back(sample.time_ns);
  ChannelSeries series = DescribeTimes(signal.sensor_id, NameOf(signal.kind), times_ns);
  if (!signal.samples.empty()) {
    series.details =
        signal.kind == SignalKind::kScan ? DescribeScans(signal) : DescribeValues(signal);
  }
  return series;
}

// The frames that have the channel.
ChannelSeries DescribeChannel(const std::string& source,
                              const std::string& channel,
                              const RawSequence& sequence) {
  std::vector<std::int64_t> times_ns;
  for (const RawFrame& frame : sequence.frames) {
    for (const auto& [name, file] : ChannelsOf(frame)) {
      if (name == channel && !file->path.empty()) times_ns.push_back(frame.time_ns);
    }
  }
  return DescribeTimes(source, channel, times_ns);
}

double Seconds(std::int64_t time_ns) { return static_cast<double>(time_ns) / 1e9; }

std::string OverlapText(const ChannelSeries& frames, const ChannelSeries& signal) {
  const std::int64_t common_ns =
      std::min(frames.last_ns, signal.last_ns) - std::max(frames.first_ns, signal.first_ns);
  const double duration_s = std::max(Seconds(frames.last_ns - frames.first_ns), 1e-9);
  return fmt::format("{} and {}: {:.1f} s, {:.0f} % of the recording\n",
                     frames.source,
                     signal.source,
                     std::max(0.0, Seconds(common_ns)),
                     std::clamp(100 * Seconds(common_ns) / duration_s, 0.0, 100.0));
}

bool IsColor(const ChannelSeries& series) { return series.channel == "color"; }
bool IsSignal(const ChannelSeries& series) { return KindOf(series.channel).has_value(); }

}  // namespace

ChannelSeries DescribeTimes(std::string source,
                            std::string channel,
                            const std::vector<std::int64_t>& times_ns) {
  ChannelSeries series{std::move(source), std::move(channel), times_ns.size(), 0, 0, 0, 0, 0, ""};
  if (times_ns.empty()) return series;
  series.first_ns = times_ns.front();
  series.last_ns = times_ns.back();
  std::vector<std::int64_t> intervals_ns;
  for (std::size_t i = 1; i < times_ns.size(); ++i) {
    intervals_ns.push_back(times_ns[i] - times_ns[i - 1]);
  }
  if (intervals_ns.empty()) return series;
  std::ranges::sort(intervals_ns);
  const double median_s = Seconds(intervals_ns[intervals_ns.size() / 2]);
  series.rate_hz = median_s > 0 ? 1 / median_s : 0;
  series.largest_gap_s = Seconds(intervals_ns.back());
  series.num_gaps = static_cast<std::size_t>(std::ranges::count_if(
      intervals_ns, [&](std::int64_t ns) { return Seconds(ns) > kGapFactor * median_s; }));
  return series;
}

std::vector<ChannelSeries> RunInspect(const std::vector<RawSequence>& sequences,
                                      const std::vector<Signal>& signals,
                                      const PictureSampler& sample) {
  std::vector<ChannelSeries> all;
  for (std::size_t s = 0; s < sequences.size(); ++s) {
    const std::string source = fmt::format("recording {}", s);
    const SampledPictures pictures = sample(sequences[s]);
    for (const std::string& channel : pictures.Channels()) {
      all.push_back(DescribeChannel(source, channel, sequences[s]));
      all.back().details = pictures.Describe(channel);
    }
    std::vector<std::int64_t> truth_ns;
    for (const StampedPose& pose : sequences[s].ground_truth) truth_ns.push_back(pose.time_ns);
    if (!truth_ns.empty()) all.push_back(DescribeTimes(source, "ground truth", truth_ns));
  }
  for (const Signal& signal : signals) all.push_back(DescribeSignal(signal));
  return all;
}

std::string InspectionText(const std::vector<ChannelSeries>& all) {
  std::size_t width = 6;
  for (const ChannelSeries& series : all) width = std::max(width, series.source.size());
  std::string text = fmt::format("{:<{}}  {:<12}  {:>8}  {:>8}  {:>16}  {:>10}  {:>8}  {:>6}  {}\n",
                                 "source",
                                 width,
                                 "channel",
                                 "count",
                                 "rate Hz",
                                 "start s",
                                 "duration s",
                                 "gap s",
                                 "gaps",
                                 "values");
  for (const ChannelSeries& series : all) {
    text +=
        fmt::format("{:<{}}  {:<12}  {:>8}  {:>8.2f}  {:>16.3f}  {:>10.2f}  {:>8.3f}  {:>6}  {}\n",
                    series.source,
                    width,
                    series.channel,
                    series.count,
                    series.rate_hz,
                    Seconds(series.first_ns),
                    Seconds(series.last_ns - series.first_ns),
                    series.largest_gap_s,
                    series.num_gaps,
                    series.details);
  }
  text += fmt::format("gap: the longest interval; gaps: intervals of more than {} medians\n",
                      kGapFactor);
  for (const ChannelSeries& frames : all) {
    for (const ChannelSeries& signal : all) {
      const bool has_both = frames.count > 0 && signal.count > 0;
      if (IsColor(frames) && IsSignal(signal) && has_both) text += OverlapText(frames, signal);
    }
  }
  return text;
}

}  // namespace nightmap
