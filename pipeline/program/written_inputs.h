// SPDX-License-Identifier: Apache-2.0
// Hashes the inputs of a run, and compares each with the receipt of the job that wrote it.
#pragma once

#include <filesystem>
#include <map>
#include <string>

namespace nightmap {

// The receipt of a job lies beside its outputs: receipt.json, or receipt_<unit>.json for
// `<kind>_<unit>.<extension>`. Only inputs of the site are compared, in whose folders the run
// writes its own receipt too: a file of another site is imported, and whoever imports it may edit
// it.
class WrittenInputs {
 public:
  // `receipt`: where the run writes its own; empty without, and then nothing is compared.
  explicit WrittenInputs(const std::filesystem::path& receipt);

  // XXH3 of a file, which is read once. Throws DataError naming the file and the remedy when
  // receipts list it, and none with these bytes.
  const std::string& Hash(const std::filesystem::path& input);

 private:
  using Listed = std::map<std::string, std::string>;  // hash by file name
  const Listed& OutputsOf(const std::filesystem::path& receipt);

  std::filesystem::path site_;
  std::map<std::filesystem::path, Listed> receipts_;
  std::map<std::filesystem::path, std::string> hashes_;
};

}  // namespace nightmap
