// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/landmarks_io.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <numeric>
#include <utility>

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kLandmarksFormat[] = "nightmap.landmarks";
constexpr int kLandmarksVersion = 3;  // 3: regions
constexpr int kMaxWordLevels = 64;
constexpr char kUnits[] = "metres, map frame (z up); quaternions x y z w; times in nanoseconds";

constexpr auto kPositions =
    Hdf5Table<Eigen::Vector3d>(Hdf5Column("landmarks/position_in_map_m", kItself));
constexpr auto kPositionSigmas = Hdf5Table<float>(
    Hdf5Column("landmarks/position_sigma_m", kItself).Elements(kNotNegative, "is negative"));

constexpr auto kMapKeyframes =
    Hdf5Table<MapKeyframe>(Hdf5Column("keyframes/frame_idx", &MapKeyframe::frame_idx),
                           Hdf5Column("keyframes/time_ns", &MapKeyframe::time_ns),
                           Hdf5Column("keyframes/map_from_camera", &MapKeyframe::map_from_camera));

constexpr auto kLandmarkKeyframes = Hdf5Table<std::vector<int>>(
    Hdf5Lists("observations/offsets",
              kItself,
              Hdf5Table<int>(Hdf5Column("observations/keyframe_idx", kItself))));
constexpr auto kLandmarkFeatures = Hdf5Table<int>(
    Hdf5Column("observations/feature_idx", kItself).Elements(kNotNegative, "is negative"));

// In the file, a region without a bound has the largest number there.
constexpr double kFarthest_m = std::numeric_limits<double>::max();
constexpr auto kRegions = Hdf5Table<LandmarkRegion>(
    Hdf5Column("regions/min_m", MemberOf(&LandmarkRegion::box, &Rectangle::min_m)),
    Hdf5Column("regions/max_m", MemberOf(&LandmarkRegion::box, &Rectangle::max_m))
        .Rows(
            [](const LandmarkRegion& r) {
              return (r.box.min_m.array() < r.box.max_m.array()).all();
            },
            "is not above the minimum"),
    Hdf5Column("regions/num_landmarks", &LandmarkRegion::num_landmarks)
        .Elements(kNotNegative, "is negative"),
    Hdf5Lists("regions/keyframe_offsets",
              &LandmarkRegion::keyframes,
              Hdf5Table<int>(Hdf5Column("regions/keyframe_idx", kItself))));

std::string GroupOf(std::size_t region) { return fmt::format("region_{}/", region); }

// Keyframes that see any landmark, ascending.
std::vector<int> SeeingKeyframes(const LandmarkMap& map) {
  std::vector<bool> sees;
  for (const auto& list : map.landmark_keyframes) {
    for (const int keyframe : list) {
      const auto i = static_cast<std::size_t>(keyframe);
      if (i >= sees.size()) sees.resize(i + 1);
      sees[i] = true;
    }
  }
  std::vector<int> seeing;
  for (std::size_t i = 0; i < sees.size(); ++i) {
    if (sees[i]) seeing.push_back(static_cast<int>(i));
  }
  return seeing;
}

void ReadObservations(const Hdf5Reader& reader, std::size_t num_keyframes, LandmarkMap* map) {
  map->landmark_keyframes = kLandmarkKeyframes.Read(reader);
  const auto features = kLandmarkFeatures.Read(reader);
  reader.DemandIndices(map->landmark_keyframes, num_keyframes, "observations/keyframe_idx");
  reader.Demand(map->landmark_keyframes.size() == map->positions_in_map.size(),
                "observations/offsets",
                "has another length");
  auto first = features.begin();
  for (const auto& list : map->landmark_keyframes) {
    reader.Demand(!list.empty(),
                  "observations/offsets",
                  "decreases, or has a landmark that no keyframe sees");
    reader.Demand(std::ranges::adjacent_find(list, std::greater_equal<>()) == list.end(),
                  "observations/keyframe_idx",
                  "is not ascending");
    const auto size = static_cast<std::ptrdiff_t>(list.size());
    reader.Demand(features.end() - first >= size, "observations/feature_idx", "has another length");
    map->landmark_features.emplace_back(first, first + size);
    first += size;
  }
  reader.Demand(first == features.end(), "observations/feature_idx", "has another length");
}

void ReadPositions(const Hdf5Reader& reader, LandmarkMap* map) {
  map->positions_in_map = kPositions.Read(reader);
  map->position_sigmas_m = kPositionSigmas.Read(reader);
  reader.Demand(map->position_sigmas_m.size() == map->positions_in_map.size(),
                "landmarks/position_sigma_m",
                "has another length");
}

void CheckEveryLandmarkDescribed(const Hdf5Reader& reader, const LandmarkMap& map) {
  int expected = -1;
  for (const int landmark : map.descriptor_landmarks) {
    reader.Demand(landmark == expected || landmark == expected + 1,
                  "descriptors/landmark_idx",
                  "skips a landmark or is not ascending");
    expected = landmark;
  }
  reader.Demand(expected + 1 == map.NumLandmarks(), "descriptors/landmark_idx", "ends too early");
}

