// SPDX-License-Identifier: Apache-2.0
// The features of many tracks, so that each shard of them is read once.
#pragma once

#include <functional>

#include "pipeline/io/site_features.h"
#include "stages/camera/adjust/track_list.h"

namespace nightmap {

using VisitFeature =
    std::function<void(std::size_t track, std::size_t sighting, const FeatureView& feature)>;

// Calls `visit` for each sighting of each track, in the order of frames, then of tracks.
void VisitByFrame(const TrackList& tracks, const SiteFeatures& features, const VisitFeature& visit);

}  // namespace nightmap
