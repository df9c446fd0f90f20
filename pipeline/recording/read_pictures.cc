// SPDX-License-Identifier: Apache-2.0
// Plain pictures: a folder of them, sorted by name, a .txt list of paths relative to itself, or one
// file. They have no times, so picture N is at N seconds.
#include <algorithm>
#include <array>
#include <cctype>

#include "pipeline/base/error.h"
#include "pipeline/io/text_file.h"
#include "pipeline/recording/read_sequence.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::string_view, 11> kSuffixes = {
    ".jpg", ".jpeg", ".png", ".tif", ".tiff", ".bmp", ".ppm", ".pgm", ".webp", ".heic", ".heif"};
constexpr std::int64_t kPeriod_ns = 1'000'000'000;

std::string Suffix(const fs::path& path) {
  std::string suffix = path.extension().string();
  for (char& c : suffix) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return suffix;
}

// Leaves out hidden files: next to IMG_1.jpg macOS puts "._IMG_1.jpg", which is no picture.
bool IsPicture(const fs::directory_entry& entry) {
  return std::ranges::count(kSuffixes, Suffix(entry.path())) > 0 &&
         !entry.path().filename().string().starts_with('.');
}

std::vector<std::string> NamesInFolder(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (IsPicture(entry)) names.push_back(entry.path().filename().string());
  }
  std::ranges::sort(names);
  return names;
}

std::vector<std::string> NamesInList(const fs::path& list) {
  std::vector<std::string> names;
  VisitWordLines(list, [&](const std::vector<std::string_view>& words) {
    // The whole line, because a name may hold blanks.
    const std::string name(words.front().data(), words.back().data() + words.back().size());
    if (name.starts_with('/')) {
      throw DataError("'{}' must be relative to the list: give a relative path", name);
    }
    names.push_back(name);
  });
  return names;
}

}  // namespace

std::string PicturesFolder(const SequenceFolder& folder) {
  const fs::path pictures = folder.Relative(folder.config.pictures);
  std::error_code ignored;
  const bool is_folder = fs::is_directory(folder.data_root / pictures, ignored);
  return (is_folder ? pictures : pictures.parent_path()).generic_string();
}

RawSequence ReadPictures(const SequenceFolder& folder) {
  // Not normalized together with the data folder, because that may be a link, and `..` would then
  // lead out of its target.
  const fs::path pictures = folder.data_root / folder.Relative(folder.config.pictures);
  std::error_code ignored;
  std::vector<std::string> names = {pictures.filename().string()};
  if (fs::is_directory(pictures, ignored)) {
    names = NamesInFolder(pictures);
  } else if (!fs::is_regular_file(pictures, ignored)) {
    throw DataError("{}: no such folder, list or picture: correct `pictures` in {}",
                    pictures.string(),
                    folder.config.source);
  } else if (Suffix(pictures) == ".txt") {
    names = NamesInList(pictures);
  }
  if (names.empty()) {
    throw DataError("{}: no pictures: put some there, or correct `pictures` in {}",
                    pictures.string(),
                    folder.config.source);
  }
  const fs::path base = PicturesFolder(folder);
  RawSequence sequence;
  for (const std::string& name : names) {
    RawFrame frame;
    frame.time_ns = static_cast<std::int64_t>(sequence.frames.size()) * kPeriod_ns;
    frame.color.path = (base / name).lexically_normal().generic_string();
    sequence.frames.push_back(std::move(frame));
  }
  return sequence;
}

}  // namespace nightmap
