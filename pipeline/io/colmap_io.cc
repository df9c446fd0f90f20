// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/colmap_io.h"

#include <fmt/format.h>

#include <iterator>

#include "pipeline/io/colmap_camera.h"
#include "pipeline/io/image_io.h"

namespace nightmap {
namespace {

constexpr std::uint64_t kNoPoint = ~std::uint64_t{0};

// Bytes as they are in memory; the programs run only on little-endian machines.
template <typename T>
void Append(T value, std::string* bytes) {
  bytes->append(reinterpret_cast<const char*>(&value), sizeof(T));
}

std::uint32_t IdOf(int index) { return static_cast<std::uint32_t>(index) + 1; }

template <typename... Args>
void AppendText(std::string* text, fmt::format_string<Args...> format, Args&&... args) {
  fmt::format_to(std::back_inserter(*text), format, std::forward<Args>(args)...);
}

std::string CamerasText(const ColmapModel& model) {
  std::string text = "# CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n";
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const ColmapCamera camera = ToColmap(model.cameras[i]);
    AppendText(&text, "{} {} {} {}", i + 1, camera.model, camera.width, camera.height);
    for (const double parameter : camera.parameters) AppendText(&text, " {}", parameter);
    text += '\n';
  }
  return text;
}

std::string ImagesText(const ColmapModel& model) {
  std::string text =
      "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, "
      "POINT3D_ID)\n";
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const ColmapImage& image = model.images[i];
    const Eigen::Quaterniond& q = image.camera_from_map.rotation;
    const Eigen::Vector3d& t = image.camera_from_map.translation;
    AppendText(&text, "{} {} {} {} {}", i + 1, q.w(), q.x(), q.y(), q.z());
    AppendText(&text, " {} {} {}", t.x(), t.y(), t.z());
    AppendText(&text, " {} {}\n", IdOf(image.camera_idx), image.name);
    for (std::size_t k = 0; k < image.keypoints_px.size(); ++k) {
      const Eigen::Vector2d px = ToColmapPixel(image.keypoints_px[k]);
      const int point = image.keypoint_points[k];
      AppendText(&text, "{}{} {} {}", k ? " " : "", px.x(), px.y(), point < 0 ? -1 : point + 1);
    }
    text += '\n';
  }
  return text;
}

std::string PointsText(const ColmapModel& model) {
  std::string text = "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const ColmapPoint& point = model.points[i];
    const Eigen::Vector3d& p = point.position_in_map;
    AppendText(&text, "{} {} {} {} 0 0 0 {}", i + 1, p.x(), p.y(), p.z(), point.error_px);
    for (const ColmapObservation& observation : point.track) {
      AppendText(&text, " {} {}", IdOf(observation.image_idx), observation.keypoint);
    }
    text += '\n';
  }
  return text;
}

std::string CamerasBinary(const ColmapModel& model) {
  std::string bytes;
  Append<std::uint64_t>(model.cameras.size(), &bytes);
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const ColmapCamera camera = ToColmap(model.cameras[i]);
    Append(IdOf(static_cast<int>(i)), &bytes);
    Append<std::int32_t>(camera.model_id, &bytes);
    Append<std::uint64_t>(static_cast<std::uint64_t>(camera.width), &bytes);
    Append<std::uint64_t>(static_cast<std::uint64_t>(camera.height), &bytes);
    for (const double parameter : camera.parameters) Append(parameter, &bytes);
  }
  return bytes;
}

std::string ImagesBinary(const ColmapModel& model) {
  std::string bytes;
  Append<std::uint64_t>(model.images.size(), &bytes);
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const ColmapImage& image = model.images[i];
    const Eigen::Quaterniond& q = image.camera_from_map.rotation;
    const Eigen::Vector3d& t = image.camera_from_map.translation;
    Append(IdOf(static_cast<int>(i)), &bytes);
    for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
      Append(value, &bytes);
    }
    Append(IdOf(image.camera_idx), &bytes);
    bytes.append(image.name.c_str(), image.name.size() + 1);
    Append<std::uint64_t>(image.keypoints_px.size(), &bytes);
    for (std::size_t k = 0; k < image.keypoints_px.size(); ++k) {
      const Eigen::Vector2d px = ToColmapPixel(image.keypoints_px[k]);
      const int point = image.keypoint_points[k];
      Append(px.x(), &bytes);
      Append(px.y(), &bytes);
      Append(point < 0 ? kNoPoint : std::uint64_t{IdOf(point)}, &bytes);
    }
  }
  return bytes;
}

std::string PointsBinary(const ColmapModel& model) {
  std::string bytes;
  Append<std::uint64_t>(model.points.size(), &bytes);
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    const ColmapPoint& point = model.points[i];
    Append<std::uint64_t>(i + 1, &bytes);
    for (const double value : point.position_in_map) Append(value, &bytes);
    bytes.append(3, '\0');
    Append(point.error_px, &bytes);
    Append<std::uint64_t>(point.track.size(), &bytes);
    for (const ColmapObservation& observation : point.track) {
      Append(IdOf(observation.image_idx), &bytes);
      Append(static_cast<std::uint32_t>(observation.keypoint), &bytes);
    }
  }
  return bytes;
}

}  // namespace

double ColmapModel::MeanReprojectionError_px() const {
  double sum_px = 0;
  for (const ColmapPoint& point : points) sum_px += point.error_px;
  return points.empty() ? 0 : sum_px / static_cast<double>(points.size());
}

std::string UnusableColmapNames(const ColmapModel& model) {
  int num_with_blank = 0;
  int num_of_videos = 0;
  for (const ColmapImage& image : model.images) {
    if (image.name.find(' ') != std::string::npos) ++num_with_blank;
    if (SplitVideoFramePath(image.name)) ++num_of_videos;
  }
  std::string reason;
  if (num_with_blank > 0) {
    AppendText(
        &reason,
        "COLMAP ends a name of the text model at a blank, use the binary one: {} of {} names",
        num_with_blank,
        model.images.size());
  }
  if (num_of_videos > 0) {
    AppendText(&reason,
               "{}COLMAP cannot open frames of a video, store them as pictures: {} of {} names",
               reason.empty() ? "" : "; ",
               num_of_videos,
               model.images.size());
  }
  return reason;
}

std::map<std::string, std::string> ColmapFiles(const ColmapModel& model) {
  return {{"cameras.txt", CamerasText(model)},
          {"images.txt", ImagesText(model)},
          {"points3D.txt", PointsText(model)},
          {"cameras.bin", CamerasBinary(model)},
          {"images.bin", ImagesBinary(model)},
          {"points3D.bin", PointsBinary(model)}};
}

}  // namespace nightmap
