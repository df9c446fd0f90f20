// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/features_io.h"

#include <algorithm>
#include <optional>

#include "pipeline/base/error.h"
#include "pipeline/base/input_error.h"
#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kFeaturesFormat[] = "nightmap features";
constexpr int kFeaturesVersion = 2;
constexpr char kFirstFeature[] = "first_feature";

constexpr auto kKeypoints = Hdf5Table<Eigen::Vector2f>(Hdf5Column("keypoint_px", kItself));
constexpr auto kRawKeypoints = Hdf5Table<Eigen::Vector2f>(Hdf5Column("raw_keypoint_px", kItself));
constexpr auto kScales = Hdf5Table<float>(Hdf5Column("scale_px", kItself).Elements(kNotNegative));
constexpr auto kDepths = Hdf5Table<float>(Hdf5Column("depth_m", kItself).Elements(kNotNegative));
// One for each feature of tracked frames.
constexpr auto kReferences = Hdf5Table<int>(Hdf5Column("reference_feature", kItself));

template <typename T>
std::vector<T> Slice(const std::vector<T>& values, std::size_t begin, std::size_t end) {
  return {values.begin() + static_cast<std::ptrdiff_t>(begin),
          values.begin() + static_cast<std::ptrdiff_t>(end)};
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

FeaturesShard ReadHeads(const Hdf5Reader& file) {
  FeaturesShard shard;
  shard.extraction = file.ReadText("extraction");
  const auto kind = file.ReadOne<std::int32_t>("kind");
  file.Demand(kind >= 0 && kind <= 2, "kind");
  shard.kind = static_cast<DescriptorKind>(kind);
  shard.descriptor_size = DescriptorSize(shard.kind);
  const auto frame_idx = file.ReadList<std::int32_t>("frame_idx");
  const auto reference_frame_idx = file.ReadList<std::int32_t>("reference_frame_idx");
  file.Demand(reference_frame_idx.size() == frame_idx.size(), "reference_frame_idx");
  shard.frames.resize(frame_idx.size());
  for (std::size_t i = 0; i < frame_idx.size(); ++i) {
    shard.frames[i].frame_idx = frame_idx[i];
    shard.frames[i].reference_frame_idx = reference_frame_idx[i];
  }
  return shard;
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
  std::vector<std::int32_t> frame_idx, reference_frame_idx, first_feature = {0};
  std::vector<std::uint8_t> descriptors;  // of the features of described frames
  for (const FrameFeatures& frame : shard.frames) {
    frame_idx.push_back(frame.frame_idx);
    reference_frame_idx.push_back(frame.reference_frame_idx);
    first_feature.push_back(first_feature.back() + frame.NumFeatures());
    descriptors.insert(descriptors.end(), frame.descriptors.begin(), frame.descriptors.end());
  }
  Hdf5Writer file(
      path, kFeaturesFormat, kFeaturesVersion, config, "pixels of the color image; depth_m metres");
  file.WriteText("extraction", shard.extraction);
  file.WriteList<std::int32_t>("kind", {static_cast<std::int32_t>(shard.kind)});
  file.WriteList("frame_idx", frame_idx);
  file.WriteList("reference_frame_idx", reference_frame_idx);
  file.WriteList(kFirstFeature, first_feature);
  const auto of_all = [&](auto list) { return Flattened(shard.frames, list); };
  kKeypoints.Write(of_all(&FrameFeatures::keypoints_px), &file);
  kRawKeypoints.Write(of_all(&FrameFeatures::raw_keypoints_px), &file);
  kScales.Write(of_all(&FrameFeatures::scales_px), &file);
  kDepths.Write(of_all(&FrameFeatures::depths_m), &file);
  kReferences.Write(of_all(&FrameFeatures::reference_features), &file);
  const auto size = static_cast<std::size_t>(shard.descriptor_size);
  const std::size_t num_described = descriptors.size() / size;
  file.Write("descriptor", Array<std::uint8_t>{num_described, size, std::move(descriptors)});
  file.Close();
}

FeatureHeads ReadFeatureHeads(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kFeaturesFormat, kFeaturesVersion);
  FeatureHeads heads{ReadHeads(file), {}};
  const auto first =
      file.ReadOffsets<std::int32_t>(kFirstFeature, heads.shard.frames.size(), std::nullopt);
  for (std::size_t i = 1; i < first.size(); ++i) {
    heads.num_features.push_back(static_cast<int>(first[i] - first[i - 1]));
  }
  return heads;
}

FeaturesShard ReadFeatures(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kFeaturesFormat, kFeaturesVersion);
  FeaturesShard shard = ReadHeads(file);
  const auto size = static_cast<std::size_t>(shard.descriptor_size);
  const auto keypoints = kKeypoints.Read(file);
  const auto raw_keypoints = kRawKeypoints.Read(file);
  const auto scales = kScales.Read(file);
  const auto depths = kDepths.Read(file);
  const auto reference_features = kReferences.Read(file);
  const auto first =
      file.ReadOffsets<std::int32_t>(kFirstFeature, shard.frames.size(), keypoints.size());
  const auto descriptors = file.Read<std::uint8_t>("descriptor", size);
  file.Demand(raw_keypoints.size() == keypoints.size(), "raw_keypoint_px");
  file.Demand(scales.size() == keypoints.size(), "scale_px");
  file.Demand(depths.size() == keypoints.size(), "depth_m");
  file.Demand(descriptors.rows + reference_features.size() == keypoints.size(), "descriptor");

  std::size_t first_described = 0;
  std::size_t first_tracked = 0;
  for (std::size_t i = 0; i < shard.frames.size(); ++i) {
    const std::size_t begin = first[i], end = first[i + 1];
    FrameFeatures& frame = shard.frames[i];
    frame.keypoints_px = Slice(keypoints, begin, end);
    frame.raw_keypoints_px = Slice(raw_keypoints, begin, end);
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

bool AreOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features) {
  bool fits = !frames.empty() && frames.size() == features.frames.size();
  for (std::size_t i = 0; fits && i < frames.size(); ++i) {
    fits = frames[i].frame_idx == features.frames[i].frame_idx &&
           frames[i].frame_idx == frames.front().frame_idx + static_cast<int>(i);
  }
  return fits;
}

void CheckFeaturesOfFrames(const std::vector<FrameRecord>& frames, const FeaturesShard& features) {
  if (AreOfFrames(frames, features)) return;
  throw InputError({{"features"}, {"frames"}}, "the features are not of the listed frames");
}

}  // namespace nightmap
