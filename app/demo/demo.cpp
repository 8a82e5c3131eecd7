#include "app/demo/demo.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <fstream>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/appliance/appliance.h"
#include "app/cli/exit_status.h"
#include "app/cli/pty.h"
#include "app/cli/streams.h"
#include "app/cli/terminal.h"
#include "app/demo/demo_peers.h"
#include "app/demo/demo_screen.h"
#include "app/journal/print_error.h"
#include "app/journal/terminal_stream.h"
#include "core/distribution.h"
#include "pipelines/realtime/clock.h"

namespace tribus {
namespace {

constexpr Duration kScreenPeriod = std::chrono::milliseconds(50);
constexpr Duration kLinePeriod = std::chrono::seconds(1);
constexpr Duration kRateWindow = std::chrono::seconds(1);
/// Longer than a frame takes from the receiver to the servos, even on a loaded machine.
constexpr Duration kSettle = std::chrono::milliseconds(200);

/// The configuration of the README, with the shortest period of the servos.
std::string demo_configuration(std::string_view receiver, std::string_view servos) {
    return fmt::format(R"([input.receiver]
protocol = "ibus"
device   = "{}"

[output.servos]
protocol = "sbus"
device   = "{}"
period   = "7ms"

[pipeline.main]
from = "receiver"
to   = "servos"
)",
                       receiver, servos);
}

/// Frames per second in the last window, from a counter that is read now and then.
class RateMeter {
  public:
    explicit RateMeter(Instant start) : window_start_(start) {}
    double rate(std::uint64_t count, Instant now) {
        if (now - window_start_ >= kRateWindow) {
            const double seconds = std::chrono::duration<double>(now - window_start_).count();
            rate_ = static_cast<double>(count - window_count_) / seconds;
            window_start_ = now;
            window_count_ = count;
        }
        return rate_;
    }

  private:
    Instant window_start_;
    std::uint64_t window_count_ = 0;
    double rate_ = 0;
};

std::string drop_sentence(const DropRecord& drop) {
    const auto after = [](const std::optional<Duration>& duration) {
        return duration ? "after " + short_duration(*duration) : std::string("...");
    };
    return fmt::format("link dropped: frame lost {}, failsafe {}; control back {}",
                       after(drop.frame_lost_after), after(drop.failsafe_after),
                       after(drop.control_after));
}

/// Frames that went into a pty but did not come out decoded. A frame that a newer one replaced is
/// not lost: RC data is a state, and the newest frame counts.
std::uint64_t lost_frames(const PeerReport& report, std::uint64_t decoded, std::uint64_t written) {
    // The servos' decoder may keep back its first frame until a second one confirms it.
    const auto missing = [](std::uint64_t sent, std::uint64_t got) {
        return sent > got ? sent - got : 0;
    };
    return missing(report.frames_sent, decoded) + missing(written, report.frames_received);
}

struct Bench {
    std::unique_ptr<Appliance> appliance;
    std::unique_ptr<DemoPeers> peers;
    std::string input_device;
    std::string output_device;
};

tl::expected<Bench, std::string> set_up() {
    auto receiver = Pty::open();
    auto servos = Pty::open();
    if (!receiver || !servos) {
        return tl::unexpected(receiver ? servos.error() : receiver.error());
    }
    auto appliance =
        Appliance::start_text(demo_configuration(receiver->path, servos->path), "demo");
    if (!appliance) {
        return tl::unexpected(appliance.error());
    }
    Bench bench{std::move(*appliance), nullptr, receiver->path, servos->path};
    bench.peers =
        std::make_unique<DemoPeers>(std::move(receiver->master), std::move(servos->master));
    return bench;
}

class Demo {
  public:
    Demo(Bench bench, std::optional<Duration> length)
        : bench_(std::move(bench)),
          start_(monotonic_now()),
          length_(length),
          in_rate_(start_),
          out_rate_(start_) {}

    int run(const sigset_t& ending_signals) {
        const bool terminal = is_screen(STDOUT_FILENO);
        {
            const auto screen = terminal ? std::make_unique<AlternateScreen>() : nullptr;
            show_until_end(terminal, ending_signals);
        }
        return finish();
    }

  private:
    DemoFigures figures(const PeerReport& report, Instant now) {
        const OutputStatus output = bench_.appliance->output_status(0);
        const InputStatus input = bench_.appliance->input_status(0);
        DemoFigures figures;
        figures.elapsed = now - start_;
        figures.input_device = bench_.input_device;
        figures.output_device = bench_.output_device;
        figures.before = report.sent;
        figures.after = report.received;
        figures.link_up = report.link_up;
        figures.input_rate_hz = in_rate_.rate(input.counts.frames, now);
        figures.output_rate_hz = out_rate_.rate(output.counts.frames, now);
        figures.frames_in = report.frames_sent;
        figures.frames_out = report.frames_received;
        figures.lost = lost_;
        const Distribution latencies(report.latencies);
        figures.latency_p50 = latencies.percentile(50);
        figures.latency_p99 = latencies.percentile(99);
        if (!report.drops.empty()) {
            figures.latest_drop = drop_sentence(report.drops.back());
        }
        return figures;
    }

    void show_until_end(bool terminal, const sigset_t& ending_signals) {
        const Duration period = terminal ? kScreenPeriod : kLinePeriod;
        while (!length_ || monotonic_now() - start_ < *length_) {
            const timespec wait = as_timespec(period);
            if (::sigtimedwait(&ending_signals, nullptr, &wait) > 0) {
                return;
            }
            bench_.appliance->reopen_devices();
            const DemoFigures now = figures(bench_.peers->report(), monotonic_now());
            if (terminal) {
                AlternateScreen::show(draw_demo(now, screen_style()));
            } else if (!print_line_now(demo_line(now))) {
                return;
            }
        }
    }

