#include "app/wire/frames/can_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <optional>
#include <ostream>
#include <span>
#include <utility>
#include <vector>

#include "config/language/mistakes.h"
#include "core/quotes.h"
#include "transports/recordings/candump.h"
#include "transports/recordings/text.h"

namespace tribus {
namespace {

/// With so many unusable lines, the input is something else.
constexpr unsigned kMostMistakes = 20;
/// The longest line of a log, 64 bytes of CAN FD, takes less than 200 characters.
constexpr std::size_t kLongestLine = 4096;

std::string several_interfaces(std::string_view file_name, std::span<const std::string> names) {
    const std::vector<std::string_view> views(names.begin(), names.end());
    return fmt::format("{}: frames of several interfaces, {}; select one with --interface NAME",
                       file_name, in_quotes_all(views));
}

std::string no_such_interface(std::string_view file_name, std::string_view asked,
                              std::span<const std::string> names) {
    const std::vector<std::string_view> views(names.begin(), names.end());
    return fmt::format("{}: no frame of the interface {}; {}", file_name, in_quotes(asked),
                       suggestion(asked, views));
}

/// Splits text that arrives in pieces into lines.
class LineCutter {
  public:
    void add(std::string_view text) {
        text_.erase(0, std::exchange(at_, 0));
        text_ += text;
    }
    /// Nothing if the next line is not complete yet.
    std::optional<std::string_view> next() {
        const std::size_t end = text_.find('\n', at_);
        if (end == std::string::npos) {
            return std::nullopt;
        }
        const std::size_t begin = std::exchange(at_, end + 1);
        return std::string_view(text_).substr(begin, end - begin);
    }
    /// The text after the last line end.
    std::string_view rest() const { return std::string_view(text_).substr(at_); }

  private:
    std::string text_;
    std::size_t at_ = 0;
};

/// Parses a log line by line.
class LogReader {
  public:
    LogReader(const CanLogSource& source, const std::function<void(const RecordedCanFrame&)>& take,
              std::ostream& messages)
        : source_(source),
          reader_(source.name, LogTimes::optional),
          take_(take),
          messages_(messages) {}

    /// Returns false when reading must stop.
    bool take(std::string_view line) {
        ++lines_;
        const auto read = reader_.next(line);
        if (!read) {
            messages_ << read.error() << '\n';
            return ++mistakes_ < kMostMistakes || stop("too many lines cannot be used");
        }
        if (!*read) {
            return true;
        }
        return take_frame(**read);
    }
    bool take_frame(const RecordedCanFrame& frame) {
        if (std::find(interfaces_.begin(), interfaces_.end(), frame.interface) ==
            interfaces_.end()) {
            interfaces_.push_back(frame.interface);
        }
        if (source_.interface.empty() && interfaces_.size() > 1) {
            return stop(several_interfaces(source_.name, interfaces_));
        }
        if (source_.interface.empty() || source_.interface == frame.interface) {
            take_(frame);
        }
        return true;
    }
    /// The text behind the last line end, at the end of the input.
    void take_last(std::string_view line) {
        if (lines_ == 0) {
            take(line);
        } else if (auto read = reader_.next(line); !read) {
            messages_ << recording_text::cut_line_text(read.error()) << '\n';
        } else if (*read) {
            take_frame(**read);
        }
    }
    /// A loss of power while the file is written leaves NUL bytes.
    void end_at_nul() {
        messages_ << recording_text::nul_text(source_.name, lines_ + 1, 1) << '\n';
    }
    bool stop(std::string_view reason) {
        messages_ << "tribus: stopped, " << reason << '\n';
        failed_ = true;
        return false;
    }
    CanLogEnd finish() {
        const bool missing = !interfaces_.empty() && !source_.interface.empty() &&
                             std::find(interfaces_.begin(), interfaces_.end(), source_.interface) ==
                                 interfaces_.end();
        if (missing) {
            messages_ << "tribus: "
                      << no_such_interface(source_.name, source_.interface, interfaces_) << '\n';
        }
        if (const auto sound = reader_.finish(); !sound && !failed_ && mistakes_ == 0) {
            messages_ << sound.error() << '\n';
            failed_ = true;
        }
        return {.log = reader_.facts(), .failed = missing || failed_ || mistakes_ > 0};
    }

  private:
    const CanLogSource& source_;
    CandumpReader reader_;
    const std::function<void(const RecordedCanFrame&)>& take_;
    std::ostream& messages_;
    std::vector<std::string> interfaces_;
    unsigned lines_ = 0;
    unsigned mistakes_ = 0;
    bool failed_ = false;
};

}  // namespace

tl::expected<void, std::string> check_interface(std::span<const std::string> names,
                                                std::string_view file_name,
                                                std::string_view interface) {
    if (interface.empty() && names.size() > 1) {
        return tl::unexpected(several_interfaces(file_name, names));
    }
    if (!interface.empty() && !names.empty() &&
        std::ranges::find(names, interface) == names.end()) {
        return tl::unexpected(no_such_interface(file_name, interface, names));
    }
    return {};
}

CanLogEnd read_can_log(const CanLogSource& source,
                       const std::function<void(const RecordedCanFrame&)>& take,
                       std::ostream& results, std::ostream& messages) {
    LogReader reader(source, take, messages);
    LineCutter cutter;
    bool going = true;
    while (going && results.good()) {
        std::string text = source.read();
        if (text.empty()) {
            break;
        }
        const std::size_t size = text.size();
        text.resize(std::min(text.find('\0'), text.size()));
        const bool nul = text.size() < size;
        cutter.add(text);
        while (const auto line = cutter.next()) {
            if (going = reader.take(*line); !going) {
                break;
            }
        }
        results.flush();
        if (going && nul) {
            reader.end_at_nul();
            return reader.finish();
        }
        if (going && cutter.rest().size() > kLongestLine) {
            going = reader.stop(fmt::format(
                "a line of more than {} characters is not a line of candump -L", kLongestLine));
        }
    }
    if (going && !cutter.rest().empty()) {
        reader.take_last(cutter.rest());
    }
    return reader.finish();
}

}  // namespace tribus
