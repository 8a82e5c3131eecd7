#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <string_view>

#include "tests/support/stored_numbers.h"
#include "transports/codecs/authenticated/broadcast_ends.h"

/// count_authenticated WORKLOAD UNITS
///
/// Passes UNITS snapshots, 10 ms apart, from the sender of a link with a key to its receiver, with
/// the challenges: a new one for each fifth snapshot. As count_codecs: the difference between two
/// runs with other UNITS is only the work. WORKLOAD is `can_fd`, `can_fd_epoch` for a receiver that
/// does not answer, or `mac` for the MACs of the snapshots alone.
namespace tribus {
namespace {

using std::chrono::milliseconds;

/// Returns how many snapshots counted.
std::size_t carry(std::size_t units, bool epoch) {
    authenticated::FdLink link{
        .keys = {.name = "can fd 0x300 boat"}, .sender_id = 0x305, .receiver_id = 0x300};
    if (epoch) {
        link.keys.epoch = "not read by codecs";
    }
    const auto sender = authenticated::make_fd_encoder(link);
    const auto receiver = authenticated::make_fd_decoder(link);
    test::StoredNumbers sent(1000);
    test::StoredNumbers received(0);
    sender->use_seed({1, 2, 3});
    receiver->use_seed({4, 5, 6});
    sender->use_numbers(sent);
    receiver->use_numbers(received);
    ChannelFrame sticks;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        sticks.set(channel, Pulse::from_microseconds(1500));
    }
    sticks.failsafe = false;
    sticks.frame_lost = false;
    std::array<CanFrame, kMostSnapshotFrames> frames{};
    std::size_t counted = 0;
    Instant now{std::chrono::seconds(1)};
    for (std::size_t unit = 0; unit < units; ++unit) {
        now += milliseconds(10);
        sticks.received = now;
        const std::size_t count = sender->write(sticks, frames, now);
        for (const CanFrame& frame : std::span(frames).first(count)) {
            counted += receiver->next(frame, now) ? 1U : 0U;
        }
        for (const CanFrame& frame : receiver->answer(now)) {
            sender->hear(frame, now);
        }
        sent.store();
        received.store();
    }
    return counted;
}

/// Returns how many MACs were right.
std::size_t prove(std::size_t units) {
    const authenticated::LinkMacs macs({}, "can fd 0x300 boat");
    authenticated::Mac sender_keys = macs.snapshot_keys;
    authenticated::Mac receiver_keys = macs.snapshot_keys;
    std::array<std::uint8_t, authenticated::kSnapshotBodyBytes> message{};
    std::size_t right = 0;
    for (std::size_t unit = 0; unit < units;) {
        const auto answered =
            authenticated::answered_bytes({static_cast<std::uint8_t>(unit)}, 0x010203);
        authenticated::SnapshotMac sender(sender_keys, answered);
        authenticated::SnapshotMac receiver(receiver_keys, answered);
        for (std::size_t of_five = 0; of_five < 5; ++of_five, ++unit) {
            const auto counter = static_cast<std::uint16_t>(unit);
            message[0] = static_cast<std::uint8_t>(unit);
            right += receiver.is_right(sender.of(counter, message), counter, message) ? 1U : 0U;
        }
    }
    return right;
}

}  // namespace
}  // namespace tribus

int main(int words, char** word) {
    if (words < 3) {
        return 2;
    }
    const std::size_t units = std::strtoul(word[2], nullptr, 10);
    if (word[1] == std::string_view("mac")) {
        return tribus::prove(units) == units ? 0 : 1;
    }
    // The first one is a hello; with an epoch each end lacks stored numbers once.
    const bool epoch = word[1] == std::string_view("can_fd_epoch");
    return tribus::carry(units, epoch) + (epoch ? 2 : 1) == units ? 0 : 1;
}
