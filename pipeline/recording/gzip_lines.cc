// SPDX-License-Identifier: Apache-2.0
#include "pipeline/recording/gzip_lines.h"

#include <zlib.h>

#include <memory>
#include <string>

#include "pipeline/base/error.h"
#include "pipeline/base/plain_file.h"

namespace nightmap {
namespace {

constexpr std::size_t kMaxLine_bytes = 1 << 20;
constexpr unsigned kPiece_bytes = 1 << 16;

// zlib passes a file through that is not gzipped.
class LogReader {
 public:
  explicit LogReader(const std::filesystem::path& path) : path_(path) {
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored)) throw DataError("{}: no such file", path.string());
    if (const std::string why = WhyNotPlain(path); !why.empty()) {
      throw DataError("{}: {}, a file is needed", path.string(), why);
    }
    file_.reset(gzopen(path.c_str(), "rb"));
    if (!file_) throw DataError("{}: cannot be opened: correct its permissions", path.string());
  }

  // The next bytes; empty at the end.
  std::string_view Next() {
    const int count = gzread(file_.get(), piece_.data(), kPiece_bytes);
    int error = Z_OK;
    const char* reason = gzerror(file_.get(), &error);
    if (count < 0 || (error != Z_OK && error != Z_STREAM_END)) {
      throw DataError("{}: damaged or cut off ({}): copy it again", path_.string(), reason);
    }
    return {piece_.data(), static_cast<std::size_t>(count)};
  }

 private:
  struct Close {
    void operator()(gzFile file) const { gzclose(file); }
  };
  const std::filesystem::path& path_;
  std::unique_ptr<gzFile_s, Close> file_;
  std::string piece_ = std::string(kPiece_bytes, '\0');
};

}  // namespace

void VisitLogLines(const std::filesystem::path& path,
                   const std::function<void(int, std::string_view)>& visit) {
  LogReader reader(path);
  std::string rest;
  int line_number = 0;
  const auto visit_line = [&](std::string_view line) {
    if (line.ends_with('\r')) line.remove_suffix(1);
    visit(++line_number, line);
  };
  for (std::string_view piece = reader.Next(); !piece.empty(); piece = reader.Next()) {
    rest += piece;
    std::size_t begin = 0;
    for (std::size_t end = rest.find('\n'); end != std::string::npos;
         end = rest.find('\n', begin)) {
      visit_line(std::string_view(rest).substr(begin, end - begin));
      begin = end + 1;
    }
    rest.erase(0, begin);
    if (rest.size() > kMaxLine_bytes) {
      throw DataError("{}:{}: a line of more than {} bytes: this is no log",
                      path.string(),
                      line_number + 1,
                      kMaxLine_bytes);
    }
  }
  if (!rest.empty()) visit_line(rest);
}

}  // namespace nightmap
