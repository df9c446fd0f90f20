// SPDX-License-Identifier: Apache-2.0
// Arrays of features/shard_NNNN.h5 (F frames, N features in total, D bytes per descriptor):
//   text extraction; kind 1; frame_idx F;
//   reference_frame_idx F (described frame that frame i was tracked from; -1: i is described);
//   first_feature F+1 (features of frame i are [first[i], first[i+1]));
//   keypoint_px N x 2, raw_keypoint_px N x 2, scale_px N, depth_m N;
//   reference_feature: one per feature of tracked frames, in order; descriptor x D: one per other
//   feature.
#include "pipeline/io/features_io.h"

#include <algorithm>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kFeaturesFormat[] = "nightmap features";
constexpr int kFeaturesVersion = 2;

Array<float> Flatten(const std::vector<Eigen::Vector2f>& points) {
  Array<float> array{points.size(), 2, {}};
  array.values.reserve(points.size() * 2);
  for (const Eigen::Vector2f& point : points) {
    array.values.push_back(point.x());
    array.values.push_back(point.y());
  }
  return array;
}

template <typename T>
void Append(const std::vector<T>& source, std::vector<T>* target) {
  target->insert(target->end(), source.begin(), source.end());
}

// Joins all frames of a shard, as the file stores them.
FrameFeatures Concatenate(const FeaturesShard& shard) {
  FrameFeatures all;
  for (const FrameFeatures& frame : shard.frames) {
    Append(frame.keypoints_px, &all.keypoints_px);
    Append(frame.raw_keypoints_px, &all.raw_keypoints_px);
    Append(frame.scales_px, &all.scales_px);
    Append(frame.depths_m, &all.depths_m);
    Append(frame.descriptors, &all.descriptors);
    Append(frame.reference_features, &all.reference_features);
  }
  return all;
}

std::vector<Eigen::Vector2f> Points(const Array<float>& array, std::size_t begin, std::size_t end) {
  std::vector<Eigen::Vector2f> points;
  points.reserve(end - begin);
  for (std::size_t i = begin; i < end; ++i) {
    points.emplace_back(array.values[2 * i], array.values[2 * i + 1]);
  }
  return points;
}

template <typename T>
std::vector<T> Slice(const std::vector<T>& values, std::size_t begin, std::size_t end) {
  return {values.begin() + static_cast<std::ptrdiff_t>(begin),
          values.begin() + static_cast<std::ptrdiff_t>(end)};
}

void CheckFirstFeature(const std::vector<std::int32_t>& first,
                       std::size_t num_frames,
                       std::size_t num_features,
                       const Hdf5Reader& file) {
  file.Demand(first.size() == num_frames + 1 && first.front() == 0 &&
                  static_cast<std::size_t>(first.back()) == num_features,
              "first_feature");
  for (std::size_t i = 0; i < num_frames; ++i) {
    file.Demand(first[i] <= first[i + 1], "first_feature");
  }
}

// A tracked frame must continue features of a described frame before it in the same file.
void CheckReference(const FeaturesShard& shard,
                    const FrameFeatures& frame,
                    const Hdf5Reader& file) {
  const auto reference =
      std::ranges::find(shard.frames, frame.reference_frame_idx, &FrameFeatures::frame_idx);
  file.Demand(reference != shard.frames.end() && reference->frame_idx < frame.frame_idx &&
                  reference->IsDescribed(),
              "reference_frame_idx");
  for (const int feature : frame.reference_features) {
    file.Demand(feature >= 0 && feature < reference->NumFeatures(), "reference_feature");
  }
}

bool AreOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features) {
  bool fits = !frames.empty() && frames.size() == features.frames.size();
  for (std::size_t i = 0; fits && i < frames.size(); ++i) {
    fits = frames[i].frame_idx == features.frames[i].frame_idx &&
           frames[i].frame_idx == frames.front().frame_idx + static_cast<int>(i);
  }
  return fits;
}

// Whether the first frame of a shard is the one after the last before it.
bool Follows(const FeaturesShard& shard, const FeaturesShard& before) {
  return shard.frames.empty() || before.frames.empty() ||
         shard.frames.front().frame_idx == before.frames.back().frame_idx + 1;
}

// Concatenates the shards in order, after check(i, shard) of each.
template <typename Check>
FeaturesShard ReadShards(const std::vector<std::filesystem::path>& paths, const Check& check) {
  FeaturesShard all;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    FeaturesShard shard = ReadFeatures(paths[i]);
    check(i, shard);
    if (i == 0) {
      all = std::move(shard);
      continue;
    }
    if (shard.kind != all.kind || shard.extraction != all.extraction) {
      throw DataError(
          "{}: extracted with other options than {}; delete the features folder of this site and "
          "run make",
          paths[i].string(),
          paths[0].string());
    }
    if (!Follows(shard, all)) {
      throw DataError(
          "{} does not hold the frames that follow those of {}; one of them is damaged or another "
          "site's, or they are not in order: delete both and run make again",
          paths[i].string(),
          paths[i - 1].string());
    }
    std::ranges::move(shard.frames, std::back_inserter(all.frames));
  }
  return all;
}

}  // namespace

int DescriptorSize(DescriptorKind kind) {
  switch (kind) {
    case DescriptorKind::kRootSift:
      return 128;
    case DescriptorKind::kOrb:
      return 32;
    case DescriptorKind::kBrisk:
      return 64;
  }
  throw DataError("unknown descriptor kind {}", static_cast<int>(kind));
}

