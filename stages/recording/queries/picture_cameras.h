// SPDX-License-Identifier: Apache-2.0
// Finds the cameras of plain pictures for which [[query]] names none.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/recording/read_sequence.h"
#include "pipeline/recording/site_config.h"
#include "stages/recording/queries/queries.h"

namespace nightmap {

// Gives each such picture of `sequences` (made by ReadQuerySequences from `site`) its camera: from
// its row in cameras.csv beside the pictures, else from the focal length in its EXIF, else from the
// query's horizontal_fov_deg, else from the usual field of view. The last three assume a lens
// without distortion whose axis passes through the middle of the picture, and are not calibrated:
// focal_sigma_ratio says how sure they are. All cameras are those of the pixels as stored. A
// picture that cannot be read gets the site's first camera, since its pixels are never used. So
// does a picture of more than max_picture_mpx million pixels, which also gets a `problem`; a camera
// that large is a DataError, so no picture that large is ever decoded. Returns the site's cameras,
// followed by the found ones without duplicates, in the order of the pictures. Throws DataError
// naming the picture, or cameras.csv and line, and the remedy.
//
// cameras.csv: header picture,width,height,fx,fy,cx,cy,k1,k2,p1,p2,k3. Paths of pictures are
// relative to it; values are in px and in OpenCV's distortion model, as in a [[camera]].
std::vector<RgbdCamera> FindPictureCameras(const SiteConfig& site,
                                           const std::filesystem::path& data_root,
                                           const QueriesOptions& options,
                                           std::vector<RawSequence>* sequences);

}  // namespace nightmap
