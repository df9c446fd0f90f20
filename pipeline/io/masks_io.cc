// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/masks_io.h"

#include "pipeline/base/files.h"
#include "pipeline/io/hdf5_file.h"

namespace nightmap {
namespace {

constexpr char kMasksFormat[] = "nightmap masks";
constexpr int kMasksVersion = 1;
constexpr std::uint8_t kMoving = 255;

std::uint64_t NumPixels(const PackedMask& packed) {
  return static_cast<std::uint64_t>(packed.width) * static_cast<std::uint64_t>(packed.height);
}

}  // namespace

PackedMask PackMask(std::int64_t time_ns, const GrayImage& mask) {
  PackedMask packed{time_ns, mask.width, mask.height, {}};
  bool is_masked = false;
  std::uint32_t length = 0;
  for (const std::uint8_t pixel : mask.pixels) {
    if ((pixel != 0) != is_masked) {
      packed.runs.push_back(length);
      length = 0;
      is_masked = !is_masked;
    }
    ++length;
  }
  packed.runs.push_back(length);
  return packed;
}

GrayImage UnpackMask(const PackedMask& packed) {
  GrayImage mask{packed.width, packed.height, 1, {}};
  mask.pixels.reserve(NumPixels(packed));
  for (std::size_t i = 0; i < packed.runs.size(); ++i) {
    mask.pixels.insert(mask.pixels.end(), packed.runs[i], i % 2 == 1 ? kMoving : 0);
  }
  return mask;
}

std::string HashOf(const PackedMask& packed) {
  const auto* const bytes = reinterpret_cast<const char*>(packed.runs.data());
  const std::string size = std::to_string(packed.width) + " ";
  return HashBytes(size + std::string(bytes, packed.runs.size() * sizeof(std::uint32_t)));
}

std::size_t NumMasked(const PackedMask& packed) {
  std::size_t count = 0;
  for (std::size_t i = 1; i < packed.runs.size(); i += 2) count += packed.runs[i];
  return count;
}

bool FillsPicture(const PackedMask& packed) {
  std::uint64_t sum = 0;
  for (std::size_t i = 0; i < packed.runs.size(); ++i) {
    if (packed.runs[i] == 0 && i > 0) return false;
    sum += packed.runs[i];
  }
  return sum == NumPixels(packed);
}

void WriteMasks(const std::filesystem::path& path,
                const std::vector<PackedMask>& masks,
                const std::string& config) {
  std::vector<std::int64_t> time_ns, offset = {0};
  Array<std::int32_t> size_px{masks.size(), 2, {}};
  std::vector<std::uint32_t> runs;
  for (const PackedMask& mask : masks) {
    time_ns.push_back(mask.time_ns);
    size_px.values.insert(size_px.values.end(), {mask.width, mask.height});
    runs.insert(runs.end(), mask.runs.begin(), mask.runs.end());
    offset.push_back(static_cast<std::int64_t>(runs.size()));
  }
  Hdf5Writer file(path, kMasksFormat, kMasksVersion, config, "pixels");
  file.WriteList("time_ns", time_ns);
  file.Write("size_px", size_px);
  file.WriteList("run_offset", offset);
  file.WriteList("run", runs);
  file.Close();
}

std::vector<PackedMask> ReadMasks(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kMasksFormat, kMasksVersion);
  const auto time_ns = file.ReadList<std::int64_t>("time_ns");
  const auto size_px = file.Read<std::int32_t>("size_px", 2);
  const auto offset = file.ReadList<std::int64_t>("run_offset");
  const auto runs = file.ReadList<std::uint32_t>("run");
  file.Demand(size_px.rows == time_ns.size(), "size_px");
  file.Demand(offset.size() == time_ns.size() + 1 && offset.front() == 0 &&
                  offset.back() == static_cast<std::int64_t>(runs.size()),
              "run_offset");
  std::vector<PackedMask> masks;
  for (std::size_t i = 0; i < time_ns.size(); ++i) {
    file.Demand(i == 0 || time_ns[i - 1] < time_ns[i], "time_ns", "does not ascend");
    file.Demand(0 <= offset[i] && offset[i] <= offset[i + 1] && offset[i + 1] <= offset.back(),
                "run_offset");
    const int width = size_px.values[2 * i], height = size_px.values[2 * i + 1];
    file.Demand(width > 0 && height > 0, "size_px");
    masks.push_back(
        {time_ns[i], width, height, {runs.begin() + offset[i], runs.begin() + offset[i + 1]}});
    file.Demand(FillsPicture(masks.back()), "run", "does not fill its picture");
  }
  return masks;
}

}  // namespace nightmap
