// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/landmarks_io.h"

#include <algorithm>

#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kLandmarksFormat[] = "nightmap.landmarks";
constexpr int kLandmarksVersion = 2;  // 2: observations/feature_idx
constexpr std::size_t kMaxWordLevels = 64;
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

void ReadObservations(const Hdf5Reader& reader, LandmarkMap* map) {
  map->landmark_keyframes = kLandmarkKeyframes.Read(reader);
  const auto features = kLandmarkFeatures.Read(reader);
  reader.DemandIndices(map->landmark_keyframes, map->keyframes.size(), "observations/keyframe_idx");
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
      words.rows == num_descriptors && words.cols > 0, "descriptors/words", "has another length");
  reader.Demand(words.cols <= kMaxWordLevels, "descriptors/words", "has too many levels");
  CheckEveryLandmarkDescribed(reader, *map);
  for (const std::int32_t word : words.values) {
    reader.Demand(word >= 0, "descriptors/words", "is negative");
  }
  map->descriptors = std::move(values.values);
  map->num_word_levels = static_cast<int>(words.cols);
  map->words = std::move(words.values);
}

}  // namespace

std::vector<std::vector<int>> LandmarkMap::KeyframeLandmarks() const {
  std::vector<std::vector<int>> lists(keyframes.size());
  for (int i = 0; i < NumLandmarks(); ++i) {
    for (const int keyframe : landmark_keyframes[static_cast<std::size_t>(i)]) {
      lists[static_cast<std::size_t>(keyframe)].push_back(i);
    }
  }
  return lists;
}

std::vector<int> LandmarkMap::DescriptorOffsets() const {
  std::vector<int> offsets(positions_in_map.size() + 1, NumDescriptors());
  for (int i = NumDescriptors() - 1; i >= 0; --i) {
    offsets[static_cast<std::size_t>(descriptor_landmarks[static_cast<std::size_t>(i)])] = i;
  }
  return offsets;
}

void WriteLandmarks(const std::filesystem::path& path,
                    const LandmarkMap& map,
                    const std::string& config) {
  Hdf5Writer writer(path, kLandmarksFormat, kLandmarksVersion, config, kUnits);
  writer.WriteText("extraction", map.extraction);
  writer.WriteList<std::int32_t>("kind", {static_cast<std::int32_t>(map.kind)});
  kPositions.Write(map.positions_in_map, &writer);
  kPositionSigmas.Write(map.position_sigmas_m, &writer);
  const std::size_t rows = map.descriptor_landmarks.size();
  const auto size = static_cast<std::size_t>(DescriptorSize(map.kind));
  writer.Write("descriptors/values", Array<std::uint8_t>{rows, size, map.descriptors});
  writer.WriteList<std::int32_t>("descriptors/landmark_idx", map.descriptor_landmarks);
  const auto num_levels = static_cast<std::size_t>(map.num_word_levels);
  writer.Write("descriptors/words", Array<std::int32_t>{rows, num_levels, map.words});
  kMapKeyframes.Write(map.keyframes, &writer);
  kLandmarkKeyframes.Write(map.landmark_keyframes, &writer);
  kLandmarkFeatures.Write(Flattened(map.landmark_features, std::identity()), &writer);
  writer.Close();
}

LandmarkMap ReadLandmarks(const std::filesystem::path& path) {
  const Hdf5Reader reader(path, kLandmarksFormat, kLandmarksVersion);
  LandmarkMap map;
  const auto kind = reader.ReadOne<std::int32_t>("kind");
  reader.Demand(kind >= 0 && kind <= 2, "kind", "is not known");
  map.kind = static_cast<DescriptorKind>(kind);
  map.extraction = reader.ReadText("extraction");
  ReadPositions(reader, &map);
  ReadDescriptors(reader, &map);
  map.keyframes = kMapKeyframes.Read(reader);
  ReadObservations(reader, &map);
  return map;
}

}  // namespace nightmap
