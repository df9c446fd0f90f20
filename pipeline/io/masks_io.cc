// SPDX-License-Identifier: Apache-2.0
#include "pipeline/io/masks_io.h"

#include "pipeline/base/files.h"
#include "pipeline/io/hdf5_table.h"

namespace nightmap {
namespace {

constexpr char kMasksFormat[] = "nightmap masks";
constexpr int kMasksVersion = 1;
constexpr std::uint8_t kMoving = 255;

std::uint64_t NumPixels(const PackedMask& packed) {
  return static_cast<std::uint64_t>(packed.width) * static_cast<std::uint64_t>(packed.height);
}

constexpr auto kPackedMasks = Hdf5Table<PackedMask>(
    Hdf5Column("time_ns", &PackedMask::time_ns)
        .Pairs(Ascending(&PackedMask::time_ns), "does not ascend"),
    Hdf5Column("size_px", &PackedMask::width, &PackedMask::height).Elements(kPositive),
    Hdf5Lists(
        "run_offset", &PackedMask::runs, Hdf5Table<std::uint32_t>(Hdf5Column("run", kItself))));

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
  Hdf5Writer file(path, kMasksFormat, kMasksVersion, config, "pixels");
  kPackedMasks.Write(masks, &file);
  file.Close();
}

std::vector<PackedMask> ReadMasks(const std::filesystem::path& path) {
  const Hdf5Reader file(path, kMasksFormat, kMasksVersion);
  auto masks = kPackedMasks.Read(file);
  for (const PackedMask& mask : masks) {
    file.Demand(FillsPicture(mask), "run", "does not fill its picture");
  }
  return masks;
}

}  // namespace nightmap
