// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/colmap_io.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

#include "pipeline/base/error.h"
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

constexpr char kImagesHead[] =
    "# IMAGE_ID, QW, QX, QY, QZ, TX, TY, TZ, CAMERA_ID, NAME\n# POINTS2D[] as (X, Y, "
    "POINT3D_ID)\n";

// -1: none.
int PointOf(const ColmapImage& image, std::size_t keypoint) {
  return keypoint < image.keypoint_points.size() ? image.keypoint_points[keypoint] : -1;
}

std::string ImageText(std::size_t i, const ColmapImage& image, const ColmapFeatures& features) {
  std::string text;
  const Eigen::Quaterniond& q = image.camera_from_map.rotation;
  const Eigen::Vector3d& t = image.camera_from_map.translation;
  AppendText(&text, "{} {} {} {} {}", i + 1, q.w(), q.x(), q.y(), q.z());
  AppendText(&text, " {} {} {}", t.x(), t.y(), t.z());
  AppendText(&text, " {} {}\n", IdOf(image.camera_idx), image.name);
  for (std::size_t k = 0; k < features.keypoints_px.size(); ++k) {
    const Eigen::Vector2d px = ToColmapPixel(features.keypoints_px[k]);
    const int point = PointOf(image, k);
    AppendText(&text, "{}{} {} {}", k ? " " : "", px.x(), px.y(), point < 0 ? -1 : point + 1);
  }
  text += '\n';
  return text;
}

constexpr char kPointsHead[] =
    "# POINT3D_ID, X, Y, Z, R, G, B, ERROR, TRACK[] as (IMAGE_ID, POINT2D_IDX)\n";

std::string PointText(std::size_t i, const ColmapModel& model) {
  std::string text;
  const ColmapPoint& point = model.points[i];
  const Eigen::Vector3d& p = point.position_in_map;
  AppendText(&text, "{} {} {} {} 0 0 0 {}", i + 1, p.x(), p.y(), p.z(), point.error_px);
  for (const ColmapObservation& observation : model.TrackOf(point)) {
    AppendText(&text, " {} {}", IdOf(observation.image_idx), observation.keypoint);
  }
  text += '\n';
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

std::string ImageBinary(std::size_t i, const ColmapImage& image, const ColmapFeatures& features) {
  std::string bytes;
  const Eigen::Quaterniond& q = image.camera_from_map.rotation;
  const Eigen::Vector3d& t = image.camera_from_map.translation;
  Append(IdOf(static_cast<int>(i)), &bytes);
  for (const double value : {q.w(), q.x(), q.y(), q.z(), t.x(), t.y(), t.z()}) {
    Append(value, &bytes);
  }
  Append(IdOf(image.camera_idx), &bytes);
  bytes.append(image.name.c_str(), image.name.size() + 1);
  Append<std::uint64_t>(features.keypoints_px.size(), &bytes);
  for (std::size_t k = 0; k < features.keypoints_px.size(); ++k) {
    const Eigen::Vector2d px = ToColmapPixel(features.keypoints_px[k]);
    const int point = PointOf(image, k);
    Append(px.x(), &bytes);
    Append(px.y(), &bytes);
    Append(point < 0 ? kNoPoint : std::uint64_t{IdOf(point)}, &bytes);
  }
  return bytes;
}

std::string PointBinary(std::size_t i, const ColmapModel& model) {
  std::string bytes;
  const ColmapPoint& point = model.points[i];
  Append<std::uint64_t>(i + 1, &bytes);
  for (const double value : point.position_in_map) Append(value, &bytes);
  bytes.append(3, '\0');
  Append(point.error_px, &bytes);
  Append<std::uint64_t>(point.end - point.begin, &bytes);
  for (const ColmapObservation& observation : model.TrackOf(point)) {
    Append(IdOf(observation.image_idx), &bytes);
    Append(static_cast<std::uint32_t>(observation.keypoint), &bytes);
  }
  return bytes;
}

std::string Count(std::uint64_t count) {
  std::string bytes;
  Append(count, &bytes);
  return bytes;
}

// A file that is written piece by piece, if it has a path.
class Pieces {
 public:
  using Paths = std::map<std::string, std::filesystem::path>;
  Pieces(const Paths& paths, const std::string& name, const std::string& head) {
    const auto found = paths.find(name);
    if (found == paths.end()) return;
    path_ = found->second;
    stream_.open(path_, std::ios::binary | std::ios::trunc);
    Write(head);
  }
  bool IsWanted() const { return !path_.empty(); }
  void Write(const std::string& piece) {
    stream_.write(piece.data(), static_cast<std::streamsize>(piece.size()));
    Check();
  }
  void Close() {
    if (!IsWanted()) return;
    stream_.close();
    Check();
  }

 private:
  void Check() const {
    if (!stream_) throw DataError("{}: cannot write: {}", path_.string(), std::strerror(errno));
  }
  std::filesystem::path path_;
  std::ofstream stream_;
};

void WriteImages(const ColmapModel& model, const Pieces::Paths& paths) {
  Pieces text(paths, "images.txt", kImagesHead);
  Pieces binary(paths, "images.bin", Count(model.images.size()));
  if (!text.IsWanted() && !binary.IsWanted()) return;
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const ColmapFeatures features = model.features(i);
    if (text.IsWanted()) text.Write(ImageText(i, model.images[i], features));
    if (binary.IsWanted()) binary.Write(ImageBinary(i, model.images[i], features));
  }
  text.Close();
  binary.Close();
}

void WritePoints(const ColmapModel& model, const Pieces::Paths& paths) {
  Pieces text(paths, "points3D.txt", kPointsHead);
  Pieces binary(paths, "points3D.bin", Count(model.points.size()));
  for (std::size_t i = 0; i < model.points.size(); ++i) {
    if (text.IsWanted()) text.Write(PointText(i, model));
    if (binary.IsWanted()) binary.Write(PointBinary(i, model));
  }
  text.Close();
  binary.Close();
}

}  // namespace

void ColmapModel::AddPoint(const Eigen::Vector3d& position_in_map,
                           double error_px,
                           const std::vector<ColmapObservation>& track) {
  for (const ColmapObservation& seen : track) {
    auto& shown = images[static_cast<std::size_t>(seen.image_idx)].keypoint_points;
    const auto keypoint = static_cast<std::size_t>(seen.keypoint);
    if (keypoint >= shown.size()) shown.resize(keypoint + 1, -1);
    shown[keypoint] = static_cast<int>(points.size());
  }
  const std::size_t begin = observations.size();
  observations.insert(observations.end(), track.begin(), track.end());
  points.push_back({position_in_map, error_px, begin, observations.size()});
}

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

void WriteColmapFiles(const ColmapModel& model,
                      const std::map<std::string, std::filesystem::path>& paths) {
  Pieces(paths, "cameras.txt", CamerasText(model)).Close();
  Pieces(paths, "cameras.bin", CamerasBinary(model)).Close();
  WriteImages(model, paths);
  WritePoints(model, paths);
}

}  // namespace nightmap
