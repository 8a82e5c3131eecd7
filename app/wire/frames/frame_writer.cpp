#include "app/wire/frames/frame_writer.h"

#include <fmt/format.h>

#include <array>
#include <cstddef>
#include <optional>
#include <ostream>
#include <span>
#include <utility>

#include "app/wire/frames/waveform.h"
#include "core/can_frame.h"
#include "core/counted.h"
#include "transports/codecs/can_codec.h"
#include "transports/codecs/codec.h"
#include "transports/recordings/writer.h"

namespace tribus {
namespace {

/// Assigns each frame its start.
class StartTimes {
  public:
    explicit StartTimes(Duration period) : period_(period) {}

    tl::expected<Duration, std::string> next(const WrittenFrame& written) {
        const Duration start =
            written.start.value_or(latest_ ? *latest_ + period_ : Duration::zero());
        if (latest_ && start < *latest_) {
            return tl::unexpected(fmt::format(
                "t_us is {}, less than the {} of the frame before; times must not go back",
                whole_microseconds(start), whole_microseconds(*latest_)));
        }
        latest_ = start;
        return start;
    }

  private:
    Duration period_;
    std::optional<Duration> latest_;
};

class SerialWriter final : public FrameWriter {
  public:
    SerialWriter(const ProtocolUse& use, EncodeFormat format, std::ostream& results)
        : encoder_(use.protocol->make_encoder(use.settings)),
          format_(format),
          results_(results),
          waveform_(use.line),
          times_(usual_period(use)) {}

    tl::expected<void, std::string> write(const WrittenFrame& written) override {
        const auto start = times_.next(written);
        if (!start) {
            return tl::unexpected(start.error());
        }
        std::string text;
        heading(text, *start);
        append(text, *start, encoder_.encode(written.channels, Instant(*start)).bytes());
        results_ << text;
        return {};
    }

    void finish(std::ostream& messages) override {
        std::string text;
        heading(text, Duration::zero());
        if (format_ == EncodeFormat::vcd) {
            waveform_.end(text);
        }
        results_ << text;
        if (waveform_.delayed() > 0) {
            messages << fmt::format(
                "tribus: {} delayed, because the frame before was still on the wire\n",
                counted(waveform_.delayed(), "frame"));
        }
    }

    bool marks_frame_lost() const override { return encoder_.encoder().marks_frame_lost(); }

  private:
    void heading(std::string& text, Duration first_start) {
        if (std::exchange(heading_written_, true)) {
            return;
        }
        if (format_ == EncodeFormat::timed) {
            text += kTimedHeading;
        } else if (format_ == EncodeFormat::vcd) {
            waveform_.begin(text, first_start);
        }
    }
    void append(std::string& text, Duration start, std::span<const std::uint8_t> frame) {
        switch (format_) {
            case EncodeFormat::binary:
                text.append(frame.begin(), frame.end());
                break;
            case EncodeFormat::hex:
                append_hex_line(text, frame);
                break;
            case EncodeFormat::timed:
                append_timed_line(text, start, frame);
                break;
            case EncodeFormat::vcd:
                waveform_.frame(text, start, frame);
                break;
            case EncodeFormat::candump:
                break;
        }
    }

    FrameEncoder encoder_;
    EncodeFormat format_;
    std::ostream& results_;
    Waveform waveform_;
    StartTimes times_;
    bool heading_written_ = false;
};

/// All CAN frames of a snapshot get the same time; a bus would carry them one after the other.
class CanLogWriter final : public FrameWriter {
  public:
    CanLogWriter(const ProtocolUse& use, std::string_view interface, std::ostream& results)
        : encoder_(use.protocol->make_encoder(use.settings)),
          interface_(interface),
          results_(results),
          times_(usual_period(use)) {}

    tl::expected<void, std::string> write(const WrittenFrame& written) override {
        if (written.start.value_or(Duration::zero()) < Duration::zero()) {
            return tl::unexpected(fmt::format("t_us is {}; a candump log has no times before 0",
                                              whole_microseconds(*written.start)));
        }
        const auto start = times_.next(written);
        if (!start) {
            return tl::unexpected(start.error());
        }
        const Instant now(*start);
        ChannelFrame snapshot = written.channels;
        snapshot.received = now;
        std::string text;
        const auto frames = encoder_.encode(snapshot, now).can_frames();
        for (const CanFrame& frame : frames) {
            append_candump_line(text, *start, interface_, frame);
        }
        results_ << text;
        return {};
    }

    void finish(std::ostream& /*messages*/) override {}
    bool marks_frame_lost() const override { return encoder_.encoder().marks_frame_lost(); }

  private:
    FrameEncoder encoder_;
    std::string interface_;
    std::ostream& results_;
    StartTimes times_;
};

}  // namespace

std::unique_ptr<FrameWriter> make_frame_writer(const ProtocolUse& use, EncodeFormat format,
                                               std::string_view interface, std::ostream& results) {
    if (use.protocol->shape == WireShape::can_frames) {
        return std::make_unique<CanLogWriter>(use, interface, results);
    }
    return std::make_unique<SerialWriter>(use, format, results);
}

}  // namespace tribus
