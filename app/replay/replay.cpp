#include "app/replay/replay.h"

#include <algorithm>
#include <csignal>
#include <cstdint>
#include <ctime>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tl/expected.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/line_use.h"
#include "app/cli/main_wait.h"
#include "app/cli/protocol_use.h"
#include "app/cli/streams.h"
#include "app/journal/print_error.h"
#include "app/replay/replay_target.h"
#include "core/quantity.h"
#include "pipelines/realtime/clock.h"
#include "transports/recordings/pieces.h"
#include "transports/recordings/recording.h"
#include "transports/recordings/recording_source.h"
#include "transports/recordings/time_steps.h"

namespace tribus {
namespace {

/// Later items are not sent: they would mix with those that follow.
constexpr Duration kMostLateness = std::chrono::milliseconds(50);
/// For the last part before a deadline: `MainWait` knows only milliseconds.
constexpr Duration kExactWait = std::chrono::milliseconds(3);
constexpr Duration kLinger = std::chrono::milliseconds(100);
/// Time from opening the port to the first burst.
constexpr Duration kLead = std::chrono::milliseconds(20);

struct ReplayOptions {
    std::string file;
    ReplayPlace place;
    double speed = 1;
    bool loop = false;
    std::string period;
};

struct Figures {
    std::uint64_t refused = 0;
    std::uint64_t skipped = 0;
    std::vector<Duration> lateness;
};

/// Time from one burst to the next in a recording without times.
tl::expected<Duration, std::string> untimed_period(const ReplayOptions& options,
                                                   const Recording& recording) {
    if (recording.timed) {
        return Duration::zero();
    }
    if (recording.kind == RecordingKind::raw) {
        return tl::unexpected(
            std::string("raw bytes have neither times nor frame limits; `tribus decode` and "
                        "`tribus encode --format timed` make a recording with times from them"));
    }
    if (!options.period.empty()) {
        const auto period = parse_duration(options.period);
        return period && *period > Duration::zero()
                   ? tl::expected<Duration, std::string>(*period)
                   : tl::unexpected(std::string("--period must be a duration such as \"7ms\""));
    }
    if (options.place.protocol.empty()) {
        return tl::unexpected(
            std::string("this recording has no times; set the time from line to line with --period "
                        "7ms, or use a protocol's period with --protocol"));
    }
    const auto use = serial_use(options.place.protocol, options.place.baud);
    return use ? tl::expected<Duration, std::string>(usual_period(*use))
               : tl::unexpected(use.error());
}

std::vector<ReplayItem> items_of(const Recording& recording, Duration period, double speed) {
    const auto scaled = [speed](Duration time) {
        return Duration(static_cast<Duration::rep>(static_cast<double>(time.count()) / speed));
    };
    std::vector<ReplayItem> items;
    Duration untimed{};
    for (const Burst& burst : recording.bursts) {
        items.push_back({scaled(burst.start.value_or(untimed)), &burst, nullptr});
        untimed += period;
    }
    for (const RecordedCanFrame& recorded : recording.can_frames) {
        items.push_back({scaled(recorded.at), nullptr, &recorded.frame});
    }
    return items;
}

/// Time from the last item of a round to the first of the next: the median gap.
Duration usual_gap(const std::vector<ReplayItem>& items) {
    std::vector<Duration> gaps{std::chrono::milliseconds(1)};
    for (std::size_t i = 1; i < items.size(); ++i) {
        gaps.push_back(items[i].at - items[i - 1].at);
    }
    std::ranges::nth_element(gaps, gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2));
    return std::max<Duration>(gaps[gaps.size() / 2], std::chrono::microseconds(100));
}

/// Sends each item at its instant, counted from the start, so that it never drifts.
class Player {
  public:
    Player(ReplayTarget& target, MainWait& wait) : target_(target), wait_(wait) {}

    /// Returns false if a signal ended it or the target is gone.
    bool play(const std::vector<ReplayItem>& items, Instant start) {
        for (const ReplayItem& item : items) {
            const Instant due = start + item.at;
            if (!wait_until(due)) {
                return false;
            }
            const Duration late = monotonic_now() - due;
            if (late > kMostLateness) {
                ++figures_.skipped;
                continue;
            }
            const ReplayOutcome outcome = target_.send(item);
            gone_ = outcome == ReplayOutcome::gone;
            if (gone_) {
                return false;
            }
            if (outcome == ReplayOutcome::refused) {
                ++figures_.refused;
            } else {
                figures_.lateness.push_back(late);
            }
        }
        return true;
    }
    bool gone() const { return gone_; }
    Figures& figures() { return figures_; }

  private:
    bool wait_until(Instant due) {
        for (Instant now = monotonic_now(); now < due; now = monotonic_now()) {
            const Instant next = std::min(target_.idle(now), due);
            if (due - now > kExactWait) {
                if (wait_.until(std::max(std::min(next, due - kExactWait),
                                         later(now, std::chrono::milliseconds(1))))) {
                    return false;
                }
                continue;
            }
            const timespec rest{.tv_sec = 0, .tv_nsec = static_cast<long>((due - now).count())};
            ::nanosleep(&rest, nullptr);
        }
        return !wait_.until(Instant{});
    }

