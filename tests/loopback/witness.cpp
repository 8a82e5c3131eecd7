#include "tests/loopback/witness.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

namespace tribus::test {
namespace {

constexpr std::uint32_t kDigit = 1000;
constexpr std::uint32_t kNumbers = kDigit * kDigit;
constexpr std::size_t kChannels = 16;
/// Channels with the low and the high part of the number. The channel before them has the line.
constexpr std::size_t kLow = 1;
constexpr std::size_t kHigh = 2;

int whole_us(std::uint16_t raw) {
    return static_cast<int>(std::lround(880 + raw * 5 / 8.0));
}

double in_ms(Clock::duration duration) {
    return std::chrono::duration<double, std::milli>(duration).count();
}

}  // namespace

std::string to_text(const Testimony& testimony) {
    return fmt::format(
        "{} unmarked (oldest {:.1f} ms), {} marked, {} never sent, {} too old, {} overtaken, "
        "{} stray bytes",
        testimony.unmarked, in_ms(testimony.oldest), testimony.marked, testimony.never_sent,
        testimony.too_old, testimony.overtaken, testimony.strays);
}

Sticks Witness::sticks(std::uint32_t number) const {
    Sticks sticks(kChannels);
    std::uint32_t mixed = number + line_ * kNumbers;
    for (int& stick : sticks) {
        mixed = mixed * 1'664'525 + 1'013'904'223;
        stick = static_cast<int>(1000 + (mixed >> 8U) % kDigit);
    }
    sticks[0] = static_cast<int>(1000 + line_);
    sticks[kLow] = static_cast<int>(1000 + number % kDigit);
    sticks[kHigh] = static_cast<int>(1000 + number / kDigit % kDigit);
    return sticks;
}

/// Returns the number of the frame with all of these values, or nothing if this line sent none.
std::optional<std::uint32_t> Witness::number_of(std::span<const std::uint16_t> raw) const {
    const int low = whole_us(raw[kLow]) - 1000;
    const int high = whole_us(raw[kHigh]) - 1000;
    const auto digit = static_cast<int>(kDigit);
    if (low < 0 || low >= digit || high < 0 || high >= digit) {
        return std::nullopt;
    }
    const auto number = static_cast<std::uint32_t>(low + digit * high);
    const std::uint32_t behind = (next_ + kNumbers - number) % kNumbers;
    const bool known = behind > 0 && behind <= kRemembered && sent_[number % kRemembered];
    const bool same = std::ranges::equal(raw, sticks(number), {}, {}, sbus_raw);
    return known && same ? std::optional(number) : std::nullopt;
}

void Witness::sent() {
    sent_[next_ % kRemembered] = Clock::now();
    next_ = (next_ + 1) % kNumbers;
}

void Witness::spoiled() {
    sent_[next_ % kRemembered].reset();
    next_ = (next_ + 1) % kNumbers;
}

void Witness::listen(FarEnd& servos) {
    // These bytes came after the previous call; nothing more is known about their time.
    const Clock::time_point not_before = std::exchange(listened_, Clock::now());
    const Bytes fresh = servos.receive();
    bytes_ += fresh.size();
    arrivals_.push_back({bytes_, not_before});
    std::span<const std::uint8_t> rest(fresh);
    while (const auto frame = decoder_->next(rest, Instant{})) {
        judge(*frame);
    }
    testimony_.strays = strays_before_ + decoder_->skipped_bytes();
}

void Witness::judge(const DecodedFrame& frame) {
    const std::uint64_t end = frame.first_byte + frame.length;
    while (arrivals_.front().end < end) {
        arrivals_.pop_front();
    }
    in_control_ = frame.channels.good();
    if (!in_control_) {
        ++testimony_.marked;
        return;
    }
    ++testimony_.unmarked;
    const auto number = number_of(decoder_->details().front().values);
    if (!number) {
        ++testimony_.never_sent;
        return;
    }
    testimony_.overtaken += *number < oldest_wanted_ ? 1U : 0U;
    const Clock::time_point sent = *sent_[*number % kRemembered];
    const Clock::time_point arrived = arrivals_.front().not_before;
    testimony_.oldest = std::max(testimony_.oldest, arrived - sent);
    const bool too_old =
        arrived - sent > most_age_ && arrived - sent > most_age_ + stops_.within(sent, arrived);
    testimony_.too_old += too_old ? 1U : 0U;
}

void Witness::begin_anew() {
    strays_before_ = testimony_.strays;
    decoder_.emplace();
    arrivals_.clear();
    bytes_ = 0;
}

}  // namespace tribus::test
