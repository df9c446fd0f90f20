// SPDX-License-Identifier: Apache-2.0
// The database of colmap_io.h.
#include <sqlite3.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <map>
#include <memory>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/io/colmap_camera.h"
#include "pipeline/io/colmap_io.h"

namespace nightmap {
namespace {

// The schema that COLMAP 3.8 creates.
constexpr char kSchema[] = R"(
PRAGMA journal_mode = OFF;
PRAGMA synchronous = OFF;
PRAGMA user_version = 3800;
CREATE TABLE cameras (camera_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, model INTEGER NOT NULL,
  width INTEGER NOT NULL, height INTEGER NOT NULL, params BLOB, prior_focal_length INTEGER NOT NULL);
CREATE TABLE images (image_id INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, name TEXT NOT NULL UNIQUE,
  camera_id INTEGER NOT NULL, prior_qw REAL, prior_qx REAL, prior_qy REAL, prior_qz REAL,
  prior_tx REAL, prior_ty REAL, prior_tz REAL,
  CONSTRAINT image_id_check CHECK(image_id >= 0 and image_id < 2147483647),
  FOREIGN KEY(camera_id) REFERENCES cameras(camera_id));
CREATE UNIQUE INDEX index_name ON images(name);
CREATE TABLE keypoints (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL,
  cols INTEGER NOT NULL, data BLOB, FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE descriptors (image_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL,
  cols INTEGER NOT NULL, data BLOB, FOREIGN KEY(image_id) REFERENCES images(image_id) ON DELETE CASCADE);
CREATE TABLE matches (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL,
  cols INTEGER NOT NULL, data BLOB);
CREATE TABLE two_view_geometries (pair_id INTEGER PRIMARY KEY NOT NULL, rows INTEGER NOT NULL,
  cols INTEGER NOT NULL, data BLOB, config INTEGER NOT NULL, F BLOB, E BLOB, H BLOB, qvec BLOB, tvec BLOB);
BEGIN;
)";
constexpr int kDescriptorSize = 128;
constexpr int kCalibrated = 2;  // COLMAP's TwoViewGeometry::CALIBRATED
constexpr std::int64_t kMaxImages = 2147483647;

class Database {
 public:
  explicit Database(const std::filesystem::path& path) : path_(path) {
    sqlite3* opened = nullptr;
    const int status = sqlite3_open(path.c_str(), &opened);
    handle_.reset(opened);
    Check(status);
  }
  void Execute(const char* sql) {
    Check(sqlite3_exec(handle_.get(), sql, nullptr, nullptr, nullptr));
  }
  void Check(int status) const {
    if (status == SQLITE_OK || status == SQLITE_DONE) return;
    throw DataError("{}: SQLite: {}", path_.string(), sqlite3_errmsg(handle_.get()));
  }
  sqlite3* Handle() const { return handle_.get(); }

 private:
  struct Closer {
    void operator()(sqlite3* handle) const { sqlite3_close(handle); }
  };
  std::filesystem::path path_;
  std::unique_ptr<sqlite3, Closer> handle_;
};

// Inserts rows into one table, values in the order of its columns.
class Inserter {
 public:
  Inserter(const Database& database, const std::string& table, int num_columns)
      : database_(database) {
    std::string sql = "INSERT INTO " + table + " VALUES (?";
    for (int i = 1; i < num_columns; ++i) sql += ", ?";
    sqlite3_stmt* prepared = nullptr;
    database_.Check(
        sqlite3_prepare_v2(database_.Handle(), (sql + ")").c_str(), -1, &prepared, nullptr));
    statement_.reset(prepared);
  }
  Inserter& Number(std::int64_t value) {
    database_.Check(sqlite3_bind_int64(statement_.get(), ++column_, value));
    return *this;
  }
  Inserter& Text(const std::string& text) {
    database_.Check(
        sqlite3_bind_text(statement_.get(), ++column_, text.c_str(), -1, SQLITE_TRANSIENT));
    return *this;
  }
  template <typename T>
  Inserter& Blob(const T* values, std::size_t count) {
    database_.Check(sqlite3_bind_blob64(statement_.get(),
                                        ++column_,
                                        count ? values : nullptr,
                                        count * sizeof(T),
                                        SQLITE_TRANSIENT));
    return *this;
  }
  // Columns not given are NULL.
  void Insert() {
    database_.Check(sqlite3_step(statement_.get()));
    database_.Check(sqlite3_reset(statement_.get()));
    database_.Check(sqlite3_clear_bindings(statement_.get()));
    column_ = 0;
  }