    ReplayTarget& target_;
    MainWait& wait_;
    Figures figures_;
    bool gone_ = false;
};

double milliseconds(Duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

void report(Figures& figures, bool can, Duration took) {
    auto& late = figures.lateness;
    std::ranges::sort(late);
    print_error("sent {} {} in {:.1f} s", late.size(), can ? "frames" : "bursts",
                milliseconds(took) / 1000);
    if (!late.empty()) {
        print_error("; late by {:.3f} ms (median), {:.3f} ms (worst)",
                    milliseconds(late[late.size() / 2]), milliseconds(late.back()));
    }
    if (figures.skipped > 0) {
        print_error("; {} left out, more than 50 ms late", figures.skipped);
    }
    if (figures.refused > 0) {
        print_error("; {} lost, no room or nobody reads", figures.refused);
    }
    print_error("\n");
}

tl::expected<Recording, std::string> load(const std::string& path) {
    auto file = InputFile::open_path(path);
    if (!file) {
        return tl::unexpected(std::move(file.error()));
    }
    const auto content = file->read_all();
    if (!content) {
        return tl::unexpected(content.error());
    }
    auto recording = parse_recording(*content, path);
    if (!recording) {
        return recording;
    }
    OnePiece piece(*content);
    RecordingInPieces whole(piece, path, recording->kind);
    if (whole.judge(); whole.gap()) {
        return tl::unexpected(gap_text(path, *whole.gap()));
    }
    if (recording->rest) {
        print_error("{}\n", *recording->rest);
    }
    return recording;
}

int replay(const ReplayOptions& options) {
    const auto recording = load(options.file);
    if (!recording) {
        return complain(recording.error(), kExitFailed);
    }
    const bool can = recording->kind == RecordingKind::candump;
    const auto period = untimed_period(options, *recording);
    if (!period) {
        return complain(options.file + ": " + period.error(), kExitWrongUse);
    }
    const auto items = items_of(*recording, *period, options.speed);
    if (items.empty()) {
        return complain(options.file + ": contains nothing to send", kExitFailed);
    }
    if (auto checked = check_replay_place(options.place, *recording); !checked) {
        return complain(options.file + ": " + checked.error(), kExitWrongUse);
    }
    auto wait = MainWait::for_signals({SIGTERM, SIGINT, SIGHUP});
    if (!wait) {
        return complain(wait.error(), kExitFailed);
    }
    const auto target = open_replay_target(options.place, *recording);
    if (!target) {
        return complain(target.error(), kExitFailed);
    }
    if (!(*target)->wait_for_reader(*wait)) {
        return kExitFine;
    }
    Player player(**target, *wait);
    // A recording may begin long before its first burst.
    const Duration first = items.front().at;
    const Instant begin = later(monotonic_now(), kLead);
    Instant start = begin - first;
    const Duration round = items.back().at - first + usual_gap(items);
    while (player.play(items, start) && options.loop) {
        start += round;
    }
    const Duration took = monotonic_now() - begin;
    // The reader may still have to read data before the port closes.
    wait->until(later(monotonic_now(), kLinger));
    report(player.figures(), can, took);
    return player.gone() ? complain(options.place.to + " is gone", kExitFailed) : kExitFine;
}

}  // namespace

Command replay_command() {
    auto options = std::make_shared<ReplayOptions>();
    return {
        .name = "replay",
        .help = "Send a recording with its timing to a pty, device or CAN interface",
        .notes =
            "It begins with the first burst or frame; with a pty, as soon as a program opens it. "
            "At the end it prints how late it was; anything more than 50 ms late is left out.",
        .options = {{.name = "FILE",
                     .value = &options->file,
                     .help = "Recording, as decode and simulate read it",
                     .required = true},
                    {.name = "--to",
                     .value = &options->place.to,
                     .help = "pty: a new pseudo-terminal, whose name is printed; or a serial "
                             "device or CAN interface",
                     .required = true,
                     .value_name = "DEVICE",
                     .offers = [] { return std::vector<std::string>{"pty"}; }},
                    {.name = "--link",
                     .value = &options->place.link,
                     .help = "Symbolic link to the new pseudo-terminal",
                     .value_name = "FILE"},
                    {.name = "--speed",
                     .value = &options->speed,
                     .help = "2: twice as fast",
                     .shows_value = true,
                     .range = {{0.001, 1000}},
                     .value_name = "FACTOR"},
                    {.name = "--loop", .value = &options->loop, .help = "Repeat until Ctrl-C"},
                    line_protocol_option(options->place.protocol),
                    line_baud_option(options->place.baud),
                    {.name = "--period",
                     .value = &options->period,
                     .help = "Time from line to line of a recording without times; default: that "
                             "of the protocol",
                     .value_name = "DURATION"}},
        .examples = {{"tribus replay receiver.txt --to pty --link /tmp/receiver --loop",
                      "a receiver without hardware, for a configuration that names that device"},
                     {"tribus replay flight.sbus --to /dev/ttyUSB0 --protocol sbus", ""},
                     {"tribus replay drive.log --to can0 --speed 2", ""}},
        .run = [options] { return replay(*options); },
    };
}

}  // namespace tribus
