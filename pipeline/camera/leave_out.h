// SPDX-License-Identifier: Apache-2.0
// Features under masks of what may move, or of what stays out of the map.
#pragma once

#include <optional>
#include <vector>

#include "pipeline/io/frame_reader.h"
#include "pipeline/io/site_features.h"

namespace nightmap {

// Per frame of a site and feature that is left, its index before; none: all are left.
using IndicesBefore = std::vector<std::optional<std::vector<int>>>;

// The features that no frame's mask holds. `frames` are those of `features`, in the same order;
// throws InputError when they are others. Frames that were tracked keep theirs: without a feature
// of their reference, their reference_features are wrong. Throws as FrameReader::Mask and
// SiteFeatures::GetShard.
IndicesBefore UnmaskedFeatures(const std::vector<FrameRecord>& frames,
                               const std::vector<RgbdCamera>& cameras,
                               const FrameReader& masks,
                               const SiteFeatures& features);

// The site with these features alone.
SiteFeatures KeepFeatures(const SiteFeatures& features, IndicesBefore indices_before);

}  // namespace nightmap
