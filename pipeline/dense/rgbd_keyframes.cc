// SPDX-License-Identifier: Apache-2.0
#include "pipeline/dense/rgbd_keyframes.h"

#include "pipeline/base/error.h"
#include "pipeline/dense/back_project.h"

namespace nightmap {
namespace {

const RgbdCamera& CameraOf(const Keyframe& keyframe, const std::vector<RgbdCamera>& cameras) {
  return cameras[static_cast<std::size_t>(keyframe.frame.camera_idx)];
}

// False only when all depth pixels, the camera, and thus the rays between them, lie on one side of
// `area`.
bool MaySee(const Rectangle& area,
            const Keyframe& keyframe,
            const RayTable& rays,
            const DepthImage& depth) {
  const Eigen::Vector2d centre = keyframe.map_from_camera.translation.head<2>();
  if (area.Contains(centre)) return true;
  const Eigen::Matrix<float, 2, 3> turn =
      keyframe.map_from_camera.rotation.toRotationMatrix().topRows<2>().cast<float>();
  Eigen::Array2f min = Eigen::Array2f::Zero(), max = Eigen::Array2f::Zero();
  for (std::size_t i = 0; i < depth.pixels.size(); ++i) {
    const Eigen::Array2f offset = turn * (depth.pixels[i] * rays[i].homogeneous());
    min = min.min(offset);
    max = max.max(offset);
  }
  // Single-precision offsets are accurate to a micrometre here.
  constexpr double kSlack_m = 1e-4;
  return area.Grown(kSlack_m).Touches(centre + min.matrix().cast<double>(),
                                      centre + max.matrix().cast<double>());
}

}  // namespace

KeyframeSource OpenTile(const StageContext& context, int stride, double max_range_m) {
  const std::filesystem::path& tile_path = context.Input("tile");
  const std::filesystem::path& cameras_path = context.Input("cameras");
  const FrameReader reader(context.Input("data"), context.Inputs("masks"));
  Tile tile = ReadTile(tile_path);
  if (!(max_range_m <= tile.region.max_range_m)) {
    throw UsageError(
        "{} lists the keyframes within {} m, {} m are asked for; raise tiles.max_range_m",
        tile_path.string(),
        tile.region.max_range_m,
        max_range_m);
  }
  KeyframeSource source;
  source.region = tile.region;
  source.cameras = ReadCameras(cameras_path);
  for (Keyframe& keyframe : tile.keyframes) {
    CheckCamera(keyframe.frame, source.cameras, cameras_path.string());
    if (keyframe.keyframe_idx % stride != 0 || !reader.MayUse(keyframe.frame)) continue;
    source.keyframes.push_back(std::move(keyframe));
  }
  // The color picture of a keyframe that sees nothing of the tile is never decoded.
  const Rectangle seen = tile.region.inside.Grown(tile.region.overlap_m);
  source.load = [cameras = source.cameras, rays = MakeRayTables(source.cameras, 1), reader, seen](
                    const Keyframe& keyframe) {
    const RgbdCamera& camera = CameraOf(keyframe, cameras);
    const RayTable& table = rays[static_cast<std::size_t>(keyframe.frame.camera_idx)];
    RgbdImages images;
    images.depth = reader.Depth(keyframe.frame, camera);
    if (!MaySee(seen, keyframe, table, images.depth)) return RgbdImages{};
    images.color = reader.Color(keyframe.frame, camera);
    return images;
  };
  source.load_depth = [cameras = source.cameras, reader](const Keyframe& keyframe) {
    return reader.Depth(keyframe.frame, CameraOf(keyframe, cameras));
  };
  return source;
}

}  // namespace nightmap