void ReadDescriptors(const Hdf5Reader& reader, LandmarkMap* map) {
  const auto size = static_cast<std::size_t>(DescriptorSize(map->kind));
  auto values = reader.Read<std::uint8_t>("descriptors/values", size);
  auto words = reader.Read<std::int32_t>("descriptors/words");
  map->descriptor_landmarks = reader.ReadList<std::int32_t>("descriptors/landmark_idx");
  const std::size_t num_descriptors = map->descriptor_landmarks.size();
  reader.Demand(values.rows == num_descriptors, "descriptors/values", "has another length");
  reader.Demand(
      words.rows == num_descriptors && words.cols == static_cast<std::size_t>(map->num_word_levels),
      "descriptors/words",
      "has another length");
  CheckEveryLandmarkDescribed(reader, *map);
  for (const std::int32_t word : words.values) {
    reader.Demand(word >= 0, "descriptors/words", "is negative");
  }
  map->descriptors = std::move(values.values);
  map->words = std::move(words.values);
}

LandmarkMap ReadHead(const Hdf5Reader& reader) {
  LandmarkMap head;
  const auto kind = reader.ReadOne<std::int32_t>("kind");
  reader.Demand(kind >= 0 && kind <= 2, "kind", "is not known");
  head.kind = static_cast<DescriptorKind>(kind);
  head.extraction = reader.ReadText("extraction");
  head.num_word_levels = reader.ReadOne<std::int32_t>("num_word_levels");
  reader.Demand(head.num_word_levels > 0, "num_word_levels");
  reader.Demand(head.num_word_levels <= kMaxWordLevels, "num_word_levels", "is too many levels");
  head.keyframes = kMapKeyframes.Read(reader);
  return head;
}

std::vector<LandmarkRegion> ReadRegions(const Hdf5Reader& reader, std::size_t num_keyframes) {
  auto regions = kRegions.Read(reader);
  std::int64_t left = std::numeric_limits<int>::max();
  for (const LandmarkRegion& region : regions) {
    reader.Demand(region.num_landmarks <= left, "regions/num_landmarks", "is too many");
    left -= region.num_landmarks;
    reader.DemandIndices({region.keyframes}, num_keyframes, "regions/keyframe_idx");
  }
  return regions;
}

void CheckIsOfRegion(const Hdf5Reader& reader,
                     const LandmarkRegion& region,
                     const LandmarkMap& map) {
  reader.Demand(map.NumLandmarks() == region.num_landmarks,
                "landmarks/position_in_map_m",
                "has another length than regions/num_landmarks says");
  for (const Eigen::Vector3d& position : map.positions_in_map) {
    reader.Demand(region.box.Contains(position.head<2>()),
                  "landmarks/position_in_map_m",
                  "lies outside of the region");
  }
  reader.Demand(SeeingKeyframes(map) == region.keyframes,
                "observations/keyframe_idx",
                "has other keyframes than regions/keyframe_idx says");
}

}  // namespace

LandmarksWriter::LandmarksWriter(const std::filesystem::path& path,
                                 const LandmarkMap& head,
                                 const std::string& config)
    : file_(path, kLandmarksFormat, kLandmarksVersion, config, kUnits) {
  file_.WriteText("extraction", head.extraction);
  file_.WriteList<std::int32_t>("kind", {static_cast<std::int32_t>(head.kind)});
  file_.WriteList<std::int32_t>("num_word_levels", {head.num_word_levels});
  kMapKeyframes.Write(head.keyframes, &file_);
}

void LandmarksWriter::Write(const Rectangle& box, const LandmarkMap& region) {
  file_.SetGroup(GroupOf(regions_.size()));
  kPositions.Write(region.positions_in_map, &file_);
  kPositionSigmas.Write(region.position_sigmas_m, &file_);
  const std::size_t rows = region.descriptor_landmarks.size();
  const auto size = static_cast<std::size_t>(DescriptorSize(region.kind));
  file_.Write("descriptors/values", Array<std::uint8_t>{rows, size, region.descriptors});
  file_.WriteList<std::int32_t>("descriptors/landmark_idx", region.descriptor_landmarks);
  const auto num_levels = static_cast<std::size_t>(region.num_word_levels);
  file_.Write("descriptors/words", Array<std::int32_t>{rows, num_levels, region.words});
  kLandmarkKeyframes.Write(region.landmark_keyframes, &file_);
  kLandmarkFeatures.Write(Flattened(region.landmark_features, std::identity()), &file_);
  const Rectangle finite{box.min_m.cwiseMax(-kFarthest_m), box.max_m.cwiseMin(kFarthest_m)};
  regions_.push_back({finite, region.NumLandmarks(), SeeingKeyframes(region)});
}

void LandmarksWriter::Close() {
  file_.SetGroup("");
  kRegions.Write(regions_, &file_);
  file_.Close();
}

LandmarksReader::LandmarksReader(const std::filesystem::path& path)
    : file_(path, kLandmarksFormat, kLandmarksVersion),
      head_(ReadHead(file_)),
      regions_(ReadRegions(file_, head_.keyframes.size())) {}

LandmarkMap LandmarksReader::Read(std::size_t region) {
  file_.SetGroup(GroupOf(region));
  LandmarkMap map;
  map.kind = head_.kind;
  map.num_word_levels = head_.num_word_levels;
  ReadPositions(file_, &map);
  ReadDescriptors(file_, &map);
  ReadObservations(file_, head_.keyframes.size(), &map);
  CheckIsOfRegion(file_, regions_.at(region), map);
  return map;
}

LandmarkMap ReadLandmarks(const std::filesystem::path& path) {
  LandmarksReader reader(path);
  LandmarkMap map = reader.Head();
  for (std::size_t i = 0; i < reader.Regions().size(); ++i) AppendLandmarks(reader.Read(i), &map);
  return map;
}

}  // namespace nightmap
