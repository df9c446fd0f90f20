// SPDX-License-Identifier: Apache-2.0
#include "tests/bench/libraries/mapped_site.h"

#include <algorithm>
#include <string>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

std::vector<std::filesystem::path> Shards(const std::filesystem::path& folder,
                                          const std::string& extension) {
  std::vector<std::filesystem::path> shards;
  for (const auto& file : std::filesystem::directory_iterator(folder)) {
    const std::filesystem::path& path = file.path();
    if (path.filename().string().starts_with("shard_") && path.extension() == extension) {
      shards.push_back(path);
    }
  }
  std::ranges::sort(shards);
  return shards;
}

KeyframeSource OpenKeyframes(const MappedSite& site, const std::filesystem::path& folder) {
  KeyframeSource source;
  source.cameras = site.cameras;
  source.keyframes = SelectKeyframes(
      site.frames, site.cameras, ReadTum(folder / "map_frame" / "keyframes.tum"), 1);
  source.load = [cameras = site.cameras, data = site.data](const Keyframe& keyframe) {
    const auto camera = static_cast<std::size_t>(keyframe.frame.camera_idx);
    return LoadRgbd(keyframe.frame, cameras[camera], data);
  };
  return source;
}

}  // namespace

MappedSite ReadMappedSite(const std::filesystem::path& folder, const std::filesystem::path& data) {
  MappedSite site;
  site.name = folder.filename().string();
  site.data = data;
  site.frames = ReadFrames(Shards(folder / "frames", ".csv"));
  site.cameras = ReadCameras(folder / "adjust" / "cameras.json", site.frames);
  site.features = ReadFeatures(Shards(folder / "features", ".h5"));
  if (site.features.kind != DescriptorKind::kRootSift) {
    throw DataError("{}: its features are not RootSIFT; map it as configured", folder.string());
  }
  for (FramePair& pair : ReadPairs(folder / "loops" / "loops.h5")) {
    if (pair.status == PairStatus::kAccepted) site.loops.push_back(std::move(pair));
  }
  site.truth = ReadTum(folder / "frames" / "ground_truth.tum");
  site.landmarks = ReadLandmarks(folder / "landmarks" / "landmarks.h5");
  site.keyframes = OpenKeyframes(site, folder);
  return site;
}

}  // namespace nightmap
