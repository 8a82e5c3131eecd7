#pragma once

#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>

#include <spdlog/sinks/ostream_sink.h>
#include <spdlog/spdlog.h>

namespace tribus::test {

/// Keeps what the process logs while this exists. One thread logs.
class LogInMemory {
  public:
    /// `pattern`: of spdlog.
    explicit LogInMemory(const std::string& pattern) : before_(spdlog::default_logger()) {
        auto sink = std::make_shared<spdlog::sinks::ostream_sink_mt>(text_);
        sink->set_pattern(pattern);
        spdlog::set_default_logger(std::make_shared<spdlog::logger>("test", sink));
    }
    LogInMemory(const LogInMemory&) = delete;
    LogInMemory& operator=(const LogInMemory&) = delete;
    ~LogInMemory() { spdlog::set_default_logger(before_); }

    std::string text() const { return text_.str(); }
    /// Returns the lines since the last call that `is_wanted` accepts, and forgets all.
    template <class IsWanted>
    std::string take_lines(IsWanted is_wanted) {
        std::istringstream all(std::move(text_).str());
        text_.str("");
        std::string lines;
        for (std::string line; std::getline(all, line);) {
            lines += is_wanted(line) ? line + "\n" : "";
        }
        return lines;
    }
    /// The same of those that begin with `of`.
    std::string take_lines_of(std::string_view of) {
        return take_lines([of](const std::string& line) { return line.starts_with(of); });
    }

  private:
    std::ostringstream text_;
    std::shared_ptr<spdlog::logger> before_;
};

}  // namespace tribus::test
