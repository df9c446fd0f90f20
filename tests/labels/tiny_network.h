// SPDX-License-Identifier: Apache-2.0
// A segmentation network of one 1x1 convolution, written as ONNX by hand, so that tests need no
// shared data.
#pragma once

#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include "tests/test_data.h"

namespace nightmap {

// One field of a protobuf message.
inline std::string Varint(std::uint64_t value) {
  std::string bytes;
  for (; value >= 128; value >>= 7) bytes += static_cast<char>(value | 128);
  return bytes + static_cast<char>(value);
}
inline std::string NumberField(int field, std::uint64_t value) {
  return Varint(static_cast<std::uint64_t>(field) << 3) + Varint(value);
}
inline std::string BytesField(int field, const std::string& bytes) {
  return Varint(static_cast<std::uint64_t>(field) << 3 | 2) + Varint(bytes.size()) + bytes;
}

// A TensorProto of floats.
inline std::string FloatTensor(const std::string& name,
                               const std::vector<std::uint64_t>& sizes,
                               const std::vector<float>& values) {
  std::string dims, data;
  for (const std::uint64_t size : sizes) dims += NumberField(1, size);
  for (const float value : values) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8) data += static_cast<char>(bits >> shift);
  }
  return dims + NumberField(2, 1) + BytesField(8, name) + BytesField(9, data);
}

// A ValueInfoProto of floats.
inline std::string FloatValue(const std::string& name, const std::vector<std::uint64_t>& sizes) {
  std::string dims;
  for (const std::uint64_t size : sizes) dims += BytesField(1, NumberField(1, size));
  return BytesField(1, name) +
         BytesField(2, BytesField(1, NumberField(1, 1) + BytesField(2, dims)));
}

// logits[c] = weights[n c ..] . input + bias[c], for an input of n channels of that size.
inline std::string TinyNetwork(std::uint64_t width,
                               std::uint64_t height,
                               const std::vector<float>& weights,
                               const std::vector<float>& bias) {
  const std::uint64_t num_classes = bias.size();
  const std::uint64_t num_channels = weights.size() / bias.size();
  const std::string kernel =
      BytesField(1, "kernel_shape") + NumberField(8, 1) + NumberField(8, 1) + NumberField(20, 7);
  const std::string node = BytesField(1, "input") + BytesField(1, "weights") +
                           BytesField(1, "bias") + BytesField(2, "logits") + BytesField(4, "Conv") +
                           BytesField(5, kernel);
  const std::string graph =
      BytesField(1, node) + BytesField(2, "tiny") +
      BytesField(5, FloatTensor("weights", {num_classes, num_channels, 1, 1}, weights)) +
      BytesField(5, FloatTensor("bias", {num_classes}, bias)) +
      BytesField(11, FloatValue("input", {1, num_channels, height, width})) +
      BytesField(12, FloatValue("logits", {1, num_classes, height, width}));
  return NumberField(1, 7) + BytesField(8, NumberField(2, 11)) + BytesField(7, graph);
}

// Three classes: the reddest pixels are "person" (1), the bluest "dog" (2), the rest "background".
// Input 40 x 30, (value - 127.5) / 127.5.
inline std::string RedAndBlueNetwork() {
  return TinyNetwork(40, 30, {0, 0, 0, 9, 0, -9, -9, 0, 9}, {3, 0, 0});
}

constexpr const char* kTinyModel = R"(network = "tiny.onnx"
input_width_px = 40
input_height_px = 30
mean = [127.5, 127.5, 127.5]
scale = [127.5, 127.5, 127.5]
channel_order = "rgb"
classes = ["background", "person", "dog"]
moving = ["person", "dog"]
)";

// Writes network and model file; returns the latter's path.
inline std::filesystem::path WriteTinyModel(const TemporaryFolder& folder) {
  folder.Write("tiny.onnx", RedAndBlueNetwork());
  return folder.Write("tiny.toml", kTinyModel);
}

}  // namespace nightmap
