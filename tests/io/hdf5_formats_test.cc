// SPDX-License-Identifier: Apache-2.0
// All formats of HDF5 but corner tracks, ceiling map and pose graph, which have tests of their own:
// damage, truncation and other formats are refused, and what is read is written as the same bytes.
#include "pipeline/camera/vocabulary_io.h"
#include "pipeline/dense/voxel_labels_io.h"
#include "pipeline/io/edges_io.h"
#include "pipeline/io/features_io.h"
#include "pipeline/io/labels_io.h"
#include "pipeline/io/masks_io.h"
#include "pipeline/io/matches_io.h"
#include "pipeline/io/odometry_io.h"
#include "pipeline/laser/scan_queries_io.h"
#include "pipeline/recording/signals_io.h"
#include "tests/io/artifact_damage.h"
#include "tests/io/hdf5_damage.h"
#include "tests/landmarks_file.h"

namespace nightmap::hdf5_formats_test {

using Path = std::filesystem::path;
constexpr char kConfig[] = "size = 1\n";

Rigid3 SomePose(int i) {
  const Eigen::AngleAxisd turn(0.1 * i, Eigen::Vector3d(1, 2, 3).normalized());
  return {Eigen::Quaterniond(turn), {0.5 * i, -1, 1.0 / 3}};
}

std::vector<FramePair> SomePairs() {
  std::vector<FramePair> pairs(3);
  for (int i = 0; i < 3; ++i) {
    FramePair& pair = pairs[static_cast<std::size_t>(i)];
    pair.frame_a = i;
    pair.frame_b = i + 2;
    pair.b_from_a = SomePose(i);
    pair.inliers = {{1, 2}, {3, 4}};
  }
  return pairs;
}

OdometryShard SomeOdometry() {
  OdometryShard shard;
  for (int i = 0; i < 4; ++i) {
    shard.frames.push_back({i, SomePose(i), TrackingState::kTracked, true});
  }
  shard.edges.push_back({0, 1, SomePose(1), Matrix6d::Identity(), false});
  shard.tracks = {{{0, 5}, {1, 6}}, {{2, 7}}};
  return shard;
}

SensorEdges SomeEdges() {
  const Matrix6d covariance = Matrix6d::Identity();
  return {"wheels",
          {{EdgeKind::kPrior, 7, 7, SomePose(0), covariance},
           {EdgeKind::kOdometry, 7, 8, SomePose(1), covariance},
           {EdgeKind::kLoop, 9, 7, SomePose(2), covariance}}};
}

FeaturesShard SomeFeatures() {
  FeaturesShard shard;
  shard.kind = DescriptorKind::kOrb;
  shard.descriptor_size = 32;
  shard.extraction = "detector = \"orb\"\n";
  for (int i = 0; i < 3; ++i) {
    FrameFeatures& frame = shard.frames.emplace_back();
    frame.frame_idx = i;
    frame.keypoints_px = frame.raw_keypoints_px = {{1, 2}, {3, 4}};
    frame.scales_px = {5, 6};
    frame.depths_m = {0, 2};
    if (i == 0) {
      for (int k = 0; k < 64; ++k) frame.descriptors.push_back(static_cast<std::uint8_t>(k));
    } else {
      frame.reference_frame_idx = 0;
      frame.reference_features = {1, 0};
    }
  }
  return shard;
}

LandmarkMap SomeLandmarks() {
  LandmarkMap map;
  map.kind = DescriptorKind::kOrb;
  map.positions_in_map = {{0, 1, 2}, {3, 4, 5}};
  map.position_sigmas_m = {0.1F, 0.2F};
  map.descriptors.assign(96, 1);
  map.descriptor_landmarks = {0, 0, 1};
  map.num_word_levels = 2;
  map.words = {1, 3, 1, 3, 2, 2};
  map.keyframes = {{0, 1, SomePose(0)}, {5, 2, SomePose(1)}};
  map.landmark_keyframes = map.landmark_features = {{0, 1}, {1}};
  return map;
}

LabelsShard SomeLabels() {
  GrayImage image{8, 6, 1, std::vector<std::uint8_t>(48, 1)};
  for (std::size_t i = 0; i < 48; i += 5) image.pixels[i] = 0;
  return {{{"background", "person"}, {0, 1}},
          {PackLabels(3, 1'000, {image, image}), PackLabels(4, 2'000, {image, image})}};
}

LabelsShard ReadLabels(const Path& path) {
  const LabelsReader reader(path);
  LabelsShard shard{reader.Classes(), {}};
  for (const PackedLabels& frame : reader.Frames()) {
    reader.Read(frame.time_ns);
    shard.frames.push_back(reader.ReadPacked(frame.time_ns));
  }
  return shard;
}

std::vector<PackedMask> SomeMasks() {
  const GrayImage mask{2, 3, 1, {255, 255, 0, 0, 0, 255}};
  return {PackMask(100, mask), PackMask(250, {2, 2, 1, {0, 0, 0, 0}})};
}

VoxelLabels SomeVoxels() {
  return {
      0.05, {"none", "chair"}, {{-3, 2, -1}, {0, 0, 0}}, {1, 2}, {0, 1, 3}, {1, 0, 1}, {1, 2, 3}};
}

Vocabulary SomeVocabulary() {
  const std::vector<VocabularyTree::Node> nodes = {{1, 2, 0}, {0, 0, 1}, {0, 0, 1}};
  return {VocabularyTree(DescriptorKind::kOrb, 2, nodes, std::vector<std::uint8_t>(96)),
          {{1}, {2, 1}}};
}

std::vector<Signal> SomeScans() {
  Signal front{SignalKind::kScan, "front", SomePose(1), {}};
  front.scan_duration_s = 0.075;
  for (int i = 0; i < 3; ++i) front.samples.push_back({1'000 + i, {-1.5, 0.01, 30}, {1, 2, 3}});
  return {front, {SignalKind::kScan, "rear, \"2\"", {}, {}}};
}

std::vector<ScanQuery> SomeScanQueries() {
  ScanQuery query{"kitchen, \"2\"", 5, {}, RoughPosition{{1.5, -2}, 5}};
  query.scans.push_back({{0.1, {0.2, 0.3}}, -1.5, 0.01, 30, {1, 2, 0, 30}});
  return {query, {"nothing", 9, {}, {}}};
}

struct Format {
  std::string name;
  int version = 0;
  std::function<void(const Path&)> write, read;
  std::function<void(const Path& from, const Path& to)> copy;
};

template <typename Content, typename Write, typename Read>
Format FormatOf(const std::string& name,
                int version,
                const Content& some,
                const Write& write,
                const Read& read) {
  return {name,
          version,
          [=](const Path& path) { write(path, some, kConfig); },
          [=](const Path& path) { read(path); },
          [=](const Path& from, const Path& to) { write(to, read(from), kConfig); }};
}

// Those that store no config.
const auto kWriteScans = [](const Path& path, const auto& scans, const char*) {
  WriteSignals(path, SignalKind::kScan, scans);
};
const auto kReadScans = [](const Path& path) { return ReadSignals(path, SignalKind::kScan); };
const auto kWriteScanQueries = [](const Path& path, const auto& queries, const char*) {
  WriteScanQueries(path, queries);
};
const auto kReadVocabulary = [](const Path& path) {
  OpenVocabulary(path).frames.Query({1, 2}, 5);
  return ReadVocabulary(path);
};
const auto kReadFeatures = [](const Path& path) { return ReadFeatures(path); };

std::vector<Format> Formats() {
  return {
      FormatOf("nightmap matches", 1, SomePairs(), WritePairs, ReadPairs),
      FormatOf("nightmap odometry", 1, SomeOdometry(), WriteOdometry, ReadOdometry),
      FormatOf("nightmap edges", 1, SomeEdges(), WriteEdges, ReadEdges),
      FormatOf("nightmap features", 2, SomeFeatures(), WriteFeatures, kReadFeatures),
      FormatOf("nightmap.landmarks", 3, SomeLandmarks(), WriteLandmarks, ReadLandmarks),
      FormatOf("nightmap labels", 2, SomeLabels(), WriteLabels, ReadLabels),
      FormatOf("nightmap masks", 1, SomeMasks(), WriteMasks, ReadMasks),
      FormatOf("nightmap voxel labels", 1, SomeVoxels(), WriteVoxelLabels, ReadVoxelLabels),
      FormatOf("nightmap.vocabulary", 2, SomeVocabulary(), WriteVocabulary, kReadVocabulary),
      FormatOf("nightmap signals", 1, SomeScans(), kWriteScans, kReadScans),
      FormatOf("nightmap scan queries", 1, SomeScanQueries(), kWriteScanQueries, ReadScanQueries)};
}

class Hdf5FormatTest : public testing::TestWithParam<Format> {
 protected:
  void SetUp() override { GetParam().write(path_); }
  TemporaryFolder folder_;
  const Path path_ = folder_ / "whole.h5";
};

TEST_P(Hdf5FormatTest, WhatIsReadIsWrittenAsTheSameBytes) {
  GetParam().copy(path_, folder_ / "again.h5");
  EXPECT_EQ(ReadBytes(folder_ / "again.h5"), ReadBytes(path_));
}

TEST_P(Hdf5FormatTest, ATruncatedOrMissingFileIsNamed) {
  ExpectTruncationIsNamed(folder_, path_, GetParam().read);
}

TEST_P(Hdf5FormatTest, AnotherFormatAndANewerVersionAreRefused) {
  ExpectOtherFormatsAreRefused(folder_, GetParam().name, GetParam().version, GetParam().read);
}

TEST_P(Hdf5FormatTest, DamageIsSurvived) {
  ExpectDamageIsSurvived(folder_, path_, GetParam().read);
}

INSTANTIATE_TEST_SUITE_P(Formats,
                         Hdf5FormatTest,
                         testing::ValuesIn(Formats()),
                         [](const auto& row) {
                           std::string name = row.param.name.substr(9);
                           std::erase(name, ' ');
                           return name;
                         });

}  // namespace nightmap::hdf5_formats_test
