// SPDX-License-Identifier: Apache-2.0
// A large map, searched part by part: which parts may show a picture, and the parts themselves.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <vector>

#include "pipeline/camera/inverted_file.h"
#include "pipeline/camera/vocabulary_io.h"
#include "pipeline/io/landmark_map.h"
#include "stages/camera/localize/localize.h"
#include "stages/camera/localize/localizer.h"

namespace nightmap {

// Keeps a reference.
MapInRegions RegionsOf(LandmarksReader& reader);

// The landmarks of some regions, with the keyframes of the whole map. Throws DataError when the
// words are not of the tree, or when they cannot be read.
LandmarkMap ReadRegions(const MapInRegions& map,
                        const std::vector<std::size_t>& regions,
                        const VocabularyTree& tree);

// A part, and how alike its keyframes are to a picture: the sum of the best scores of retrieval by
// the picture's rarest words.
struct AlikePart {
  std::size_t part = 0;
  double score = 0;
};

// Each part is a region with its neighbours: those with landmarks that its keyframes see too, first
// those that share the most keyframes with it, as long as the part has at most
// limits.part_landmarks. So a picture at a border sees what is on both sides.
class MapParts {
 public:
  // Keeps references.
  MapParts(const LocalizeOptions& options,
           const MapInRegions& map,
           const VocabularyIndex& vocabulary,
           const MapLimits& limits);

  // The parts that are most like a picture, best first: the part of the region that the most
  // similar keyframes see, then that of the region which those see best that do not see the first
  // part alone, and so on. Parts do not depend on each other. Thread-safe.
  std::vector<AlikePart> MostAlike(const FrameFeatures& features) const;

  DescriptorKind Kind() const { return map_.head.kind; }

  // Valid until the next call. Keeps parts in memory up to limits.bytes, those that were wanted
  // last, and at least the one returned. Not thread-safe. Throws DataError when the map does not
  // fit the vocabulary, or cannot be read.
  const Localizer& Load(std::size_t part);
  bool IsLoaded(std::size_t part) const;

 private:
  struct Loaded;

  std::vector<std::size_t> RegionsOf(std::size_t part) const;
  LandmarkMap ReadPart(std::size_t part) const;

  const LocalizeOptions& options_;
  const MapInRegions& map_;
  const VocabularyIndex& vocabulary_;
  MapLimits limits_;
  std::vector<std::vector<std::size_t>> keyframe_regions_;  // with landmarks that it sees
  std::vector<std::vector<std::size_t>> part_regions_;      // ascending
  std::vector<int> frame_keyframes_;                        // frame_idx -> keyframe, or -1
  std::list<std::shared_ptr<const Loaded>> loaded_;         // wanted last first
};

}  // namespace nightmap
