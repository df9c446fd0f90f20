// SPDX-License-Identifier: Apache-2.0
// Sparse models in COLMAP's formats (https://colmap.github.io/format.html, version 3.8): text and
// binary with equal content, and the database of the same images. COLMAP's ids are our indices plus
// one. Its pixel (0, 0) is the corner of the top left pixel and ours is the centre, so writers add
// half a pixel to keypoints and principal points. Distortion is kept (FULL_OPENCV or
// OPENCV_FISHEYE; PINHOLE without any), so that a model fits the original pictures. Equal models
// give equal bytes.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "pipeline/geometry/camera.h"
#include "pipeline/geometry/rigid3.h"

namespace nightmap {

struct ColmapImage {
  std::string name;  // path of the picture below COLMAP's --image_path
  int camera_idx = 0;
  Rigid3 camera_from_map;
  // Point that each keypoint shows; -1: none. Keypoints behind the last that shows any are left
  // out.
  std::vector<int> keypoint_points = {};
};

struct ColmapFeatures {
  std::vector<Eigen::Vector2d> keypoints_px;  // in the distorted picture
  std::vector<std::uint8_t> descriptors;      // 128 bytes (RootSIFT) for each keypoint, or empty
};

// A keypoint of an image that shows a point.
struct ColmapObservation {
  int image_idx = 0;
  int keypoint = 0;
};

struct ColmapPoint {
  Eigen::Vector3d position_in_map = Eigen::Vector3d::Zero();
  double error_px = 0;             // mean reprojection error over the track
  std::size_t begin = 0, end = 0;  // of its track among the model's observations
};

// Writers ask for the features of one image at a time, in order: those of a night fit into no
// memory.
struct ColmapModel {
  std::vector<Camera> cameras;
  std::vector<ColmapImage> images;
  std::function<ColmapFeatures(std::size_t image_idx)> features;
  std::vector<ColmapPoint> points;  // black: the map has no colors
  std::vector<ColmapObservation> observations;

  // `track` ascends by image.
  void AddPoint(const Eigen::Vector3d& position_in_map,
                double error_px,
                const std::vector<ColmapObservation>& track);
  std::span<const ColmapObservation> TrackOf(const ColmapPoint& point) const {
    return std::span(observations).subspan(point.begin, point.end - point.begin);
  }
  // Mean of error_px, the figure that COLMAP's model_analyzer prints; 0 without points.
  double MeanReprojectionError_px() const;
};

// Reason why COLMAP cannot use the names of some images; empty when it can use all. Its reader of
// text models ends a name at the first blank (the binary model and the database keep the whole
// name), and it cannot open frames of a video ("clip.avi#12"). The model itself is still correct.
std::string UnusableColmapNames(const ColmapModel& model);

// Writes those of the files cameras, images and points3D, each .txt and .bin, that have a path.
// Writes names unchanged, even those that UnusableColmapNames reports. Throws DataError naming the
// file, and as the model's features.
void WriteColmapFiles(const ColmapModel& model,
                      const std::map<std::string, std::filesystem::path>& paths);

// Writes an SQLite database with cameras, images, keypoints, descriptors, and the matches that the
// tracks imply, as verified two-view geometry with the poses of the model. Each observation of a
// point is matched to the next kMaxNextMatched in its track, which COLMAP joins to the whole track.
// Replaces an existing file. COLMAP changes a database that it opens, so give it a copy. Throws
// DataError naming the file, and as the model's features.
constexpr int kMaxNextMatched = 8;
void WriteColmapDatabase(const std::filesystem::path& path, const ColmapModel& model);

}  // namespace nightmap
