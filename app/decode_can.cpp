#include "app/decode_can.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <ostream>
#include <utility>
#include <vector>

#include "app/can_frame_finder.h"
#include "app/exit_status.h"
#include "config/mistakes.h"
#include "core/quotes.h"
#include "transports/links/recording_candump.h"

namespace tribus {
namespace {

/// After so many lines that cannot be used the input is something else.
constexpr unsigned kMostMistakes = 20;
/// The longest line of a log, 64 bytes of FD, takes below 200 characters.
constexpr std::size_t kLongestLine = 4096;

std::string several_interfaces(std::string_view file_name, std::span<const std::string> names) {
    const std::vector<std::string_view> views(names.begin(), names.end());
    return fmt::format("{}: frames of several interfaces, {}; say which with --interface NAME",
                       file_name, in_quotes_all(views));
}

std::string no_such_interface(std::string_view file_name, std::string_view asked,
                              std::span<const std::string> names) {
    const std::vector<std::string_view> views(names.begin(), names.end());
    return fmt::format("{}: no frame of the interface {}; {}", file_name, in_quotes(asked),
                       suggestion(asked, views));
}

void feed_all(CanFrameFinder& finder, const Recording& recording) {
    for (const RecordedCanFrame& frame : recording.can_frames) {
        finder.feed(frame);
    }
}

std::size_t best_of(std::span<const ProtocolUse> uses, const Recording& recording,
                    std::uint64_t& frames_of_best) {
    std::size_t best = 0;
    for (std::size_t index = 0; index < uses.size(); ++index) {
        CanFrameFinder finder(uses[index], [](const FoundFrame&) {});
        feed_all(finder, recording);
        const std::uint64_t frames = finder.tally().frames;
        if (frames > frames_of_best) {
            best = index;
            frames_of_best = frames;
        }
    }
    return best;
}

/// Cuts text that comes in pieces into lines.
class LineCutter {
  public:
    void add(std::string_view text) {
        text_.erase(0, std::exchange(at_, 0));
        text_ += text;
    }
    /// Nothing where the next line has not come to its end.
    std::optional<std::string_view> next() {
        const std::size_t end = text_.find('\n', at_);
        if (end == std::string::npos) {
            return std::nullopt;
        }
        return std::string_view(text_).substr(std::exchange(at_, end + 1), end - at_);
    }
    /// What stands behind the last end of a line.
    std::string_view rest() const { return std::string_view(text_).substr(at_); }

  private:
    std::string text_;
    std::size_t at_ = 0;
};

/// Decodes line by line.
class LogDecoder {
  public:
    LogDecoder(const CanLogSource& source, const ProtocolUse& use, FramePrinter& printer,
               std::ostream& talk)
        : source_(source),
          reader_(source.name),
          finder_(use, [&printer](const FoundFrame& found) { printer.frame(found); }),
          talk_(talk) {}

    /// Returns whether to go on.
    bool take(std::string_view line) {
        const auto read = reader_.next(line);
        if (!read) {
            talk_ << read.error() << '\n';
            return ++mistakes_ < kMostMistakes || stop("too much of the input cannot be used");
        }
        if (!*read) {
            return true;
        }
        const RecordedCanFrame& frame = **read;
        if (std::find(interfaces_.begin(), interfaces_.end(), frame.interface) ==
            interfaces_.end()) {
            interfaces_.push_back(frame.interface);
        }
        if (source_.interface.empty() && interfaces_.size() > 1) {
            return stop(several_interfaces(source_.name, interfaces_));
        }
        if (source_.interface.empty() || source_.interface == frame.interface) {
            finder_.feed(frame);
        }
        return true;
    }
    bool stop(std::string_view reason) {
        talk_ << "tribus: stopped, " << reason << '\n';
        failed_ = true;
        return false;
    }
    int finish(FramePrinter& printer) {
        const bool missing = !interfaces_.empty() && !source_.interface.empty() &&
                             std::find(interfaces_.begin(), interfaces_.end(), source_.interface) ==
                                 interfaces_.end();
        if (missing) {
            talk_ << "tribus: " << no_such_interface(source_.name, source_.interface, interfaces_)
                  << '\n';
        }
        CanTally tally = finder_.tally();
        tally.error_frames = reader_.error_frames();
        tally.log_start = reader_.log_start();
        printer.can_summary(tally);
        return missing || failed_ || mistakes_ > 0 ? kExitFailed : kExitFine;
    }

  private:
    const CanLogSource& source_;
    CandumpReader reader_;
    CanFrameFinder finder_;
    std::ostream& talk_;
    std::vector<std::string> interfaces_;
    unsigned mistakes_ = 0;
    bool failed_ = false;
};

}  // namespace

tl::expected<Recording, std::string> take_interface(Recording recording, std::string_view file_name,
                                                    std::string_view interface) {
    const std::vector<std::string> names = interfaces_in(recording);
    if (interface.empty() && names.size() > 1) {
        return tl::unexpected(several_interfaces(file_name, names));
    }
    if (interface.empty() || names.empty()) {
        return recording;
    }
    if (std::find(names.begin(), names.end(), interface) == names.end()) {
        return tl::unexpected(no_such_interface(file_name, interface, names));
    }
    std::erase_if(recording.can_frames,
                  [&](const RecordedCanFrame& frame) { return frame.interface != interface; });
    return recording;
}

int decode_can_recording(const Recording& recording, std::span<const ProtocolUse> uses,
                         FramePrinter& printer, std::ostream& talk) {
    std::uint64_t frames_of_best = 0;
    const std::size_t best = uses.size() == 1 ? 0 : best_of(uses, recording, frames_of_best);
    printer.heading();
    CanFrameFinder finder(uses[best], [&](const FoundFrame& found) { printer.frame(found); });
    feed_all(finder, recording);
    CanTally tally = finder.tally();
    tally.error_frames = recording.error_frames;
    tally.log_start = recording.log_start;
    const bool unknown = uses.size() > 1 && frames_of_best == 0 && tally.can_frames > 0;
    if (!unknown) {
        printer.can_summary(tally);
        return kExitFine;
    }
    // What one of them would have rejected says nothing.
    tally.rejected.clear();
    tally.other_can_frames = tally.can_frames;
    printer.can_summary(tally);
    std::vector<std::string_view> names;
    for (const ProtocolUse& use : uses) {
        names.push_back(use.protocol->name);
    }
    talk << fmt::format("tribus: no snapshot of {} in {} CAN frames\n", fmt::join(names, " or "),
                        tally.can_frames);
    return kExitFailed;
}

int decode_can_stream(const CanLogSource& source, const ProtocolUse& use, FramePrinter& printer,
                      std::ostream& results, std::ostream& talk) {
    printer.heading();
    results.flush();
    LogDecoder decoder(source, use, printer, talk);
    LineCutter cutter;
    bool going = true;
    while (going && results.good()) {
        const std::string text = source.read();
        if (text.empty()) {
            break;
        }
        cutter.add(text);
        while (const auto line = cutter.next()) {
            if (going = decoder.take(*line); !going) {
                break;
            }
        }
        results.flush();
        if (going && cutter.rest().size() > kLongestLine) {
            going =
                decoder.stop(fmt::format("a line of more than {} characters is no line of "
                                         "candump -L",
                                         kLongestLine));
        }
    }
    if (going && !cutter.rest().empty()) {
        decoder.take(cutter.rest());
    }
    return decoder.finish(printer);
}

}  // namespace tribus
