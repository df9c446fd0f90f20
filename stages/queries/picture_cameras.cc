// SPDX-License-Identifier: Apache-2.0
#include "stages/queries/picture_cameras.h"

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

double FocalOfView_px(int width, double horizontal_fov_deg) {
  return width / 2.0 / std::tan(horizontal_fov_deg / 2 * std::numbers::pi / 180);
}

bool IsLarger(int width, int height, double max_picture_mpx) {
  return 1e-6 * width * height > max_picture_mpx;
}

// Nothing when the picture cannot be read or is too large.
std::optional<Camera> CameraOfPicture(const SequenceConfig& query,
                                      const fs::path& data_root,
                                      double max_picture_mpx,
                                      RawFrame* frame) {
  const std::string& path = frame->color.path;
  ImageInfo info;
  try {
    info = InspectImage(data_root / path);
  } catch (const DataError&) {
    return {};
  }
  if (IsLarger(info.width, info.height, max_picture_mpx)) {
    frame->problem = fmt::format(
        "{}: {} x {} pixels are more than max_picture_mpx = {}: make it smaller, or raise "
        "max_picture_mpx of queries",
        path,
        info.width,
        info.height,
        max_picture_mpx);
    return {};
  }
  if (const auto focal_px = FocalLength_px(info.lens, info.width, info.height)) {
    return Pinhole(info.width, info.height, *focal_px);
  }
  if (query.horizontal_fov_deg > 0) {
    return Pinhole(info.width, info.height, FocalOfView_px(info.width, query.horizontal_fov_deg));
  }
  throw DataError(
      "{}: its EXIF has no focal length: give it a row in {} beside it, or give {} `camera` or "
      "`horizontal_fov_deg` (CAMERA or FOV_DEG of make)",
      path,
      kFileName,
      query.source);
}

// Index of the camera with these intrinsics among the found ones; adds it when missing.
int IndexOf(const Camera& camera,
            const std::string& camera_id,
            std::size_t num_configured,
            std::vector<RgbdCamera>* cameras) {
  for (std::size_t i = num_configured; i < cameras->size(); ++i) {
    if ((*cameras)[i].color == camera) return static_cast<int>(i);
  }
  cameras->emplace_back().camera_id = camera_id;
  cameras->back().color = camera;
  return static_cast<int>(cameras->size()) - 1;
}

}  // namespace

std::vector<RgbdCamera> FindPictureCameras(const SiteConfig& site,
                                           const fs::path& data_root,
                                           double max_picture_mpx,
                                           std::vector<RawSequence>* sequences) {
  std::vector<RgbdCamera> cameras = site.cameras;
  for (std::size_t q = 0; q < site.queries.size(); ++q) {
    const SequenceConfig& query = site.queries[q];
    if (query.camera_idx != kOwnCameras) continue;
    const auto listed =
        ReadListedCameras(PicturesFolder({data_root, site.root, query, true}), data_root);
    for (RawFrame& frame : sequences->at(q).frames) {
      const auto row = listed.find(frame.color.path);
      const auto camera = row != listed.end()
                              ? std::optional(row->second)
                              : CameraOfPicture(query, data_root, max_picture_mpx, &frame);
      frame.camera_idx =
          camera ? IndexOf(*camera, frame.color.path, site.cameras.size(), &cameras) : 0;
    }
  }
  CheckAreas(cameras, max_picture_mpx);
  return cameras;
}

}  // namespace nightmap