void WriteFeatures(const std::filesystem::path& path,
                   const FeaturesShard& shard,
                   const std::string& config) {
  const FrameFeatures all = Concatenate(shard);
  std::vector<std::int32_t> frame_idx, reference_frame_idx, first_feature = {0};
  for (const FrameFeatures& frame : shard.frames) {
    frame_idx.push_back(frame.frame_idx);
    reference_frame_idx.push_back(frame.reference_frame_idx);
    first_feature.push_back(first_feature.back() + frame.NumFeatures());
  }
  Hdf5Writer file(
      path, kFeaturesFormat, kFeaturesVersion, config, "pixels of the color image; depth_m metres");
  file.WriteText("extraction", shard.extraction);
  file.WriteList<std::int32_t>("kind", {static_cast<std::int32_t>(shard.kind)});
  file.WriteList("frame_idx", frame_idx);
  file.WriteList("reference_frame_idx", reference_frame_idx);
  file.WriteList("first_feature", first_feature);
  file.Write("keypoint_px", Flatten(all.keypoints_px));
  file.Write("raw_keypoint_px", Flatten(all.raw_keypoints_px));
  file.WriteList("scale_px", all.scales_px);
  file.WriteList("depth_m", all.depths_m);
  file.WriteList<std::int32_t>("reference_feature", all.reference_features);
  const auto size = static_cast<std::size_t>(shard.descriptor_size);
  file.Write("descriptor",
             Array<std::uint8_t>{all.descriptors.size() / size, size, all.descriptors});
  file.Close();
}

FeaturesShard ReadFeatures(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kFeaturesFormat, kFeaturesVersion);
  FeaturesShard shard;
  shard.extraction = file.ReadText("extraction");
  const auto kind = file.ReadList<std::int32_t>("kind");
  file.Demand(kind.size() == 1 && kind[0] >= 0 && kind[0] <= 2, "kind");
  shard.kind = static_cast<DescriptorKind>(kind[0]);
  shard.descriptor_size = DescriptorSize(shard.kind);
  const auto size = static_cast<std::size_t>(shard.descriptor_size);

  const auto frame_idx = file.ReadList<std::int32_t>("frame_idx");
  const auto reference_frame_idx = file.ReadList<std::int32_t>("reference_frame_idx");
  const auto first = file.ReadList<std::int32_t>("first_feature");
  const auto keypoints = file.Read<float>("keypoint_px", 2);
  const auto raw_keypoints = file.Read<float>("raw_keypoint_px", 2);
  const auto scales = file.ReadList<float>("scale_px");
  const auto depths = file.ReadList<float>("depth_m");
  const auto reference_features = file.ReadList<std::int32_t>("reference_feature");
  const auto descriptors = file.Read<std::uint8_t>("descriptor", size);
  file.Demand(reference_frame_idx.size() == frame_idx.size(), "reference_frame_idx");
  CheckFirstFeature(first, frame_idx.size(), keypoints.rows, file);
  file.Demand(raw_keypoints.rows == keypoints.rows, "raw_keypoint_px");
  file.Demand(scales.size() == keypoints.rows, "scale_px");
  file.Demand(depths.size() == keypoints.rows, "depth_m");
  const auto is_negative = [](float value) { return value < 0; };
  file.Demand(std::ranges::none_of(scales, is_negative), "scale_px");
  file.Demand(std::ranges::none_of(depths, is_negative), "depth_m");
  file.Demand(descriptors.rows + reference_features.size() == keypoints.rows, "descriptor");

  std::size_t first_described = 0;
  std::size_t first_tracked = 0;
  for (std::size_t i = 0; i < frame_idx.size(); ++i) {
    const auto begin = static_cast<std::size_t>(first[i]);
    const auto end = static_cast<std::size_t>(first[i + 1]);
    FrameFeatures& frame = shard.frames.emplace_back();
    frame.frame_idx = frame_idx[i];
    frame.reference_frame_idx = reference_frame_idx[i];
    frame.keypoints_px = Points(keypoints, begin, end);
    frame.raw_keypoints_px = Points(raw_keypoints, begin, end);
    frame.scales_px = Slice(scales, begin, end);
    frame.depths_m = Slice(depths, begin, end);
    if (frame.IsDescribed()) {
      file.Demand(first_described + end - begin <= descriptors.rows, "descriptor");
      frame.descriptors =
          Slice(descriptors.values, first_described * size, (first_described + end - begin) * size);
      first_described += end - begin;
    } else {
      file.Demand(first_tracked + end - begin <= reference_features.size(), "reference_feature");
      frame.reference_features =
          Slice(reference_features, first_tracked, first_tracked + end - begin);
      first_tracked += end - begin;
      CheckReference(shard, frame, file);
    }
  }
  return shard;
}

FeaturesShard ReadFeatures(const std::vector<std::filesystem::path>& paths) {
  return ReadShards(paths, [](std::size_t, const FeaturesShard&) {});
}

FeaturesShard ReadFeatures(const std::vector<std::filesystem::path>& paths,
                           const std::vector<std::filesystem::path>& lists) {
  if (paths.size() != lists.size()) {
    throw UsageError(
        "give as many --in features as --in frames: {} and {}", paths.size(), lists.size());
  }
  return ReadShards(paths, [&](std::size_t i, const FeaturesShard& shard) {
    if (AreOfFrames(ReadFrames(lists[i]), shard)) return;
    throw DataError(
        "{} does not list the frames that {} has features of; one of them is damaged or another "
        "site's: delete both and run make again",
        lists[i].string(),
        paths[i].string());
  });
}

void CheckFeaturesOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features) {
  if (AreOfFrames(frames, features)) return;
  throw InputError({{"features"}, {"frames"}}, "the features are not of the listed frames");
}

}  // namespace nightmap
