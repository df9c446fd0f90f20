// SPDX-License-Identifier: Apache-2.0
#include "stages/laser/import_poses/import_poses.h"

#include <cmath>

#include "pipeline/base/input_error.h"
#include "pipeline/geometry/rigid2.h"
#include "pipeline/io/trajectory_io.h"
#include "pipeline/recording/choose_signal.h"
#include "pipeline/recording/read_signals.h"

namespace nightmap {
namespace {

std::vector<StampedPose> ReadLog(const ImportPosesOptions& options,
                                 const std::filesystem::path& path) {
  SiteConfig site;
  SensorConfig sensor;
  sensor.id = "poses";
  sensor.kind = SignalKind::kOdometry;
  site.sensors.push_back(sensor);
  SignalConfig signal;
  signal.format = "carmen";
  signal.file = path.filename().string();
  signal.message = options.message;
  site.signals.push_back(signal);
  const SensorSignals log = ReadSensorSignals(site, path.parent_path(), options.max_failed_ratio);
  std::vector<StampedPose> poses;
  for (const SignalSample& sample : log.signals.front().samples) {
    poses.push_back({sample.time_ns, Rigid2{sample.value[2], sample.value.head<2>()}.ToRigid3()});
  }
  return poses;
}

bool IsTum(const std::filesystem::path& path) {
  return path.extension() == ".tum" || path.extension() == ".txt";
}

}  // namespace

std::vector<StampedPose> ReadGivenPoses(const ImportPosesOptions& options,
                                        const std::filesystem::path& path) {
  return IsTum(path) ? ReadTum(path) : ReadLog(options, path);
}

void CheckGivenPoses(const std::filesystem::path& path) {
  if (IsTum(path)) ReadTum(path);
}

ImportPosesResult RunImportPoses(const ImportPosesOptions& options, const ImportPosesInput& input) {
  const Signal& scans = ChooseScanner(input.scans, options.scan_sensor, "import_poses.scan_sensor");
  const auto max_gap_ns = static_cast<std::int64_t>(std::llround(1e9 * options.max_gap_s));
  ImportPosesResult result;
  result.num_scans = scans.samples.size();
  for (const SignalSample& scan : scans.samples) {
    if (const auto pose = PoseAt(input.given, scan.time_ns, max_gap_ns)) {
      result.poses.push_back({scan.time_ns, *pose});
    } else {
      result.skipped.push_back(
          fmt::format("scan at {}: no given pose is near in time", TimeToString(scan.time_ns)));
    }
  }
  if (result.poses.empty()) {
    throw InputError({{"given"}, {"scans"}},
                     InputError::Remedy::kInText,
                     "no scan has a pose; the times of both must be of one clock (`make inspect` "
                     "shows those of the scans)");
  }
  return result;
}

}  // namespace nightmap
