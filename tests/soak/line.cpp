#include "tests/soak/line.h"

#include <algorithm>

#include <fmt/format.h>

namespace tribus::test {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 7700us;
/// The timeout plus one period of the output.
constexpr auto kMostAge = 307ms;

MachineStops& machine_stops() {
    static MachineStops stops;
    return stops;
}

}  // namespace

SoakLine::SoakLine(const std::filesystem::path& folder, std::size_t number)
    : line_(number),
      receiver_(folder / fmt::format("receiver{}", number)),
      servos_(folder / fmt::format("servos{}", number)),
      witness_(static_cast<unsigned>(number), kMostAge, machine_stops()) {}

std::string SoakLine::configuration() const {
    return fmt::format(R"([input.receiver{0}]
protocol = "ibus"
device = "{1}"
timeout = "300ms"
[output.servos{0}]
protocol = "sbus"
device = "{2}"
period = "7ms"
[pipeline.line{0}]
from = "receiver{0}"
to = "servos{0}"
)",
                       line_, receiver_.path(), servos_.path());
}

void SoakLine::babble(Clock::time_point until) {
    babbles_until_ = until;
    noise_from_ = Clock::now();
}

/// 115200 baud are 11520 bytes a second.
void SoakLine::send_noise(Clock::time_point now) {
    constexpr auto kByteTime = std::chrono::nanoseconds(1s) / 11'520;
    Bytes noise(static_cast<std::size_t>((now - noise_from_) / kByteTime));
    std::ranges::generate(noise, [this] { return static_cast<std::uint8_t>(noise_() >> 8U); });
    receiver_.send(noise);
    noise_from_ += noise.size() * kByteTime;
}

void SoakLine::send(Clock::time_point now) {
    if (now < babbles_until_ && receiver_plugged_) {
        send_noise(now);
        return;
    }
    if (now < due_) {
        return;
    }
    due_ = std::max(due_ + kPeriod, now);
    if (now >= silent_until_ && receiver_plugged_) {
        receiver_.send(ibus_bytes(witness_.next())) ? witness_.sent() : witness_.spoiled();
    }
}

void SoakLine::listen() {
    witness_.listen(servos_);
}

void SoakLine::pull_receiver() {
    receiver_.pull();
    receiver_plugged_ = false;
}

void SoakLine::pull_servos() {
    servos_.pull();
    servos_plugged_ = false;
}

void SoakLine::plug_in() {
    if (!receiver_plugged_) {
        receiver_.plug_in();
        receiver_plugged_ = true;
    }
    if (!servos_plugged_) {
        servos_.plug_in();
        servos_plugged_ = true;
        witness_.begin_anew();
    }
}

}  // namespace tribus::test