 private:
  struct Finalizer {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  const Database& database_;
  std::unique_ptr<sqlite3_stmt, Finalizer> statement_;
  int column_ = 0;
};

void InsertCameras(const ColmapModel& model, const Database& database) {
  Inserter cameras(database, "cameras", 6);
  for (std::size_t i = 0; i < model.cameras.size(); ++i) {
    const ColmapCamera camera = ToColmap(model.cameras[i]);
    cameras.Number(static_cast<std::int64_t>(i) + 1).Number(camera.model_id);
    cameras.Number(camera.width).Number(camera.height);
    cameras.Blob(camera.parameters.data(), camera.parameters.size()).Number(1).Insert();
  }
}

void InsertImages(const ColmapModel& model, const Database& database) {
  Inserter images(database, "images", 10);
  Inserter keypoints(database, "keypoints", 4);
  Inserter descriptors(database, "descriptors", 4);
  for (std::size_t i = 0; i < model.images.size(); ++i) {
    const ColmapImage& image = model.images[i];
    const auto id = static_cast<std::int64_t>(i) + 1;
    images.Number(id).Text(image.name).Number(image.camera_idx + 1).Insert();
    const ColmapFeatures features = model.features(i);
    std::vector<float> pixels;
    for (const Eigen::Vector2d& keypoint_px : features.keypoints_px) {
      const Eigen::Vector2f pixel = ToColmapPixel(keypoint_px).cast<float>();
      pixels.insert(pixels.end(), {pixel.x(), pixel.y()});
    }
    const auto num_keypoints = static_cast<std::int64_t>(features.keypoints_px.size());
    keypoints.Number(id)
        .Number(num_keypoints)
        .Number(2)
        .Blob(pixels.data(), pixels.size())
        .Insert();
    if (features.descriptors.empty()) continue;
    descriptors.Number(id).Number(num_keypoints).Number(kDescriptorSize);
    descriptors.Blob(features.descriptors.data(), features.descriptors.size()).Insert();
  }
}

// Matches of one image by the second image: keypoints of the first and the second by turns, in
// order of the points.
using ImageMatches = std::map<int, std::vector<std::uint32_t>>;

ImageMatches MatchesOfTracks(const ColmapModel& model, int first) {
  std::vector<int> seen;
  for (const int point : model.images[static_cast<std::size_t>(first)].keypoint_points) {
    if (point >= 0) seen.push_back(point);
  }
  std::ranges::sort(seen);
  ImageMatches matches;
  for (const int point : seen) {
    const auto track = model.TrackOf(model.points[static_cast<std::size_t>(point)]);
    const auto own = std::ranges::lower_bound(track, first, {}, &ColmapObservation::image_idx);
    const auto next = track.subspan(static_cast<std::size_t>(own - track.begin()) + 1);
    for (const ColmapObservation& other :
         next.first(std::min<std::size_t>(next.size(), kMaxNextMatched))) {
      auto& pair = matches[other.image_idx];
      pair.push_back(static_cast<std::uint32_t>(own->keypoint));
      pair.push_back(static_cast<std::uint32_t>(other.keypoint));
    }
  }
  return matches;
}

void InsertMatches(const ColmapModel& model, const Database& database) {
  using RowMajor = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;
  Inserter matches(database, "matches", 4);
  Inserter geometries(database, "two_view_geometries", 10);
  const RowMajor unknown = RowMajor::Zero();  // of the fundamental matrix and the homography
  for (int a = 0; a < static_cast<int>(model.images.size()); ++a) {
    for (const auto& [b, pair] : MatchesOfTracks(model, a)) {
      const std::int64_t pair_id = kMaxImages * (a + 1) + b + 1;
      const auto num_matches = static_cast<std::int64_t>(pair.size() / 2);
      const Rigid3 b_from_a = model.images[static_cast<std::size_t>(b)].camera_from_map *
                              model.images[static_cast<std::size_t>(a)].camera_from_map.Inverse();
      const RowMajor essential =
          Skew(b_from_a.translation.normalized()) * b_from_a.rotation.toRotationMatrix();
      const Eigen::Quaterniond& q = b_from_a.rotation;
      const Eigen::Vector4d q_wxyz(q.w(), q.x(), q.y(), q.z());
      matches.Number(pair_id).Number(num_matches).Number(2).Blob(pair.data(), pair.size()).Insert();
      geometries.Number(pair_id).Number(num_matches).Number(2).Blob(pair.data(), pair.size());
      geometries.Number(kCalibrated).Blob(unknown.data(), 9).Blob(essential.data(), 9);
      geometries.Blob(unknown.data(), 9).Blob(q_wxyz.data(), 4);
      geometries.Blob(b_from_a.translation.data(), 3).Insert();
    }
  }
}

}  // namespace

void WriteColmapDatabase(const std::filesystem::path& path, const ColmapModel& model) {
  std::error_code ignored;
  std::filesystem::remove(path, ignored);  // because SQLite would add to an existing file
  Database database(path);
  database.Execute(kSchema);
  InsertCameras(model, database);
  InsertImages(model, database);
  InsertMatches(model, database);
  database.Execute("COMMIT");
}

}  // namespace nightmap