    /// Waits for frames on their way, ends the appliance, and prints the summary.
    int finish() {
        bench_.peers->stop_receiver();
        pause(kSettle);
        const std::uint64_t decoded = bench_.appliance->input_status(0).counts.frames;
        bench_.appliance->end();
        pause(kSettle);
        const std::uint64_t written = bench_.appliance->output_status(0).counts.frames;
        bench_.peers->stop();
        const PeerReport report = bench_.peers->report();
        lost_ = lost_frames(report, decoded, written);
        print_summary(report, decoded, written);
        return lost_ == 0 ? kExitFine : kExitFailed;
    }

    static void pause(Duration duration) {
        const timespec wait = as_timespec(duration);
        ::nanosleep(&wait, nullptr);
    }

    void print_summary(const PeerReport& report, std::uint64_t decoded, std::uint64_t written) {
        fmt::print("receiver: {} i.Bus frames sent, {} decoded\n", report.frames_sent, decoded);
        fmt::print(
            "servos:   {} SBUS frames written, {} read; {} of them the first with a new "
            "receiver frame\n",
            written, report.frames_received, report.frames_fresh);
        fmt::print("lost:     {}\n", lost_);
        const Distribution latencies(report.latencies);
        fmt::print("latency, receiver's write to servos' read: p50 {}, p99 {}, most {}\n",
                   short_duration(latencies.percentile(50)),
                   short_duration(latencies.percentile(99)),
                   short_duration(latencies.percentile(100)));
        for (const DropRecord& drop : report.drops) {
            fmt::print("{}\n", drop_sentence(drop));
        }
    }

    Bench bench_;
    Instant start_;
    std::optional<Duration> length_;
    RateMeter in_rate_;
    RateMeter out_rate_;
    std::uint64_t lost_ = 0;
};

/// Waits for a signal, or until `length` is over.
void wait_for_end(std::optional<Duration> length, const sigset_t& ending_signals) {
    if (length) {
        const timespec wait = as_timespec(*length);
        ::sigtimedwait(&ending_signals, nullptr, &wait);
    } else {
        ::sigwaitinfo(&ending_signals, nullptr);
    }
}

/// Plays the receiver and the servos; another program has the engine.
int play_far_ends(const std::string& file, std::optional<Duration> length,
                  const sigset_t& ending_signals) {
    auto receiver = Pty::open();
    auto servos = Pty::open();
    if (!receiver || !servos) {
        print_error("{}\n", receiver ? servos.error() : receiver.error());
        return kExitFailed;
    }
    std::ofstream out(file);
    out << demo_configuration(receiver->path, servos->path);
    if (!out.flush()) {
        print_error("{}: {}\n", file, std::strerror(errno));
        return kExitFailed;
    }
    if (!print_line_now(fmt::format("receiver at {}, servos at {}; now run {}", receiver->path,
                                    servos->path, file))) {
        return kExitFine;
    }
    DemoPeers peers(std::move(receiver->master), std::move(servos->master));
    wait_for_end(length, ending_signals);
    return kExitFine;
}

struct DemoOptions {
    std::optional<double> seconds;
    std::string far_ends;
};

int demo(const DemoOptions& options) {
    // Blocked before any thread is created, so that all inherit it and this thread can wait for
    // them.
    sigset_t ending;
    ::sigemptyset(&ending);
    ::sigaddset(&ending, SIGINT);
    ::sigaddset(&ending, SIGTERM);
    ::pthread_sigmask(SIG_BLOCK, &ending, nullptr);
    std::optional<Duration> length;
    if (options.seconds) {
        length =
            std::chrono::duration_cast<Duration>(std::chrono::duration<double>(*options.seconds));
    }
    if (!options.far_ends.empty()) {
        return play_far_ends(options.far_ends, length, ending);
    }
    auto bench = set_up();
    if (!bench) {
        print_error("{}\n", bench.error());
        return kExitFailed;
    }
    for (const std::string& lack : bench->appliance->missing_realtime()) {
        print_error("no full real time: {}\n", lack);
    }
    return Demo(std::move(*bench), length).run(ending);
}

}  // namespace

Command demo_command() {
    auto options = std::make_shared<DemoOptions>();
    constexpr double kLongestSeconds = 1e6;
    return {
        .name = "demo",
        .help = "Translate i.Bus to SBUS without hardware, with live bars",
        .notes =
            "A simulated 18-channel receiver with moving sticks on one pseudo-terminal, the real "
            "engine, a servo bank on another. The radio link drops every few seconds.",
        .options = {{.name = "--seconds",
                     .value = &options->seconds,
                     .help = "End after this time, with a summary",
                     .range = {{0.1, kLongestSeconds}},
                     .value_name = "SECONDS"},
                    {.name = "--far-ends",
                     .value = &options->far_ends,
                     .help = "Only play the receiver and the servos, and write to this file the "
                             "configuration between them, for `tribus run`",
                     .value_name = "FILE"}},
        .examples = {{"tribus demo", "until Ctrl-C"},
                     {"tribus demo --seconds 8", "ends with a summary"},
                     {"tribus demo --far-ends demo.toml",
                      "then, in another terminal: tribus run demo.toml"}},
        .exits = {{kExitFine, "no frame was lost"},
                  {kExitFailed, "frames were lost, or the work failed"}},
        .run = [options] { return demo(*options); },
    };
}

}  // namespace tribus
