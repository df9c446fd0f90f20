// SPDX-License-Identifier: Apache-2.0
#include "pipeline/program/stage_log.h"

#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <memory>

#include "pipeline/base/plain_text.h"

namespace nightmap {
namespace {

// A flag of the log's pattern: the message with what a user's text could tell a terminal escaped.
class EscapedMessage : public spdlog::custom_flag_formatter {
 public:
  void format(const spdlog::details::log_msg& message,
              const std::tm& /*time*/,
              spdlog::memory_buf_t& line) override {
    const std::string text = AsLines({message.payload.data(), message.payload.size()});
    line.append(text.data(), text.data() + text.size());
  }
  std::unique_ptr<custom_flag_formatter> clone() const override {
    return std::make_unique<EscapedMessage>();
  }
};

}  // namespace

void SetUpLog(const std::string& stage, const std::string& level) {
  auto logger = std::make_shared<spdlog::logger>(
      stage, std::make_shared<spdlog::sinks::stderr_color_sink_mt>());
  auto pattern = std::make_unique<spdlog::pattern_formatter>();
  pattern->add_flag<EscapedMessage>('*').set_pattern("%T %^%l%$ %n: %*");
  logger->set_formatter(std::move(pattern));
  logger->set_level(spdlog::level::from_str(level));
  spdlog::set_default_logger(logger);
}

}  // namespace nightmap
