// SPDX-License-Identifier: Apache-2.0
#include "pipeline/world/ray_scene.h"

#include <embree3/rtcore.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pipeline/base/error.h"

namespace nightmap {

namespace {

// Data to place a hit on its parallelogram.
struct Plane {
  Eigen::Vector3d origin;
  Eigen::Vector3d normal;
  Eigen::Vector3d dual_u;  // dot with (point - origin) gives a
  Eigen::Vector3d dual_v;
};

Plane MakePlane(const Surface& surface) {
  return {surface.origin,
          surface.Normal(),
          surface.edge_u / surface.edge_u.squaredNorm(),
          surface.edge_v / surface.edge_v.squaredNorm()};
}

// Whether a ray hardly crosses the plane, which then does not tell where they meet.
bool IsAlong(const Plane& plane, const Eigen::Vector3d& direction) {
  return std::abs(plane.normal.dot(direction)) <= 1e-9;
}

RayHit Place(const Plane& plane,
             int surface_idx,
             const Eigen::Vector3d& origin,
             const Eigen::Vector3d& direction,
             double distance) {
  const Eigen::Vector3d on_surface = origin + distance * direction - plane.origin;
  return {surface_idx,
          distance,
          std::clamp(plane.dual_u.dot(on_surface), 0.0, 1.0),
          std::clamp(plane.dual_v.dot(on_surface), 0.0, 1.0)};
}

RTCRay MakeRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double far) {
  RTCRay ray{};
  ray.org_x = static_cast<float>(origin.x());
  ray.org_y = static_cast<float>(origin.y());
  ray.org_z = static_cast<float>(origin.z());
  ray.dir_x = static_cast<float>(direction.x());
  ray.dir_y = static_cast<float>(direction.y());
  ray.dir_z = static_cast<float>(direction.z());
  ray.tnear = 0;
  ray.tfar = static_cast<float>(far);
  ray.mask = ~0U;
  return ray;
}

void FillGeometry(RTCGeometry geometry, const std::vector<Surface>& surfaces) {
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry,
                                                               RTC_BUFFER_TYPE_VERTEX,
                                                               0,
                                                               RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float),
                                                               4 * surfaces.size()));
  auto* indices = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, 4 * sizeof(unsigned), surfaces.size()));
  if (vertices == nullptr || indices == nullptr) throw DataError("no memory for the ray scene");
  for (std::size_t i = 0; i < surfaces.size(); ++i) {
    const Surface& surface = surfaces[i];
    const std::array<Eigen::Vector3d, 4> corners = {
        surface.origin,
        surface.origin + surface.edge_u,
        surface.origin + surface.edge_u + surface.edge_v,
        surface.origin + surface.edge_v};
    for (std::size_t k = 0; k < 4; ++k) {
      const Eigen::Vector3f corner = corners[k].cast<float>();
      std::copy_n(corner.data(), 3, vertices + (4 * i + k) * 3);
      indices[4 * i + k] = static_cast<unsigned>(4 * i + k);
    }
  }
}

}  // namespace

struct RayScene::Impl {
  RTCDevice device = nullptr;
  RTCScene scene = nullptr;
  std::vector<Plane> planes;
};

RayScene::RayScene(const std::vector<Surface>& surfaces) : impl_(std::make_unique<Impl>()) {
  // One thread builds, and SSE 4.2 is on every machine: so the tree and the rounding are the same
  // everywhere.
  impl_->device = rtcNewDevice("threads=1,isa=sse4.2");
  if (impl_->device == nullptr) throw DataError("Embree does not start on this machine");
  RTCGeometry geometry = rtcNewGeometry(impl_->device, RTC_GEOMETRY_TYPE_QUAD);
  FillGeometry(geometry, surfaces);
  rtcCommitGeometry(geometry);
  impl_->scene = rtcNewScene(impl_->device);
  rtcSetSceneFlags(impl_->scene, RTC_SCENE_FLAG_ROBUST);
  rtcAttachGeometry(impl_->scene, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(impl_->scene);
  for (const Surface& surface : surfaces) impl_->planes.push_back(MakePlane(surface));
}

RayScene::~RayScene() {
  rtcReleaseScene(impl_->scene);
  rtcReleaseDevice(impl_->device);
}

RayHit RayScene::Cast(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction) const {
  RTCRayHit query{};
  query.ray = MakeRay(origin, direction, std::numeric_limits<float>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect1(impl_->scene, &context, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return {};
  // Embree computes in single precision, so the hit's plane gives the distance in double precision.
  const Plane& plane = impl_->planes[query.hit.primID];
  const int surface_idx = static_cast<int>(query.hit.primID);
  if (IsAlong(plane, direction)) {
    return Place(plane, surface_idx, origin, direction, static_cast<double>(query.ray.tfar));
  }
  return HitOn(surface_idx, origin, direction);
}

RayHit RayScene::HitOn(int surface_idx,
                       const Eigen::Vector3d& origin,
                       const Eigen::Vector3d& direction) const {
  const Plane& plane = impl_->planes[static_cast<std::size_t>(surface_idx)];
  if (IsAlong(plane, direction)) return Cast(origin, direction);
  const double distance = plane.normal.dot(plane.origin - origin) / plane.normal.dot(direction);
  return Place(plane, surface_idx, origin, direction, distance);
}

bool RayScene::IsBlocked(const Eigen::Vector3d& origin,
                         const Eigen::Vector3d& direction,
                         double max_distance) const {
  RTCRay ray = MakeRay(origin, direction, max_distance);
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(impl_->scene, &context, &ray);
  return ray.tfar < 0;
}

}  // namespace nightmap
