// SPDX-License-Identifier: Apache-2.0
// <job>/shard_NNNN.h5 of masks: where a frame shows what may move by itself (people, say). A frame
// that the file does not hold is one of which nothing is known.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/io/image_io.h"

namespace nightmap {

// The mask of one frame as runs of pixels, which are few.
struct PackedMask {
  std::int64_t time_ns = 0;
  int width = 0;
  int height = 0;
  // Lengths of unmasked and masked runs by turns, unmasked first; only the first may be 0.
  std::vector<std::uint32_t> runs;
};

// `mask` is not 0 where something moves. Equal masks give equal runs.
PackedMask PackMask(std::int64_t time_ns, const GrayImage& mask);
// 255 where something moves, elsewhere 0.
GrayImage UnpackMask(const PackedMask& packed);
// Hash of what the mask holds, for the lists of frames.
std::string HashOf(const PackedMask& packed);
std::size_t NumMasked(const PackedMask& packed);
// Whether the runs fill the picture and no more, and all but the first hold pixels.
bool FillsPicture(const PackedMask& packed);

// Throws DataError.
void WriteMasks(const std::filesystem::path& path,
                const std::vector<PackedMask>& masks,
                const std::string& config);

// Throws DataError naming file and field on sizes that do not add up, runs that do not fill their
// picture, or times that do not ascend.
std::vector<PackedMask> ReadMasks(const std::filesystem::path& path);

}  // namespace nightmap
