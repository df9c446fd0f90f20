// SPDX-License-Identifier: Apache-2.0
// Features of all shards of a site, of which some are in memory: those of a whole night fit into
// none.
#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <vector>

#include "pipeline/io/features_io.h"

namespace nightmap {

// Frames are contiguous. Copies share what is in memory. Threads may share one. Results that depend
// on nothing else do not depend on what is in memory.
class SiteFeatures {
 public:
  // A shard that a caller works on; others may leave the memory.
  using Shard = std::shared_ptr<const FeaturesShard>;
  using Frame = std::shared_ptr<const FrameFeatures>;

  static constexpr std::size_t kMaxBytes = std::size_t{1} << 29;  // in memory for later calls

  // One shard, all in memory.
  explicit SiteFeatures(FeaturesShard shard);
  // Shards in order, which must be of one kind, one behind the other. `lists`, if any: each shard
  // must be of the frames that its own list holds. Reads what frames there are. Throws DataError
  // naming the files, UsageError when there are not as many lists.
  SiteFeatures(std::vector<std::filesystem::path> paths,
               const std::vector<std::filesystem::path>& lists,
               std::size_t max_bytes = kMaxBytes);

  // Kind, size and options of the descriptors, and frames with their indices, but no features.
  const FeaturesShard& Heads() const;
  int FirstFrame() const;
  // `place`: of the frame in Heads().
  int NumFeatures(std::size_t place) const;
  std::size_t NumShards() const;
  // Both read the shard unless it is in memory, and throw DataError naming file and field.
  Shard GetShard(std::size_t shard) const;
  Frame GetFrame(int frame_idx) const;
  // Frees the shards kept for later calls.
  void Release() const;
  // The same site with a change made to each shard when it is read. It must keep frames and be the
  // same each time.
  SiteFeatures With(std::function<void(FeaturesShard*)> change) const;
  // All features at once, of sites that are known to be small.
  FeaturesShard All() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace nightmap
