#include "tests/bench/response_times.h"

#include <fcntl.h>
#include <poll.h>
#include <sched.h>
#include <sys/mman.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <ctime>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/cli/pty.h"
#include "pipelines/realtime/clock.h"
#include "tests/bench/process.h"
#include "tests/bench/tester.h"

namespace tribus::test {
namespace {

using namespace bench;

/// Slot of a genuine receiver (docs/protocols/ibus.md, "Sensor bus: timing").
constexpr Duration kSlot = std::chrono::microseconds(7700);
/// Slots until the product knows the rhythm of the receiver and the caches are warm.
constexpr int kWarmUpSlots = 100;

// The request for the value of address 1, and the answer with raw value 1.
constexpr std::array<std::uint8_t, 4> kRequest{0x04, 0xA1, 0x5A, 0xFF};
constexpr std::array<std::uint8_t, 6> kReply{0x06, 0xA1, 0x01, 0x00, 0x57, 0xFF};

/// Answers requests until the process is killed. Returns only if something that it needs is
/// missing.
int respond(const std::string& device, const BoundSettings& settings) {
    const int descriptor = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK);
    termios line{};
    ::tcgetattr(descriptor, &line);
    ::cfmakeraw(&line);
    ::tcsetattr(descriptor, TCSANOW, &line);
    if (settings.cpu) {
        cpu_set_t cpus;
        CPU_ZERO(&cpus);
        CPU_SET(static_cast<std::size_t>(*settings.cpu), &cpus);
        ::sched_setaffinity(0, sizeof cpus, &cpus);
    }
    const sched_param parameters{.sched_priority = settings.priority};
    if (descriptor < 0 || ::mlockall(MCL_CURRENT | MCL_FUTURE) != 0 ||
        ::sched_setscheduler(0, SCHED_FIFO, &parameters) != 0) {
        std::perror("the bare responder gets no real-time scheduling");
        return 1;
    }
    pollfd wait{.fd = descriptor, .events = POLLIN, .revents = 0};
    std::array<std::uint8_t, 64> buffer;
    while (::poll(&wait, 1, -1) > 0) {
        const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
        if (count == static_cast<ssize_t>(kRequest.size()) &&
            ::write(descriptor, kReply.data(), kReply.size()) !=
                static_cast<ssize_t>(kReply.size())) {
            return 1;
        }
    }
    return 1;
}

/// A process that answers at the near end of a pty.
struct Responder {
    Pty wire;
    Process process;
    std::vector<Duration> samples{};
    std::size_t missed = 0;
};

tl::expected<Responder, std::string> bare_responder(const BoundSettings& settings) {
    auto wire = Pty::open();
    if (!wire) {
        return Refused(wire.error());
    }
    auto process = Process::fork([&] { return respond(wire->path, settings); });
    if (!process) {
        return Refused(process.error());
    }
    return Responder{std::move(*wire), std::move(*process)};
}

tl::expected<Responder, std::string> product(const BoundSettings& settings,
                                             std::string_view more_lines) {
    auto wire = Pty::open();
    if (!wire) {
        return Refused(wire.error());
    }
    const ApplianceSettings how = appliance(settings);
    const std::string text =
        runtime_text(how) +
        fmt::format(
            "[sensor_bus.telemetry]\nrole = \"sensor\"\nwires = \"two\"\ndevice = \"{}\"\n"
            "{}[[sensor_bus.telemetry.sensor]]\ntype = \"rotation_speed\"\n"
            "value = \"speed\"\n[values.speed]\nconstant = 1\nunit = \"rpm\"\n",
            wire->path, more_lines);
    auto process = run_configuration(text, how);
    if (!process) {
        return Refused(process.error());
    }
    if (auto started = wait_until_started(*process); !started) {
        return Refused(started.error());
    }
    return Responder{std::move(*wire), std::move(*process)};
}

/// Returns the time from the end of the write of the request until the first byte was read.
std::optional<Duration> ask(const Responder& responder) {
    const int wire = responder.wire.master.get();
    std::array<std::uint8_t, 64> buffer{};
    while (::read(wire, buffer.data(), buffer.size()) > 0) {
    }
    if (::write(wire, kRequest.data(), kRequest.size()) != static_cast<ssize_t>(kRequest.size())) {
        return std::nullopt;
    }
    const Instant asked = monotonic_now();
    pollfd wait{.fd = wire, .events = POLLIN, .revents = 0};
    const timespec patience{.tv_sec = 0, .tv_nsec = kNoAnswerAfter.count()};
    if (::ppoll(&wait, 1, &patience, nullptr) <= 0) {
        return std::nullopt;
    }
    const ssize_t count = ::read(wire, buffer.data(), buffer.size());
    const Instant answered = monotonic_now();
    const bool right = count == static_cast<ssize_t>(kReply.size()) &&
                       std::equal(kReply.begin(), kReply.end(), buffer.begin());
    return right ? std::optional(answered - asked) : std::nullopt;
}

/// A request that this machine sends later than this is not counted: a real receiver is on time.
constexpr Duration kTesterLate = std::chrono::microseconds(300);

/// Asks each responder once in each slot, at evenly spaced times.
void ask_in_slots(std::vector<Responder>& responders, Duration length) {
    const auto slots = static_cast<int>(length / kSlot) + kWarmUpSlots;
    const Duration step = kSlot / static_cast<std::int64_t>(responders.size());
    for (Responder& responder : responders) {
        responder.samples.reserve(static_cast<std::size_t>(slots));
    }
    const TesterPriority priority;
    Instant next = monotonic_now() + kSlot;
    for (int slot = 0; slot < slots && !interrupted(); ++slot) {
        for (Responder& responder : responders) {
            sleep_until(next);
            const bool tester_late = monotonic_now() - next > kTesterLate;
            next += step;
            const auto time = ask(responder);
            // The product rightly withholds the answer to a request that is out of rhythm.
            if (slot < kWarmUpSlots || tester_late) {
                continue;
            }
            responder.samples.push_back(time.value_or(kNoAnswerAfter));
            responder.missed += time ? 0U : 1U;
        }
    }
}

}  // namespace

tl::expected<ResponseTimes, std::string> response_times(const BoundSettings& settings) {
    std::vector<Responder> responders;
    for (auto& responder :
         std::array{bare_responder(settings), product(settings, "reply_after = \"0us\"\n"),
                    product(settings, ""), bare_responder(settings)}) {
        if (!responder) {
            return Refused(responder.error());
        }
        responders.push_back(std::move(*responder));
    }
    ask_in_slots(responders, settings.length);
    std::vector<Responses> all;
    for (Responder& responder : responders) {
        all.push_back({Distribution(std::move(responder.samples)), responder.missed});
        if (all.back().times.size() == responder.missed) {
            return Refused("no answers: " + responder.process.errors());
        }
    }
    return ResponseTimes{.at_once = std::move(all[1]),
                         .by_default = std::move(all[2]),
                         .bare = std::move(all[0]),
                         .bare_again = std::move(all[3])};
}

}  // namespace tribus::test
