// SPDX-License-Identifier: Apache-2.0
// The cameras of plain pictures whose [[query]] names none.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/io/site_config.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {

// Gives each such picture of `sequences` (as ReadQuerySequences made them of `site`) its camera: of
// its row in the file cameras.csv beside the pictures, else of the focal length in its EXIF, else
// of the query's horizontal_fov_deg. The last two are for a lens without distortion, its axis
// through the middle of the picture. All are cameras of the pixels as stored. A picture that cannot
// be read gets the site's first camera: its pixels will never be looked at. A picture of more than
// max_picture_mpx million pixels counts as such, with a `problem`; a camera that large is a
// DataError, so no picture that large is ever decoded. Returns the site's cameras and
// after them the found ones, one for each that differs, in the order of the pictures. Throws
// DataError naming the picture, or cameras.csv and line, and the remedy.
//
// cameras.csv: header picture,width,height,fx,fy,cx,cy,k1,k2,p1,p2,k3, with the paths of pictures
// relative to it; px and OpenCV's distortion model, as in a [[camera]].
std::vector<RgbdCamera> FindPictureCameras(const SiteConfig& site,
                                           const std::filesystem::path& data_root,
                                           double max_picture_mpx,
                                           std::vector<RawSequence>* sequences);

}  // namespace nightmap
