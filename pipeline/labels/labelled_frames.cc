// SPDX-License-Identifier: Apache-2.0
#include "pipeline/labels/labelled_frames.h"

#include <fmt/format.h>
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <utility>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"
#include "pipeline/io/frame_labels.h"
#include "pipeline/io/frame_reader.h"

namespace nightmap {
namespace {

std::vector<double> ClassShares(const LabelImage& labels, std::size_t num_classes) {
  std::vector<double> shares(num_classes);
  for (const std::uint8_t label : labels.pixels) ++shares.at(label);
  for (double& share : shares) share /= static_cast<double>(labels.pixels.size());
  return shares;
}

// Handing the pages of freed pictures back and forth took a tenth of the time of labelling.
void KeepFreedPages() {
  mallopt(M_MMAP_THRESHOLD, 1 << 30);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
}

}  // namespace

LabelledFrames::LabelledFrames(const SegmentationModel& model,
                               FrameLabeller label,
                               const std::vector<FrameRecord>& frames,
                               KeptLabels kept,
                               std::vector<std::string> sources)
    : model_(model),
      label_(std::move(label)),
      frames_(frames),
      labelled_(frames.size()),
      kept_(std::move(kept)),
      sources_(std::move(sources)) {
  const auto has_label = [](const FrameRecord& frame) {
    return frame.others.contains(kLabelChannel);
  };
  if (model_.HasNetwork() || frames.empty() || std::ranges::any_of(frames, has_label)) return;
  throw UsageError(
      "{} names no network, and the frames have no label pictures: name `network` there, or "
      "`label_folder` in the [[sequence]] of the site config",
      model_.source);
}

bool LabelledFrames::CanLabel(std::size_t i) const {
  return model_.HasNetwork() || frames_[i].others.contains(kLabelChannel);
}

bool LabelledFrames::IsDue(std::size_t i, std::size_t last) const {
  if (!model_.HasNetwork()) return CanLabel(i);
  const double gap_s = 1e-9 * static_cast<double>(frames_[i].time_ns - frames_[last].time_ns);
  const bool moves = labelled_[last] && NumMasked(labelled_[last]->mask) > 0;
  return gap_s >= (moves ? model_.moving_gap_s : model_.still_gap_s);
}

// All frames of a video have its hash; the path has their number.
std::string LabelledFrames::SourceOf(const FrameRecord& frame) const {
  const auto camera_idx = static_cast<std::size_t>(frame.camera_idx);
  std::string text = fmt::format("{}\n{}\n{}\n{} {}",
                                 sources_.empty() ? "" : sources_.at(camera_idx),
                                 frame.color.path,
                                 frame.color.hash,
                                 frame.depth.path,
                                 frame.depth.hash);
  for (const auto& [channel, file] : frame.others) {
    text += fmt::format("\n{} {}", channel, file.hash);
  }
  return HashBytes(text);
}

GrayImage LabelledFrames::Label(std::size_t i, const RgbdImages& images) {
  const FrameRecord& frame = frames_[i];
  const std::string source = SourceOf(frame);
  auto found = kept_.Find(source);
  const bool is_kept = found.has_value();
  if (!is_kept) {
    Segmentation labels = label_(frame, images);
    PackedLabels packed = PackLabels(frame.frame_idx, frame.time_ns, labels);
    found = KeptLabels::Found{std::move(packed), std::move(labels)};
  }
  found->packed.frame_idx = frame.frame_idx;
  found->packed.time_ns = frame.time_ns;
  GrayImage moving = MovingMask(found->labels, model_.classes, model_.mask);
  labelled_[i] = Labelled{std::move(found->packed),
                          PackMask(frame.time_ns, moving),
                          ClassShares(found->labels.labels, model_.classes.names.size()),
                          source,
                          is_kept};
  return moving;
}

LabelsShard LabelledFrames::Labels() const {
  LabelsShard shard{model_.classes, {}};
  for (const auto& frame : labelled_) {
    if (frame) shard.frames.push_back(frame->labels);
  }
  return shard;
}

std::vector<PackedMask> LabelledFrames::Masks() const {
  std::vector<PackedMask> masks;
  for (const auto& frame : labelled_) {
    if (frame) masks.push_back(frame->mask);
  }
  return masks;
}

std::vector<FrameRecord> LabelledFrames::FramesWithLabels(const std::string& labels,
                                                          const std::string& masks) const {
  std::vector<FrameRecord> frames = frames_;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    if (!labelled_[i]) continue;
    frames[i].others[kLabelsChannel] = {labels, HashOf(labelled_[i]->labels, model_.classes.names)};
    frames[i].others[kMaskChannel] = {masks, HashOf(labelled_[i]->mask)};
  }
  return frames;
}

nlohmann::json LabelledFrames::Summarize() const {
  const LabelClasses& classes = model_.classes;
  std::vector<double> sums(classes.names.size());
  std::vector<int> frame_idx;
  std::vector<double> moving_shares;
  for (const auto& frame : labelled_) {
    if (!frame) continue;
    double moving = 0;
    for (std::size_t c = 0; c < sums.size(); ++c) {
      sums[c] += frame->class_shares[c];
      if (classes.moving[c] != 0) moving += frame->class_shares[c];
    }
    frame_idx.push_back(frame->labels.frame_idx);
    moving_shares.push_back(moving);
  }
  nlohmann::json mean_shares = nlohmann::json::object();
  for (std::size_t c = 0; c < sums.size(); ++c) {
    if (sums[c] > 0)
      mean_shares[classes.names[c]] = sums[c] / static_cast<double>(frame_idx.size());
  }
  return {{"num_frames", frames_.size()},
          {"num_labelled_frames", frame_idx.size()},
          {"num_frames_mostly_moving",
           std::ranges::count_if(moving_shares, [](double share) { return share > 0.5; })},
          {"mean_class_shares", mean_shares},
          {"labelled_frame_idx", frame_idx},
          {"moving_shares", moving_shares}};
}

void LabelledFrames::Keep() const {
  std::map<std::int64_t, std::string> sources;
  std::size_t num_kept = 0;
  for (const auto& frame : labelled_) {
    if (!frame) continue;
    sources[frame->labels.time_ns] = frame->source;
    num_kept += frame->is_kept ? 1 : 0;
  }
  spdlog::info(
      "{} frames with labels, {} of them labelled anew", sources.size(), sources.size() - num_kept);
  kept_.Save(Labels(), sources);
}

void LabelledFrames::Write(StageContext& context) const {
  WriteLabels(context.Output("labels"), Labels(), context.ConfigToml());
  WriteMasks(context.Output("masks"), Masks(), context.ConfigToml());
  const auto name_of = [&](const char* output) {
    return context.FinalPath(output).filename().string();
  };
  WriteFile(context.Output("frames"),
            FramesToCsv(FramesWithLabels(name_of("labels"), name_of("masks"))));
  context.Report().update(Summarize());
  Keep();
}

LabelledFrames MakeLabelledFrames(const std::vector<FrameRecord>& frames,
                                  const std::vector<RgbdCamera>& cameras,
                                  StageContext& context) {
  const SegmentationModel model = ReadSegmentationModel(context.Input("model"));
  if (model.HasNetwork()) {
    context.AddInput(model.network, context.Input("model"));
    KeepFreedPages();
  }
  std::vector<std::string> sources;
  for (const RgbdCamera& camera : cameras) sources.push_back(LabelSource(model, camera));
  return {model,
          MakeLabeller(model, cameras, context.Input("data")),
          frames,
          KeptLabels(context.FinalPath("labels")),
          std::move(sources)};
}

}  // namespace nightmap
