// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/written_inputs.h"

#include <nlohmann/json.hpp>
#include <vector>

#include "pipeline/base/error.h"
#include "pipeline/base/files.h"

namespace nightmap {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

fs::path FolderOfFile(const fs::path& path) {
  return fs::absolute(path).lexically_normal().parent_path();
}

// Where the receipt of the job that wrote a file may be. The name of a unit may have underscores.
std::vector<fs::path> ReceiptsBeside(const fs::path& path) {
  const std::string stem = path.stem();
  std::vector<fs::path> receipts = {path.parent_path() / "receipt.json"};
  for (std::size_t at = stem.find('_'); at != std::string::npos; at = stem.find('_', at + 1)) {
    receipts.push_back(path.parent_path() / ("receipt" + stem.substr(at) + ".json"));
  }
  return receipts;
}

// The hashes of the outputs in the receipt's folder, which may have been moved since, by name. A
// file that is no receipt lists none.
std::map<std::string, std::string> ReadOutputs(const fs::path& receipt) {
  std::map<std::string, std::string> outputs;
  if (!fs::is_regular_file(receipt)) return outputs;
  const std::string folder = FolderOfFile(receipt).filename();
  try {
    const json content = json::parse(ReadFile(receipt));
    if (content.at("format") != "nightmap receipt") return outputs;
    for (const json& entry : content.at("outputs")) {
      const fs::path path = entry.at("path").get<std::string>();
      if (FolderOfFile(path).filename() != folder || !entry.contains("xxh3")) continue;
      outputs[path.filename()] = entry.at("xxh3").get<std::string>();
    }
  } catch (const json::exception&) {
    outputs.clear();
  }
  return outputs;
}

}  // namespace

WrittenInputs::WrittenInputs(const fs::path& receipt) {
  if (!receipt.empty()) site_ = FolderOfFile(receipt).parent_path();
}

const WrittenInputs::Listed& WrittenInputs::OutputsOf(const fs::path& receipt) {
  const auto [found, is_new] = receipts_.try_emplace(receipt);
  if (is_new) found->second = ReadOutputs(receipt);
  return found->second;
}

const std::string& WrittenInputs::Hash(const fs::path& input) {
  const auto [found, is_new] = hashes_.try_emplace(input);
  std::string& hash = found->second;
  if (!is_new) return hash;
  hash = HashFile(input);
  if (FolderOfFile(input).parent_path() != site_) return hash;
  bool is_listed = false;
  for (const fs::path& receipt : ReceiptsBeside(input)) {
    const Listed& outputs = OutputsOf(receipt);
    const auto listed = outputs.find(input.filename());
    if (listed == outputs.end()) continue;
    if (listed->second == hash) return hash;
    is_listed = true;
  }
  if (is_listed) {
    throw DataError(
        "{}: is not the file that the job wrote (its receipt names other bytes): damaged, "
        "edited or of another site; delete it and run make again ([import] takes an edited copy)",
        input.string());
  }
  return hash;
}

}  // namespace nightmap
