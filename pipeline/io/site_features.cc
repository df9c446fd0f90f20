// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/site_features.h"

#include <algorithm>
#include <iterator>
#include <mutex>
#include <utility>

#include "pipeline/base/error.h"

namespace nightmap {
namespace {

std::size_t NumBytes(const FeaturesShard& shard) {
  std::size_t num_bytes = 0;
  for (const FrameFeatures& frame : shard.frames) {
    num_bytes += sizeof(frame) + frame.descriptors.size() +
                 frame.reference_features.size() * sizeof(int) +
                 frame.keypoints_px.size() * (2 * sizeof(Eigen::Vector2f) + 2 * sizeof(float));
  }
  return num_bytes;
}

// Whether the first frame of a shard is the one after the last before it.
bool Follows(const FeaturesShard& shard, const FeaturesShard& before) {
  return shard.frames.empty() || before.frames.empty() ||
         shard.frames.front().frame_idx == before.frames.back().frame_idx + 1;
}

FeatureHeads HeadsOf(const FeaturesShard& shard) {
  FeatureHeads heads{{shard.kind, shard.descriptor_size, shard.extraction, {}}, {}};
  for (const FrameFeatures& frame : shard.frames) {
    FrameFeatures& head = heads.shard.frames.emplace_back();
    head.frame_idx = frame.frame_idx;
    head.reference_frame_idx = frame.reference_frame_idx;
    heads.num_features.push_back(frame.NumFeatures());
  }
  return heads;
}

void CheckList(const std::filesystem::path& list,
               const std::filesystem::path& path,
               const FeaturesShard& shard) {
  if (AreOfFrames(ReadFrames(list), shard)) return;
  throw DataError(
      "{} does not list the frames that {} has features of; one of them is damaged or another "
      "site's: delete both and run make again",
      list.string(),
      path.string());
}

void CheckFollows(const std::filesystem::path& path,
                  const FeaturesShard& shard,
                  const std::filesystem::path& path_before,
                  const FeaturesShard& all_before) {
  if (shard.kind != all_before.kind || shard.extraction != all_before.extraction) {
    throw DataError(
        "{}: extracted with other options than those before it ({}); delete the features folder of "
        "this site and run make",
        path.string(),
        path_before.string());
  }
  if (Follows(shard, all_before)) return;
  throw DataError(
      "{} does not hold the frames that follow those of {}; one of them is damaged or another "
      "site's, or they are not in order: delete both and run make again",
      path.string(),
      path_before.string());
}

}  // namespace

struct SiteFeatures::Impl {
  struct Slot {
    Shard features;  // null: not in memory
    std::uint64_t last_use = 0;
    std::size_t num_bytes = 0;
  };

  // Reads one shard at a time: threads that want another wait.
  Shard Get(std::size_t shard) {
    const std::lock_guard lock(mutex);
    slots.resize(begins.size());
    Slot& slot = slots.at(shard);
    slot.last_use = ++num_uses;
    if (slot.features) return slot.features;
    slot.features = std::make_shared<const FeaturesShard>(read(shard));
    slot.num_bytes = NumBytes(*slot.features);
    num_bytes += slot.num_bytes;
    Shard features = slot.features;
    while (num_bytes > max_bytes) DropLeastRecent();
    return features;
  }

  void DropLeastRecent() {
    Slot* oldest = nullptr;
    for (Slot& slot : slots) {
      if (slot.features && (!oldest || slot.last_use < oldest->last_use)) oldest = &slot;
    }
    num_bytes -= oldest->num_bytes;
    oldest->features.reset();
  }

  std::function<FeaturesShard(std::size_t)> read;
  std::size_t max_bytes = kMaxBytes;
  FeatureHeads heads;
  std::vector<std::size_t> begins;  // of the shards among all frames
  std::mutex mutex;
  std::vector<Slot> slots;  // by shard
  std::uint64_t num_uses = 0;
  std::size_t num_bytes = 0;
};

SiteFeatures::SiteFeatures(FeaturesShard shard) : impl_(std::make_shared<Impl>()) {
  impl_->heads = HeadsOf(shard);
  impl_->begins = {0};
  impl_->read = [shard = std::move(shard)](std::size_t) { return shard; };
}

SiteFeatures::SiteFeatures(std::vector<std::filesystem::path> paths,
                           const std::vector<std::filesystem::path>& lists,
                           std::size_t max_bytes)
    : impl_(std::make_shared<Impl>()) {
  if (!lists.empty() && paths.size() != lists.size()) {
    throw UsageError(
        "give as many --in features as --in frames: {} and {}", paths.size(), lists.size());
  }
  FeaturesShard& all = impl_->heads.shard;
  for (std::size_t i = 0; i < paths.size(); ++i) {
    auto [heads, num_features] = ReadFeatureHeads(paths[i]);
    if (!lists.empty()) CheckList(lists[i], paths[i], heads);
    impl_->begins.push_back(all.frames.size());
    std::ranges::copy(num_features, std::back_inserter(impl_->heads.num_features));
    if (i == 0) {
      all = std::move(heads);
      continue;
    }
    CheckFollows(paths[i], heads, paths[i - 1], all);
    std::ranges::move(heads.frames, std::back_inserter(all.frames));
  }
  impl_->read = [paths = std::move(paths)](std::size_t shard) {
    return ReadFeatures(paths.at(shard));
  };
  impl_->max_bytes = max_bytes;
}

const FeaturesShard& SiteFeatures::Heads() const { return impl_->heads.shard; }

int SiteFeatures::FirstFrame() const { return Heads().frames.front().frame_idx; }

int SiteFeatures::NumFeatures(std::size_t place) const { return impl_->heads.num_features[place]; }

std::size_t SiteFeatures::NumShards() const { return impl_->begins.size(); }

SiteFeatures::Shard SiteFeatures::GetShard(std::size_t shard) const { return impl_->Get(shard); }

SiteFeatures::Frame SiteFeatures::GetFrame(int frame_idx) const {
  const auto place = static_cast<std::size_t>(frame_idx - FirstFrame());
  const auto after = std::ranges::upper_bound(impl_->begins, place);
  const auto shard = static_cast<std::size_t>(after - impl_->begins.begin()) - 1;
  Shard features = GetShard(shard);
  const FrameFeatures* frame = &features->frames.at(place - impl_->begins[shard]);
  return {std::move(features), frame};
}

void SiteFeatures::Release() const {
  const std::lock_guard lock(impl_->mutex);
  impl_->slots.clear();
  impl_->num_bytes = 0;
}

SiteFeatures SiteFeatures::With(std::function<void(FeaturesShard*)> change) const {
  SiteFeatures changed(*this);
  changed.impl_ = std::make_shared<Impl>();
  changed.impl_->heads = impl_->heads;
  changed.impl_->begins = impl_->begins;
  changed.impl_->max_bytes = impl_->max_bytes;
  changed.impl_->read = [read = impl_->read, change = std::move(change)](std::size_t shard) {
    FeaturesShard features = read(shard);
    change(&features);
    return features;
  };
  return changed;
}

FeaturesShard SiteFeatures::All() const {
  FeaturesShard all = Heads();
  all.frames.clear();
  for (std::size_t i = 0; i < NumShards(); ++i) {
    std::ranges::move(impl_->read(i).frames, std::back_inserter(all.frames));
  }
  return all;
}

}  // namespace nightmap
