#include "tests/soak/line.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace tribus::test {
namespace {

using namespace std::chrono_literals;

constexpr auto kPeriod = 7700us;
/// Far beyond the timeout of 300 ms and anything that a busy machine adds; a receiver that is
/// silent is so for longer.
constexpr auto kOld = 1500ms;
constexpr std::uint32_t kDigit = 1000;
constexpr std::uint32_t kNumbers = kDigit * kDigit;

int whole_us(int raw) {
    return static_cast<int>(std::lround(880 + raw * 5 / 8.0));
}

}  // namespace

SoakLine::SoakLine(const std::filesystem::path& folder, std::size_t number)
    : line_(number),
      receiver_(folder / fmt::format("receiver{}", number)),
      servos_(folder / fmt::format("servos{}", number)) {
    bank_.emplace(servos_);
}

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

Sticks SoakLine::sticks(std::uint32_t number) const {
    const std::uint32_t low = number % kDigit;
    const std::uint32_t high = number / kDigit % kDigit;
    Sticks sticks(18, 1500);
    sticks[0] = static_cast<int>(1000 + line_);
    sticks[1] = static_cast<int>(1000 + low);
    sticks[2] = static_cast<int>(1000 + high);
    sticks[3] = static_cast<int>(1000 + (7 * low + 3 * high + line_) % kDigit);
    return sticks;
}

std::optional<std::uint32_t> SoakLine::number_of(const SbusSight& sight) const {
    const int low = whole_us(sight.raw[1]) - 1000;
    const int high = whole_us(sight.raw[2]) - 1000;
    const auto digit = static_cast<int>(kDigit);
    if (low < 0 || low >= digit || high < 0 || high >= digit) {
        return std::nullopt;
    }
    const auto number = static_cast<std::uint32_t>(low + digit * high);
    return same_channels(sight, sbus_sight_of(sticks(number))) ? std::optional(number)
                                                               : std::nullopt;
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
        sent_[next_ % kRemembered] = now;
        receiver_.send(ibus_bytes(sticks(next_)));
        next_ = (next_ + 1) % kNumbers;
    }
}

void SoakLine::listen() {
    // What is there now came behind the listening before, and nothing more is known of it.
    const Clock::time_point came = std::exchange(listened_, Clock::now());
    for (const SbusSight& sight : bank_->listen()) {
        if (!sight.good()) {
            ++counts_.marked;
            continue;
        }
        ++counts_.good;
        if (const auto number = number_of(sight)) {
            const std::uint32_t behind = (next_ + kNumbers - *number) % kNumbers;
            const bool old = behind > kRemembered || came - sent_[*number % kRemembered] > kOld;
            counts_.old += old ? 1 : 0;
        } else {
            ++counts_.foreign;
        }
    }
    counts_.strays = strays_before_ + bank_->strays();
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
        // What was pulled in the middle of a frame does not go on.
        strays_before_ += bank_->strays();
        bank_.emplace(servos_);
    }
}

}  // namespace tribus::test
