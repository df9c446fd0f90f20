// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/landmarks_io.h"

#include <cmath>

#include "pipeline/base/error.h"
#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kLandmarksFormat[] = "nightmap.landmarks";
constexpr int kLandmarksVersion = 2;  // 2: observations/feature_idx
constexpr std::size_t kMaxWordLevels = 64;
constexpr char kUnits[] = "metres, map frame (z up); quaternions x y z w; times in nanoseconds";

void CheckIndices(const Hdf5Reader& reader,
                  const char* field,
                  const std::vector<std::int32_t>& indices,
                  std::size_t size) {
  for (const std::int32_t index : indices) {
    if (index < 0 || static_cast<std::size_t>(index) >= size) {
      reader.Fail(field, "has index " + std::to_string(index) + " out of range");
    }
  }
}

void WriteKeyframes(const std::vector<MapKeyframe>& keyframes, Hdf5Writer* writer) {
  std::vector<std::int32_t> frames;
  std::vector<std::int64_t> times_ns;
  Array<double> poses{keyframes.size(), 7, {}};
  for (const MapKeyframe& keyframe : keyframes) {
    frames.push_back(keyframe.frame_idx);
    times_ns.push_back(keyframe.time_ns);
    const Eigen::Vector3d& t = keyframe.map_from_camera.translation;
    const Eigen::Quaterniond& q = keyframe.map_from_camera.rotation;
    poses.values.insert(poses.values.end(), {t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w()});
  }
  writer->WriteList("keyframes/frame_idx", frames);
  writer->WriteList("keyframes/time_ns", times_ns);
  writer->Write("keyframes/map_from_camera", poses);
}

std::vector<MapKeyframe> ReadKeyframes(const Hdf5Reader& reader) {
  const auto frames = reader.ReadList<std::int32_t>("keyframes/frame_idx");
  const auto times_ns = reader.ReadList<std::int64_t>("keyframes/time_ns");
  const auto poses = reader.Read<double>("keyframes/map_from_camera", 7);
  reader.Demand(times_ns.size() == frames.size(), "keyframes/time_ns", "has another length");
  reader.Demand(poses.rows == frames.size(), "keyframes/map_from_camera", "has another length");
  std::vector<MapKeyframe> keyframes(frames.size());
  for (std::size_t i = 0; i < keyframes.size(); ++i) {
    const double* row = &poses.values[7 * i];
    const Eigen::Quaterniond rotation(row[6], row[3], row[4], row[5]);
    reader.Demand(std::abs(rotation.norm() - 1.0) < 1e-6,
                  "keyframes/map_from_camera",
                  "has no unit quaternion");
    keyframes[i] = {frames[i], times_ns[i], {rotation, {row[0], row[1], row[2]}}};
  }
  return keyframes;
}

void WriteObservations(const LandmarkMap& map, Hdf5Writer* writer) {
  std::vector<std::int64_t> offsets{0};
  std::vector<std::int32_t> keyframes;
  for (const auto& list : map.landmark_keyframes) {
    keyframes.insert(keyframes.end(), list.begin(), list.end());
    offsets.push_back(static_cast<std::int64_t>(keyframes.size()));
  }
  std::vector<std::int32_t> features;
  for (const auto& list : map.landmark_features) {
    features.insert(features.end(), list.begin(), list.end());
  }
  writer->WriteList("observations/offsets", offsets);
  writer->WriteList("observations/keyframe_idx", keyframes);
  writer->WriteList("observations/feature_idx", features);
}

