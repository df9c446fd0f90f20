// SPDX-License-Identifier: Apache-2.0
// landmarks.h5: the landmark map, region by region. A writer holds one region at a time, and a
// reader reads those that it needs.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/io/hdf5_file.h"
#include "pipeline/io/landmark_map.h"

namespace nightmap {

class LandmarksWriter {
 public:
  // `head` is the map without landmarks. `config` is the effective config that the artifact
  // carries. All throw DataError naming file and field.
  LandmarksWriter(const std::filesystem::path& path,
                  const LandmarkMap& head,
                  const std::string& config);
  // Regions in order. `region` has the landmarks that lie in `box`; keyframes are those of the
  // head.
  void Write(const Rectangle& box, const LandmarkMap& region);
  void Close();

 private:
  Hdf5Writer file_;
  std::vector<LandmarkRegion> regions_;
};

// Not thread-safe.
class LandmarksReader {
 public:
  // Reads what is not of one region. Throws DataError naming file and field, like Read.
  explicit LandmarksReader(const std::filesystem::path& path);

  // The map without landmarks: kind, extraction, levels, keyframes.
  const LandmarkMap& Head() const { return head_; }
  const std::vector<LandmarkRegion>& Regions() const { return regions_; }
  // The landmarks of a region. Their keyframes are those of the head, which the result leaves out.
  // Those of all regions, in order, are the map's.
  LandmarkMap Read(std::size_t region);

 private:
  Hdf5Reader file_;
  LandmarkMap head_;
  std::vector<LandmarkRegion> regions_;
};

// The whole map. Throws DataError naming file and field.
LandmarkMap ReadLandmarks(const std::filesystem::path& path);

}  // namespace nightmap
