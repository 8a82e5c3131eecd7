#include "app/wire/decode_frames.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <utility>
#include <vector>

#include "app/cli/exit_status.h"
#include "app/wire/fitting_protocols.h"
#include "app/wire/frames/frame_json.h"
#include "app/wire/frames/frame_text.h"
#include "core/counted.h"

namespace tribus {
namespace {

void print_heading(const DecodeOutput& output) {
    output.heading(append_text_heading, append_csv_heading);
}

std::string line_of(const FoundFrame& found, DecodeFormat format) {
    return in_format(format, append_frame_text, append_frame_json, append_frame_csv, found);
}

void print_summary(const DecodeOutput& output, const Tally& tally) {
    output.summary(
        [&](std::string& text) { append_summary_text(text, tally); },
        [&](std::string& text) { append_summary_json(text, tally, output.input_name()); });
}

/// The frames that one protocol finds, and the bursts that they touch.
class Coverage {
  public:
    explicit Coverage(const ProtocolUse& use)
        : finder_(make_frame_finder(use, [this](const FoundFrame& found) { take(found); })) {}

    FrameFinder& finder() { return *finder_; }
    std::uint64_t frames() const { return frames_; }
    /// Whether a frame contains a byte of the burst.
    bool touches(std::size_t burst) const { return burst < touched_.size() && touched_[burst]; }

  private:
    void take(const FoundFrame& found) {
        ++frames_;
        touched_.resize(std::max(touched_.size(), found.last_burst + 1));
        for (std::size_t burst = found.place.burst; burst <= found.last_burst; ++burst) {
            touched_[burst] = true;
        }
    }

    std::unique_ptr<FrameFinder> finder_;
    std::uint64_t frames_ = 0;
    std::vector<bool> touched_;
};

/// The coverages of several protocols, found in one pass.
class Coverages {
  public:
    Coverages(RecordingSource& recording, std::span<const ProtocolUse> uses) {
        SeveralTakers finders;
        for (const ProtocolUse& use : uses) {
            finders.add(all_.emplace_back(std::make_unique<Coverage>(use))->finder());
        }
        recording.read(finders);
        for (const auto& one : all_) {
            one->finder().finish();
        }
    }
    /// The index of the first of those that find the most frames.
    std::size_t best() const {
        const auto found =
            std::ranges::max_element(all_, {}, [](const auto& one) { return one->frames(); });
        return static_cast<std::size_t>(found - all_.begin());
    }
    const Coverage& of_best() const { return *all_[best()]; }

  private:
    std::vector<std::unique_ptr<Coverage>> all_;
};

bool is_one_frame_of(const Burst& burst, const ProtocolUse& use) {
    bool whole = false;
    const auto finder = make_frame_finder(
        use, [&](const FoundFrame& found) { whole = found.frame.length == burst.bytes.size(); });
    finder->feed_burst(0, burst);
    finder->finish();
    return whole;
}

void add(Tally& total, const Tally& part) {
    total.bytes += part.bytes;
    total.frames += part.frames;
    total.skipped_bytes += part.skipped_bytes;
}

/// Prints the frames of the best protocol, and the bursts that none of them touches and that are
/// exactly one frame of another protocol.
class AllottedDecoding final : public RecordingTaker {
  public:
    AllottedDecoding(std::span<const ProtocolUse> uses, std::size_t best, const Coverage& coverage,
                     const DecodeOutput& output)
        : uses_(uses),
          coverage_(coverage),
          output_(output),
          best_(make_frame_finder(uses[best], collector())) {}

    void feed_burst(std::size_t index, const Burst& burst) override {
        const auto other = coverage_.touches(index)
                               ? uses_.end()
                               : std::ranges::find_if(uses_, [&](const ProtocolUse& use) {
                                     return is_one_frame_of(burst, use);
                                 });
        if (other == uses_.end()) {
            best_->feed_burst(index, burst);
        } else {
            decode_alone(*other, index, burst);
        }
        print_before(best_->waits_since());
    }
    /// Returns the counters of all.
    Tally finish() {
        best_->finish();
        print_before(std::nullopt);
        Tally tally = best_->tally();
        add(tally, others_);
        return tally;
    }

