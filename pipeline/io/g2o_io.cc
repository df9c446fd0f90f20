// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/g2o_io.h"

#include <Eigen/LU>
#include <cmath>
#include <limits>
#include <set>
#include <sstream>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

namespace nightmap {
namespace {

// g2o's error is (translation, quaternion vector part); ours (rotation vector, translation). A
// rotation vector is twice the vector part.
Matrix6d G2oFromOurs() {
  Matrix6d ours_from_g2o = Matrix6d::Zero();
  ours_from_g2o.topRightCorner<3, 3>() = 2 * Eigen::Matrix3d::Identity();
  ours_from_g2o.bottomLeftCorner<3, 3>() = Eigen::Matrix3d::Identity();
  return ours_from_g2o;
}

std::string PoseText(const Rigid3& pose) {
  const Eigen::Vector3d& t = pose.translation;
  const Eigen::Quaterniond& q = pose.rotation;
  return fmt::format("{:.9g} {:.9g} {:.9g} {:.12g} {:.12g} {:.12g} {:.12g}",
                     t.x(),
                     t.y(),
                     t.z(),
                     q.x(),
                     q.y(),
                     q.z(),
                     q.w());
}

std::string EdgeText(const PoseEdge& edge) {
  const Matrix6d ours_from_g2o = G2oFromOurs();
  const Matrix6d information =
      ours_from_g2o.transpose() * edge.covariance.inverse() * ours_from_g2o;
  std::string text = fmt::format(
      "EDGE_SE3:QUAT {} {} {}", edge.frame_a, edge.frame_b, PoseText(edge.b_from_a.Inverse()));
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) text += fmt::format(" {:.9g}", information(row, col));
  }
  return text + "\n";
}

// Reads one line's numbers; refuses any that is not finite.
class LineReader {
 public:
  LineReader(const std::filesystem::path& path, int line_number, const std::string& line)
      : where_(fmt::format("{}:{}", path.string(), line_number)), stream_(line) {}

  std::string Tag() {
    std::string tag;
    stream_ >> tag;
    return tag;
  }
  double Number() {
    double value = 0;
    if (!(stream_ >> value) || !std::isfinite(value)) {
      throw DataError("{}: a finite number is missing", where_);
    }
    return value;
  }
  int Index() {
    const double value = Number();
    if (value < 0 || value > std::numeric_limits<int>::max() || value != std::floor(value)) {
      throw DataError("{}: {} is not the number of a vertex", where_, value);
    }
    return static_cast<int>(value);
  }
  Rigid3 Pose() {
    Rigid3 pose;
    for (int i = 0; i < 3; ++i) pose.translation[i] = Number();
    for (int i = 0; i < 4; ++i) pose.rotation.coeffs()[i] = Number();
    if (std::abs(pose.rotation.norm() - 1) > 1e-3) {
      throw DataError("{}: the quaternion is not of unit length", where_);
    }
    pose.rotation.normalize();
    return pose;
  }
  const std::string& Where() const { return where_; }

 private:
  std::string where_;
  std::istringstream stream_;
};

PoseEdge ReadEdge(LineReader& line) {
  PoseEdge edge;
  edge.frame_a = line.Index();
  edge.frame_b = line.Index();
  edge.b_from_a = line.Pose().Inverse();
  Matrix6d information;
  for (int row = 0; row < 6; ++row) {
    for (int col = row; col < 6; ++col) {
      information(row, col) = information(col, row) = line.Number();
    }
  }
  const Matrix6d ours_from_g2o = G2oFromOurs();
  edge.covariance = ours_from_g2o * information.inverse() * ours_from_g2o.transpose();
  return edge;
}

}  // namespace

std::string PoseGraphToG2o(const PoseGraph& graph) {
  std::string text;
  for (const PoseGraph::Vertex& vertex : graph.vertices) {
    text +=
        fmt::format("VERTEX_SE3:QUAT {} {}\n", vertex.frame_idx, PoseText(vertex.map_from_camera));
  }
  if (!graph.vertices.empty()) text += fmt::format("FIX {}\n", graph.vertices.front().frame_idx);
  for (const PoseEdge& edge : graph.edges) text += EdgeText(edge);
  return text;
}

PoseGraph ReadG2o(const std::filesystem::path& path) {
  PoseGraph graph;
  std::set<int> vertices;
  std::istringstream stream(ReadFile(path));
  std::string text;
  for (int line_number = 1; std::getline(stream, text); ++line_number) {
    LineReader line(path, line_number, text);
    const std::string tag = line.Tag();
    if (tag == "VERTEX_SE3:QUAT") {
      const int idx = line.Index();
      graph.vertices.push_back({idx, line.Pose()});
      if (!vertices.insert(idx).second) throw DataError("{}: vertex repeated", line.Where());
    } else if (tag == "EDGE_SE3:QUAT") {
      graph.edges.push_back(ReadEdge(line));
      if (!vertices.contains(graph.edges.back().frame_a) ||
          !vertices.contains(graph.edges.back().frame_b)) {
        throw DataError("{}: edge to a vertex that is not in the file", line.Where());
      }
    } else if (!tag.empty() && tag != "FIX") {
      throw DataError("{}: unknown tag '{}'", line.Where(), tag);
    }
  }
  return graph;
}

}  // namespace nightmap
