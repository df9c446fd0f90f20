// SPDX-License-Identifier: Apache-2.0
// Parts of a camera's pictures that no job takes: those that show the robot, and those its lens
// has no ray for.
#pragma once

#include <filesystem>

#include "pipeline/recording/site_config.h"

namespace nightmap {

// Gives the cameras the masks that the site config names. Masked is what is nearer to white than to
// black. Pixels that the camera does not see (Camera::Sees) are masked as well. Throws DataError
// naming the file and the [[camera]] when the picture cannot be read, has another size than the
// camera's color, or is masked nowhere or everywhere; and naming the camera when it sees no pixel.
void ReadCameraMasks(const std::filesystem::path& data_root, SiteConfig* site);

}  // namespace nightmap