  private:
    struct Line {
        FramePlace place;
        std::string text;
    };
    FrameHandler collector() {
        return [this](const FoundFrame& found) {
            lines_.push_back({found.place, line_of(found, output_.format)});
        };
    }
    void decode_alone(const ProtocolUse& use, std::size_t index, const Burst& burst) {
        const auto finder = make_frame_finder(use, collector());
        finder->feed_burst(index, burst);
        finder->finish();
        add(others_, finder->tally());
    }
    /// Prints the lines of frames before `place`, or all, in the order of the recording.
    void print_before(std::optional<FramePlace> place) {
        std::ranges::stable_sort(lines_, {}, &Line::place);
        const auto end =
            place ? std::ranges::lower_bound(lines_, *place, {}, &Line::place) : lines_.end();
        std::for_each(lines_.begin(), end,
                      [this](const Line& line) { output_.results << line.text; });
        lines_.erase(lines_.begin(), end);
    }

    std::span<const ProtocolUse> uses_;
    const Coverage& coverage_;
    const DecodeOutput& output_;
    std::unique_ptr<FrameFinder> best_;
    std::vector<Line> lines_;
    Tally others_;
};

/// The counters of one protocol's rejected frames would mean nothing here.
int decode_unknown(RecordingSource& recording, std::span<const ProtocolUse> uses,
                   const DecodeOutput& output) {
    Tally tally = find_frames(uses.front(), recording, [](const FoundFrame&) {});
    tally.rejected.clear();
    tally.skipped_bytes = tally.bytes;
    if (tally.can) {
        tally.can->others = tally.can->frames;
    }
    print_heading(output);
    print_summary(output, tally);
    if (amount_of(tally).given == 0) {
        return kExitFine;
    }
    std::vector<std::string_view> names;
    for (const ProtocolUse& use : uses) {
        names.push_back(use.protocol->name);
    }
    output.messages << unread_frames_text(recording);
    output.messages << fmt::format(
        "tribus: no {} of {} in {}\n", tally.can ? "snapshot" : "frame", fmt::join(names, " or "),
        tally.can ? counted(tally.can->frames, "CAN frame") : counted(tally.bytes, "byte"));
    return kExitFailed;
}

}  // namespace

FrameDecoding::FrameDecoding(const ProtocolUse& use, const DecodeOutput& output)
    : protocol_(use.protocol->name),
      output_(output),
      finder_(make_frame_finder(use, [this](const FoundFrame& found) {
          output_.results << line_of(found, output_.format);
      })) {}

void FrameDecoding::heading() {
    print_heading(output_);
}

void FrameDecoding::finish(const LogFacts& log) {
    finder_->finish();
    Tally tally = finder_->tally();
    if (tally.can) {
        tally.can->log = log;
    }
    print_summary(output_, tally);
    if (!tally.first_fault.empty()) {
        output_.messages << fmt::format("tribus: the first frame that {} cannot use: {}\n",
                                        protocol_, tally.first_fault);
    }
}

DecodedAmount FrameDecoding::amount() const {
    return amount_of(finder_->tally());
}

std::uint64_t most_frames(std::span<const ProtocolUse> uses, RecordingSource& recording) {
    return uses.empty() ? 0 : Coverages(recording, uses).of_best().frames();
}

int decode_frames(RecordingSource& recording, std::span<const ProtocolUse> uses,
                  const DecodeOutput& output) {
    if (uses.size() == 1) {
        FrameDecoding decoding(uses.front(), output);
        return decode_recording(recording, decoding, output.messages);
    }
    const Coverages coverages(recording, uses);
    if (coverages.of_best().frames() == 0) {
        return decode_unknown(recording, uses, output);
    }
    if (recording.kind() == RecordingKind::candump) {
        FrameDecoding decoding(uses[coverages.best()], output);
        return decode_recording(recording, decoding, output.messages);
    }
    AllottedDecoding decoding(uses, coverages.best(), coverages.of_best(), output);
    print_heading(output);
    recording.read(decoding);
    print_summary(output, decoding.finish());
    return kExitFine;
}

}  // namespace tribus
