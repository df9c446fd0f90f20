// SPDX-License-Identifier: Apache-2.0
#include "stages/recording/queries/picture_cameras.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/io/csv.h"
#include "pipeline/io/image_io.h"
#include "pipeline/recording/frame_lists.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHeader = "picture,width,height,fx,fy,cx,cy,k1,k2,p1,p2,k3";
constexpr double kMaxValue = 1e6;  // the same limit as for intrinsics in a site config
constexpr const char* kFileName = "cameras.csv";

// Path of the picture, relative to the data folder -> its camera.
using ListedCameras = std::map<std::string, Camera>;

struct PictureCamera {
  Camera camera;
  double focal_sigma_ratio = 0;  // as in RgbdCamera
};

Camera CameraFromRow(const CsvRow& row) {
  Camera camera{.width = row.Index(1, 1),
                .height = row.Index(2, 1),
                .fx = row.Real(3),
                .fy = row.Real(4),
                .cx = row.Real(5),
                .cy = row.Real(6),
                .k1 = row.Real(7),
                .k2 = row.Real(8),
                .p1 = row.Real(9),
                .p2 = row.Real(10),
                .k3 = row.Real(11)};
  if (!(camera.fx > 0 && camera.fy > 0)) row.Fail("fx and fy must be positive");
  for (std::size_t column = 1; column < 12; ++column) {
    if (std::abs(row.Real(column)) > kMaxValue) row.Fail(fmt::format("over {}", kMaxValue));
  }
  return camera;
}

ListedCameras ReadListedCameras(const fs::path& folder, const fs::path& data_root) {
  ListedCameras cameras;
  const fs::path path = data_root / folder / kFileName;
  if (!fs::exists(path)) return cameras;
  const CsvFile csv(path, kHeader);
  for (const CsvRow& row : csv.Rows()) {
    const std::string picture = (folder / row.Text(0)).lexically_normal().generic_string();
    if (cameras.emplace(picture, CameraFromRow(row)).second) continue;
    row.Fail(fmt::format("a second camera of {}: remove one", row.Text(0)));
  }
  return cameras;
}

Camera Pinhole(int width, int height, double focal_px) {
  return {.width = width,
          .height = height,
          .fx = focal_px,
          .fy = focal_px,
          .cx = (width - 1) / 2.0,
          .cy = (height - 1) / 2.0};
}

double FocalOfView_px(int side_px, double fov_deg) {
  return side_px / 2.0 / std::tan(fov_deg / 2 * std::numbers::pi / 180);
}

// The camera of a picture without calibration, by the best that is known of its lens.
PictureCamera GuessCamera(const ImageInfo& info,
                          double horizontal_fov_deg,
                          const QueriesOptions& options) {
  const int width = info.width, height = info.height;
  if (const auto focal_px = FocalLength_px(info.lens, width, height)) {
    return {Pinhole(width, height, *focal_px), options.exif_focal_sigma_ratio};
  }
  if (horizontal_fov_deg > 0) {
    return {Pinhole(width, height, FocalOfView_px(width, horizontal_fov_deg)),
            options.fov_focal_sigma_ratio};
  }
  const double usual_px = FocalOfView_px(std::max(width, height), options.unknown_fov_deg);
  return {Pinhole(width, height, usual_px), options.unknown_focal_sigma_ratio};
}

bool IsLarger(int width, int height, double max_picture_mpx) {
  return 1e-6 * width * height > max_picture_mpx;
}

// Nothing when the picture cannot be read or is too large.
std::optional<PictureCamera> CameraOfPicture(const SequenceConfig& query,
                                             const fs::path& data_root,
                                             const QueriesOptions& options,
                                             RawFrame* frame) {
  const std::string& path = frame->color.path;
  ImageInfo info;
  try {
    info = InspectImage(data_root / path);
  } catch (const DataError&) {
    return {};
  }
  if (IsLarger(info.width, info.height, options.max_picture_mpx)) {
    frame->problem = fmt::format(
        "{}: {} x {} pixels are more than max_picture_mpx = {}: make it smaller, or raise "
        "max_picture_mpx of queries",
        path,
        info.width,
        info.height,
        options.max_picture_mpx);
    return {};
  }
  return GuessCamera(info, query.horizontal_fov_deg, options);
}

// Index of this camera among the found ones; adds it when missing.
int IndexOf(const PictureCamera& found,
            const std::string& camera_id,
            std::size_t num_configured,
            std::vector<RgbdCamera>* cameras) {
  for (std::size_t i = num_configured; i < cameras->size(); ++i) {
    const RgbdCamera& other = (*cameras)[i];
    if (other.color == found.camera && other.focal_sigma_ratio == found.focal_sigma_ratio) {
      return static_cast<int>(i);
    }
  }
  cameras->emplace_back().camera_id = camera_id;
  cameras->back().color = found.camera;
  cameras->back().focal_sigma_ratio = found.focal_sigma_ratio;
  return static_cast<int>(cameras->size()) - 1;
}

}  // namespace

std::vector<RgbdCamera> FindPictureCameras(const SiteConfig& site,
                                           const fs::path& data_root,
                                           const QueriesOptions& options,
                                           std::vector<RawSequence>* sequences) {
  std::vector<RgbdCamera> cameras = site.cameras;
  for (std::size_t q = 0; q < site.queries.size(); ++q) {
    const SequenceConfig& query = site.queries[q];
    if (query.camera_idx != kOwnCameras) continue;
    const auto listed =
        ReadListedCameras(PicturesFolder({data_root, site.root, query, true}), data_root);
    for (RawFrame& frame : sequences->at(q).frames) {
      const auto row = listed.find(frame.color.path);
      const auto camera = row != listed.end() ? std::optional(PictureCamera{row->second})
                                              : CameraOfPicture(query, data_root, options, &frame);
      frame.camera_idx =
          camera ? IndexOf(*camera, frame.color.path, site.cameras.size(), &cameras) : 0;
    }
  }
  CheckAreas(cameras, options.max_picture_mpx);
  return cameras;
}

}  // namespace nightmap
