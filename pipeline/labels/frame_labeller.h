// SPDX-License-Identifier: Apache-2.0
// Where the labels of a frame come from: a network, or label pictures of the recording.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/io/frames_io.h"
#include "pipeline/labels/segmentation_model.h"

namespace nightmap {

// Throws UsageError naming the model file and the remedy when it is wrong or its network does not
// load or fit.
void CheckModel(const std::filesystem::path& model);

// Labels a frame by its pixels, or by its label picture. Several threads may call it at once.
// Throws DataError when this frame cannot be labelled.
using FrameLabeller = std::function<Segmentation(const FrameRecord&, const RgbdImages&)>;

// With a network: runs it on color, and on depth where there is depth. Without: reads the label
// picture of the recording, surely right, every so many pixels of one that is larger than the
// camera's `color`; throws DataError naming it when its size is not the picture's, or when it has a
// label that is no class. `cameras`: of the frames.
FrameLabeller MakeLabeller(const SegmentationModel& model,
                           const std::vector<RgbdCamera>& cameras,
                           const std::filesystem::path& data_root);

// Hash of all that labels follow from, but for the frame: the network and how pixels reach it, the
// number of classes, the camera, this program, OpenCV and the instructions that it finds.
std::string LabelSource(const SegmentationModel& model, const RgbdCamera& camera);

}  // namespace nightmap
