#include "app/replay/record_port.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tl/expected.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/line_use.h"
#include "app/cli/main_wait.h"
#include "app/journal/print_error.h"
#include "app/replay/capture_text.h"
#include "pipelines/realtime/capture_ring.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/can/can_link.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"

namespace tribus {
namespace {

constexpr std::size_t kPieces = 512;
/// Upper limit of reads in one round, so that signals are seen on a flooded port.
constexpr int kPortReadsAtOnce = 16;

tl::expected<UniqueFd, std::string> make_file(const PortRecording& recording) {
    const int exclusive = recording.force ? O_TRUNC : O_EXCL;
    UniqueFd file(::open(recording.file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC | exclusive, 0644));
    if (file.valid()) {
        return file;
    }
    const int error = errno;
    return tl::unexpected(error == EEXIST
                              ? fmt::format("{} exists; --force overwrites it", recording.file)
                              : fmt::format("{}: {}", recording.file, std::strerror(error)));
}

/// `use` is empty for a CAN interface.
tl::expected<std::unique_ptr<Link>, std::string> open_link(const std::string& port,
                                                           const std::optional<ProtocolUse>& use) {
    if (!use) {
        return kCanMedium.open(port, {.wanted = {{.id = 0, .mask = 0, .extended = false},
                                                 {.id = 0, .mask = 0, .extended = true}}});
    }
    return kSerialMedium.open(port, {.line = use->line});
}

/// Records one port into one file.
class Recorder {
  public:
    Recorder(std::unique_ptr<Link> link, UniqueFd file, CaptureFormat format)
        : link_(std::move(link)),
          file_(std::move(file)),
          memory_(1 + kPieces),
          ring_(CaptureRing::create(std::as_writable_bytes(std::span(memory_)))),
          text_(std::move(format)) {}

    int descriptor() const { return link_->descriptor(); }
    /// Reads what has arrived. Returns false if the device is gone.
    bool take() {
        ReadStatus status = ReadStatus::received;
        for (int i = 0; i < kPortReadsAtOnce && status == ReadStatus::received; ++i) {
            status = read(monotonic_now());
            pass_on();
        }
        return status != ReadStatus::lost;
    }
    /// Writes everything to the file; returns false if it cannot be written.
    bool flush() {
        text_.finish();
        std::string& text = text_.read();
        std::string_view left = text;
        while (!left.empty() && error_ == 0) {
            const ssize_t count = ::write(file_.get(), left.data(), left.size());
            error_ = count < 0 && errno != EINTR ? errno : 0;
            left.remove_prefix(count < 0 ? 0 : static_cast<std::size_t>(count));
        }
        bytes_ += text.size();
        text.clear();
        return error_ == 0;
    }
    std::uintmax_t bytes() const { return bytes_; }
    std::uint64_t count() const { return text_.read_count(); }
    int error() const { return error_; }

  private:
    struct alignas(64) Line {
        std::array<std::byte, sizeof(CapturePiece)> bytes{};
    };

    ReadStatus read(Instant now) {
        if (ByteLink* bytes = link_->as_bytes()) {
            const ReadStatus status = bytes->read(reception_);
            if (status == ReadStatus::received) {
                ring_.record(reception_, now);
            }
            return status;
        }
        const ReadStatus status = link_->as_can()->read(can_reception_, now, wall_time_now());
        if (status == ReadStatus::received) {
            for (const ReceivedCanFrame& received : can_reception_.view()) {
                ring_.record(Direction::read, received.frame, received.at);
            }
        }
        return status;
    }
    void pass_on() {
        std::array<CapturePiece, kPieces> pieces;
        const auto batch = ring_.read(next_, pieces);
        next_ = batch.first + batch.count;
        text_.take(std::span(pieces).first(batch.count));
    }

    std::unique_ptr<Link> link_;
    UniqueFd file_;
    std::vector<Line> memory_;
    CaptureRing ring_;
    std::uint64_t next_ = 0;
    CaptureText text_;
    Reception reception_;
    CanReception can_reception_;
    std::uintmax_t bytes_ = 0;
    int error_ = 0;
};

int record(Recorder& recorder, MainWait& wait, const PortRecording& recording, Instant start) {
    const Instant end = recording.time ? later(start, *recording.time) : kNever;
    const std::array descriptors{recorder.descriptor()};
    bool there = true;
    bool full = false;
    std::optional<int> signal;
    while (there && !full && !signal && monotonic_now() < end) {
        signal = wait.until(end, descriptors);
        there = recorder.take();
        if (!recorder.flush()) {
            return complain(fmt::format("{}: {}; the recording ends here", recording.file,
                                        std::strerror(recorder.error())),
                            kExitFailed);
        }
        full = recorder.bytes() >= recording.most_bytes;
    }
    const double seconds = std::chrono::duration<double>(monotonic_now() - start).count();
    print_error("{}: {} {} in {:.1f} s{}\n", recording.file, recorder.count(),
                is_device_path(recording.port) ? "bursts" : "frames", seconds,
                full ? "; --limit is reached" : "");
    if (!there) {
        return complain(recording.port + " is gone", kExitFailed);
    }
    return kExitFine;
}

}  // namespace

int record_port(const PortRecording& recording) {
    std::optional<ProtocolUse> use;
    if (is_device_path(recording.port)) {
        const auto found = serial_use(recording.protocol, recording.baud);
        if (!found) {
            return complain(found.error(), kExitWrongUse);
        }
        use = *found;
    }
    auto wait = MainWait::for_signals({SIGTERM, SIGINT, SIGHUP});
    if (!wait) {
        return complain(wait.error(), kExitFailed);
    }
    auto link = open_link(recording.port, use);
    if (!link) {
        return complain(link.error(), kExitFailed);
    }
    auto file = make_file(recording);
    if (!file) {
        return complain(file.error(), kExitFailed);
    }
    const Instant start = monotonic_now();
    Recorder recorder(std::move(*link), std::move(*file),
                      {.can = !use,
                       .interface = recording.port,
                       .byte_time = use ? use->line.bytes_time(1) : Duration::zero(),
                       .zero = start,
                       .zero_wall = wall_time_now()});
    print_error("recording {} into {}; Ctrl-C ends it\n", recording.port, recording.file);
    return record(recorder, *wait, recording, start);
}

}  // namespace tribus
