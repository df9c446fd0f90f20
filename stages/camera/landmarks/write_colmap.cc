// SPDX-License-Identifier: Apache-2.0
#include "stages/camera/landmarks/write_colmap.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <map>
#include <string>

#include "pipeline/io/landmarks_io.h"
#include "stages/camera/landmarks/colmap_export.h"

namespace nightmap {
namespace {

constexpr std::array kModels = {"txt", "bin"};
constexpr std::array kParts = {"cameras.", "images.", "points3D."};

std::ptrdiff_t NumParts(const StageContext& context, const std::string& model) {
  return std::ranges::count_if(kParts,
                               [&](const char* part) { return context.HasOutput(part + model); });
}

// Paths by name of the files that are outputs.
std::map<std::string, std::filesystem::path> ModelPaths(StageContext& context) {
  std::map<std::string, std::filesystem::path> paths;
  for (const std::string model : kModels) {
    for (const char* part : kParts) {
      const std::string name = part + model;
      if (context.HasOutput(name)) paths[name] = context.Output(name);
    }
  }
  return paths;
}

void Report(const ColmapModel& model, nlohmann::json& report) {
  const std::string unusable_names = UnusableColmapNames(model);
  if (!unusable_names.empty()) spdlog::warn("COLMAP export: {}", unusable_names);
  report["num_colmap_points"] = model.points.size();
  report["mean_reprojection_error_px"] = model.MeanReprojectionError_px();
  report["colmap_names_usable"] = unusable_names.empty();
  if (!unusable_names.empty()) report["colmap_names_reason"] = unusable_names;
}

}  // namespace

void CheckColmapOutputs(const StageContext& context) {
  for (const std::string model : kModels) {
    const auto num_parts = NumParts(context, model);
    if (num_parts == 0 || num_parts == std::ssize(kParts)) continue;
    throw UsageError(
        "give --out cameras.{0}=PATH, --out images.{0}=PATH and --out points3D.{0}=PATH, or none",
        model);
  }
}

void WriteColmap(const LandmarksInput& input,
                 const std::filesystem::path& landmarks,
                 StageContext& context) {
  const bool has_model =
      std::ranges::any_of(kModels, [&](const char* model) { return NumParts(context, model) > 0; });
  if (!has_model && !context.HasOutput("database")) return;
  LandmarksReader reader(landmarks);
  ColmapModel model = StartColmapModel(input, reader.Head());
  for (std::size_t i = 0; i < reader.Regions().size(); ++i) {
    AddColmapPoints(reader.Read(i), &model);
  }
  WriteColmapFiles(model, ModelPaths(context));
  if (context.HasOutput("database")) WriteColmapDatabase(context.Output("database"), model);
  Report(model, context.Report());
}

}  // namespace nightmap