void ReadObservations(const Hdf5Reader& reader, LandmarkMap* map) {
  constexpr char kOffsets[] = "observations/offsets";
  const auto offsets = reader.ReadList<std::int64_t>(kOffsets);
  const auto keyframes = reader.ReadList<std::int32_t>("observations/keyframe_idx");
  const auto features = reader.ReadList<std::int32_t>("observations/feature_idx");
  CheckIndices(reader, "observations/keyframe_idx", keyframes, map->keyframes.size());
  reader.Demand(
      features.size() == keyframes.size(), "observations/feature_idx", "has another length");
  for (const std::int32_t feature : features) {
    reader.Demand(feature >= 0, "observations/feature_idx", "is negative");
  }
  reader.Demand(offsets.size() == map->positions_in_map.size() + 1, kOffsets, "has another length");
  reader.Demand(offsets[0] == 0 && offsets.back() == static_cast<std::int64_t>(keyframes.size()),
                kOffsets,
                "does not cover observations/keyframe_idx");
  for (std::size_t i = 0; i + 1 < offsets.size(); ++i) {
    reader.Demand(offsets[i] < offsets[i + 1],
                  kOffsets,
                  "decreases, or has a landmark that no keyframe sees");
  }
  map->landmark_keyframes.resize(map->positions_in_map.size());
  map->landmark_features.resize(map->positions_in_map.size());
  for (std::size_t i = 0; i < map->landmark_keyframes.size(); ++i) {
    auto& list = map->landmark_keyframes[i];
    list.assign(keyframes.begin() + offsets[i], keyframes.begin() + offsets[i + 1]);
    map->landmark_features[i].assign(features.begin() + offsets[i],
                                     features.begin() + offsets[i + 1]);
    for (std::size_t k = 1; k < list.size(); ++k) {
      reader.Demand(list[k - 1] < list[k], "observations/keyframe_idx", "is not ascending");
    }
  }
}

void ReadPositions(const Hdf5Reader& reader, LandmarkMap* map) {
  const auto positions = reader.Read<double>("landmarks/position_in_map_m", 3);
  map->position_sigmas_m = reader.ReadList<float>("landmarks/position_sigma_m");
  reader.Demand(map->position_sigmas_m.size() == positions.rows,
                "landmarks/position_sigma_m",
                "has another length");
  for (const float sigma_m : map->position_sigmas_m) {
    reader.Demand(sigma_m >= 0, "landmarks/position_sigma_m", "is negative");
  }
  for (std::size_t i = 0; i < positions.rows; ++i) {
    map->positions_in_map.emplace_back(&positions.values[3 * i]);
  }
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
  Array<double> positions{map.positions_in_map.size(), 3, {}};
  for (const Eigen::Vector3d& p : map.positions_in_map) {
    positions.values.insert(positions.values.end(), {p.x(), p.y(), p.z()});
  }
  writer.Write("landmarks/position_in_map_m", positions);
  writer.WriteList("landmarks/position_sigma_m", map.position_sigmas_m);
  const std::size_t rows = map.descriptor_landmarks.size();
  const auto size = static_cast<std::size_t>(DescriptorSize(map.kind));
  writer.Write("descriptors/values", Array<std::uint8_t>{rows, size, map.descriptors});
  writer.WriteList<std::int32_t>("descriptors/landmark_idx", map.descriptor_landmarks);
  const auto num_levels = static_cast<std::size_t>(map.num_word_levels);
  writer.Write("descriptors/words", Array<std::int32_t>{rows, num_levels, map.words});
  WriteKeyframes(map.keyframes, &writer);
  WriteObservations(map, &writer);
  writer.Close();
}

LandmarkMap ReadLandmarks(const std::filesystem::path& path) {
  const Hdf5Reader reader(path, kLandmarksFormat, kLandmarksVersion);
  LandmarkMap map;
  const auto kind = reader.ReadList<std::int32_t>("kind");
  reader.Demand(kind.size() == 1 && kind[0] >= 0 && kind[0] <= 2, "kind", "is not known");
  map.kind = static_cast<DescriptorKind>(kind[0]);
  map.extraction = reader.ReadText("extraction");
  ReadPositions(reader, &map);
  ReadDescriptors(reader, &map);
  map.keyframes = ReadKeyframes(reader);
  ReadObservations(reader, &map);
  return map;
}

}  // namespace nightmap
