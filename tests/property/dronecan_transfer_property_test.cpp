#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <span>
#include <tuple>
#include <vector>

#include "tests/support/streams.h"
#include "transports/codecs/dronecan/transfer.h"

namespace tribus::dronecan::dronecan_transfer_property_test {
namespace {

using test::Bytes;
using test::Random;
using namespace std::chrono_literals;

constexpr std::size_t kMostBytes = 300;
constexpr Instant kStart{1000s};
constexpr std::size_t kCrcBits = 16;

const std::vector<WantedTransfer> kWanted{
    {.data_type_id = 1140, .signature = 0x771555E596AAB4CF, .most_bytes = kMostBytes},
    {.data_type_id = 1010, .signature = 0xD8A7486238EC3AF3, .most_bytes = kMostBytes},
    {.kind = TransferKind::request,
     .data_type_id = 11,
     .signature = 0xA7B622F939D1A4D5,
     .most_bytes = kMostBytes},
    {.kind = TransferKind::response,
     .data_type_id = 11,
     .signature = 0xA7B622F939D1A4D5,
     .most_bytes = kMostBytes},
};
constexpr std::size_t kMostSenders = 4;

struct Transfer {
    std::size_t wanted = 0;
    TransferHead head;
    bool fd = false;
    Bytes payload;

    std::vector<CanFrame> frames() const {
        std::array<CanFrame, 64> frames;
        const std::size_t count =
            encode_transfer(head, kWanted[wanted].signature, payload, fd, frames);
        return {frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)};
    }
    /// Returns whether this is the received transfer, not counting zeros after an FD payload.
    bool is(const ReceivedTransfer& received) const {
        const std::size_t zeros = fd ? 15 : 0;
        const std::size_t size = payload.size();
        return received.head == head && received.fd == fd && received.payload.size() >= size &&
               received.payload.size() <= size + zeros &&
               std::ranges::equal(received.payload.first(size), payload) &&
               std::ranges::all_of(received.payload.subspan(size),
                                   [](std::uint8_t byte) { return byte == 0; });
    }
};

TransferHead head_for(std::size_t wanted, std::size_t sender, std::uint8_t transfer_id) {
    const bool message = kWanted[wanted].kind == TransferKind::message;
    return {.kind = kWanted[wanted].kind,
            .data_type_id = kWanted[wanted].data_type_id,
            .source = static_cast<NodeId>(1 + sender),
            .destination = message ? kNobody : NodeId{99},
            .priority = static_cast<std::uint8_t>(sender),
            .transfer_id = transfer_id};
}

Transfer any_transfer(std::size_t wanted, std::size_t sender, std::uint8_t transfer_id) {
    return {.wanted = wanted,
            .head = head_for(wanted, sender, transfer_id),
            .fd = *rc::gen::arbitrary<bool>(),
            .payload = *rc::gen::container<Bytes>(*rc::gen::inRange<std::size_t>(0, 301),
                                                  rc::gen::arbitrary<std::uint8_t>())};
}

/// Transfers of every length, in classic and in FD frames.
TEST(DronecanTransferProperty, AllLengthsComeBack) {
    TransferReceiver receiver(kWanted, kMostSenders);
    Random random(1);
    std::uint8_t transfer_id = 0;
    for (std::size_t bytes = 0; bytes <= kMostBytes; ++bytes) {
        for (const bool fd : {false, true}) {
            Transfer sent{.head = head_for(0, 0, transfer_id), .fd = fd, .payload = Bytes(bytes)};
            std::ranges::generate(sent.payload, [&random] { return random.byte(); });
            transfer_id = (transfer_id + 1U) & kMostTransferId;
            const auto frames = sent.frames();
            ASSERT_EQ(frames.size(), frame_count(bytes, fd));
            std::size_t delivered = 0;
            for (const CanFrame& frame : frames) {
                ASSERT_TRUE(valid_can_length(frame.length, fd));
                const auto taken = receiver.take(frame, kStart);
                delivered += taken.transfer && sent.is(*taken.transfer) ? 1U : 0U;
            }
            ASSERT_EQ(delivered, 1) << bytes << (fd ? " bytes in FD" : " bytes");
        }
    }
}

RC_GTEST_PROP(DronecanTransferProperty, RandomTransfersComeBack, ()) {
    TransferReceiver receiver(kWanted, kMostSenders);
    const auto wanted = *rc::gen::inRange<std::size_t>(0, kWanted.size());
    const auto transfer_id = *rc::gen::inRange<std::uint8_t>(0, kMostTransferId + 1);
    const Transfer sent = any_transfer(wanted, 3, transfer_id);
    const auto frames = sent.frames();
    for (std::size_t index = 0; index < frames.size(); ++index) {
        const auto taken = receiver.take(frames[index], kStart);
        RC_ASSERT(taken.transfer.has_value() == (index + 1 == frames.size()));
        RC_ASSERT((!taken.transfer || sent.is(*taken.transfer)));
    }
}

/// The flipped bits are a burst of at most 16 bits anywhere in the payload.
RC_GTEST_PROP(DronecanTransferProperty, AFlippedBurstInSeveralFramesIsAlwaysFound, ()) {
    TransferReceiver receiver(kWanted, kMostSenders);
    const Transfer sent = any_transfer(0, 0, 0);
    auto frames = sent.frames();
    RC_PRE(frames.size() > 1);
    Bytes carried;
    for (const CanFrame& frame : frames) {
        test::append(carried, frame.bytes().first(frame.length - 1U));
    }
    const auto pattern = *rc::gen::inRange<std::uint32_t>(1, 0x1'0000);
    const auto first_bit = *rc::gen::inRange<std::size_t>(kCrcBits, carried.size() * 8 - 15);
    for (std::size_t bit = 0; bit < 16; ++bit) {
        const std::size_t at = first_bit + bit;
        const bool flipped = (pattern >> bit & 1U) != 0;
        carried[at / 8] ^= static_cast<std::uint8_t>((flipped ? 0x80U : 0U) >> at % 8);
    }
    std::span<const std::uint8_t> rest = carried;
    FrameResult last = FrameResult::foreign;
    for (CanFrame& frame : frames) {
        std::ranges::copy(rest.first(frame.length - 1U), frame.data.begin());
        rest = rest.subspan(frame.length - 1U);
        const auto taken = receiver.take(frame, kStart);
        RC_ASSERT(!taken.transfer);
        last = taken.result;
    }
    RC_ASSERT(last == FrameResult::bad_crc);
}

/// Identifies a transfer: index of the wanted transfer, sender, number.
using Place = std::tuple<std::size_t, std::size_t, std::size_t>;

Place after(const Place& place) {
    return {std::get<0>(place), std::get<1>(place), std::get<2>(place) + 1};
}

struct OnTheBus {
    Place place;
    std::size_t index = 0;  ///< index of the frame in its transfer
    CanFrame frame;
};

/// Transfers of several senders. The frames of each session are in order, those of others between
/// them.
struct Traffic {
    std::map<Place, Transfer> sent;
    std::vector<OnTheBus> frames;

    /// `below(n)` returns a random number below n.
    template <class Below>
    void add_interleaved(std::vector<std::vector<OnTheBus>> sessions, Below below) {
        while (!sessions.empty()) {
            const std::size_t chosen = below(sessions.size());
            std::vector<OnTheBus>& session = sessions[chosen];
            frames.push_back(session.front());
            session.erase(session.begin());
            if (session.empty()) {
                sessions.erase(sessions.begin() + static_cast<std::ptrdiff_t>(chosen));
            }
        }
    }
};

/// Returns up to five transfers of each session, made by `make_transfer`.
template <class MakeTransfer, class Below>
Traffic traffic_of(MakeTransfer transfer, Below below) {
    Traffic traffic;
    std::vector<std::vector<OnTheBus>> sessions;
    for (std::size_t wanted = 0; wanted < kWanted.size(); ++wanted) {
        for (std::size_t sender = 0; sender < 1 + below(3); ++sender) {
            std::vector<OnTheBus>& session = sessions.emplace_back();
            const std::size_t first_id = below(32);
            const std::size_t count = 1 + below(5);
            for (std::size_t number = 0; number < count; ++number) {
                const auto id = static_cast<std::uint8_t>((first_id + number) % 32);
                const Place place{wanted, sender, number};
                const Transfer& sent = traffic.sent[place] = transfer(wanted, sender, id);
                std::size_t index = 0;
                for (const CanFrame& frame : sent.frames()) {
                    session.push_back({place, index++, frame});
                }
            }
        }
    }
    traffic.add_interleaved(std::move(sessions), below);
    return traffic;
}

struct Outcome {
    std::map<Place, int> delivered;
    int invented = 0;
};

Outcome outcome_of(const Traffic& traffic, std::span<const OnTheBus> arriving) {
    TransferReceiver receiver(kWanted, kMostSenders);
    Outcome outcome;
    Instant now = kStart;
    for (const OnTheBus& each : arriving) {
        now += 100us;
        const auto taken = receiver.take(each.frame, now);
        if (!taken.transfer) {
            continue;
        }
        const auto is_it = [&](const auto& sent) { return sent.second.is(*taken.transfer); };
        const auto found = std::ranges::find_if(traffic.sent, is_it);
        if (found == traffic.sent.end()) {
            ++outcome.invented;
        } else {
            ++outcome.delivered[found->first];
        }
    }
    return outcome;
}

std::size_t any_below(std::size_t limit) {
    return *rc::gen::inRange<std::size_t>(0, limit);
}

RC_GTEST_PROP(DronecanTransferProperty, InterleavedSessionsAllArriveOnce, ()) {
    const Traffic traffic = traffic_of(any_transfer, any_below);
    const Outcome outcome = outcome_of(traffic, traffic.frames);
    RC_ASSERT(outcome.invented == 0);
    RC_ASSERT(outcome.delivered.size() == traffic.sent.size());
    for (const auto& [place, times] : outcome.delivered) {
        RC_ASSERT(times == 1);
    }
}

/// Some copies are sent, and one frame is lost: the first, the last or the one before it. A loss in
/// the middle is found only by the CRC.
RC_GTEST_PROP(DronecanTransferProperty, ALostFrameCostsItsTransferAndACopyNothing, ()) {
    const Traffic traffic = traffic_of(any_transfer, any_below);
    std::map<Place, std::size_t> lost;
    for (const auto& [place, sent] : traffic.sent) {
        if (*rc::gen::weightedElement<bool>({{3, false}, {1, true}})) {
            const std::size_t count = frame_count(sent.payload.size(), sent.fd);
            lost[place] = *rc::gen::element<std::size_t>(0, count - 1,
                                                         count - std::min(count, std::size_t{2}));
        }
    }
    std::vector<OnTheBus> arriving;
    for (const OnTheBus& each : traffic.frames) {
        const auto found = lost.find(each.place);
        if (found == lost.end() || found->second != each.index) {
            arriving.insert(arriving.end(), 1 + any_below(2), each);
        }
    }
    const Outcome outcome = outcome_of(traffic, arriving);
    RC_ASSERT(outcome.invented == 0);
    for (const auto& [place, sent] : traffic.sent) {
        const auto found = outcome.delivered.find(place);
        const int times = found == outcome.delivered.end() ? 0 : found->second;
        RC_ASSERT(times == (lost.contains(place) ? 0 : 1));
    }
}

Transfer transfer_of(Random& random, std::size_t wanted, std::size_t sender, std::uint8_t id) {
    Transfer transfer{.wanted = wanted,
                      .head = head_for(wanted, sender, id),
                      .fd = random.below(2) == 0,
                      .payload = Bytes(random.below(random.below(4) == 0 ? 301 : 40))};
    std::ranges::generate(transfer.payload, [&random] { return random.byte(); });
    return transfer;
}

/// Loses frames, doubles them, or delays them by up to 40 places. No frame comes later than the
/// transfer after its own, because from then on the specification cannot recognise a copy.
std::vector<OnTheBus> damaged(const Traffic& traffic, Random& random) {
    struct Arrival {
        std::size_t slot = 0;
        OnTheBus frame;
    };
    std::map<Place, std::size_t> last_slot;
    for (std::size_t slot = 0; slot < traffic.frames.size(); ++slot) {
        last_slot[traffic.frames[slot].place] = slot;
    }
    std::vector<Arrival> arrivals;
    for (std::size_t slot = 0; slot < traffic.frames.size(); ++slot) {
        const OnTheBus& each = traffic.frames[slot];
        const auto next = last_slot.find(after(each.place));
        const std::size_t limit = next == last_slot.end() ? SIZE_MAX : next->second;
        const std::uint32_t luck = random.below(32);
        for (std::uint32_t copy = 0; copy < (luck == 0 ? 0U : luck == 1 ? 2U : 1U); ++copy) {
            const std::size_t late = random.below(8) == 0 ? random.below(40) : 0U;
            arrivals.push_back({std::min(slot + late, limit), each});
        }
    }
    std::ranges::stable_sort(arrivals, {}, &Arrival::slot);
    std::vector<OnTheBus> arriving;
    for (const Arrival& arrival : arrivals) {
        arriving.push_back(arrival.frame);
    }
    return arriving;
}

/// Returns the transfers whose frames all came once, in order and before the next transfer started.
std::set<Place> whole_in(std::span<const OnTheBus> arriving, const Traffic& traffic) {
    std::map<Place, std::vector<std::size_t>> came;
    for (const OnTheBus& each : arriving) {
        came[each.place].push_back(came.contains(after(each.place)) ? SIZE_MAX : each.index);
    }
    std::set<Place> whole;
    for (const auto& [place, indices] : came) {
        std::vector<std::size_t> all(traffic.sent.at(place).frames().size());
        std::iota(all.begin(), all.end(), 0U);
        if (indices == all) {
            whole.insert(place);
        }
    }
    return whole;
}

// CRC-16 accepts one of 65536 transfers that consist of wrong frames with fitting toggle bits.
// These streams are therefore the same each time, and none has such a transfer.
TEST(DronecanTransferProperty, LossCopiesAndDisorderInventNothingAndCostOnlyWhatTheyHit) {
    std::size_t sent_count = 0;
    std::size_t whole_count = 0;
    for (std::uint32_t seed = 1; seed <= 300; ++seed) {
        Random random(seed);
        const Traffic traffic = traffic_of(
            [&random](std::size_t wanted, std::size_t sender, std::uint8_t id) {
                return transfer_of(random, wanted, sender, id);
            },
            [&random](std::size_t limit) {
                return std::size_t{random.below(static_cast<std::uint32_t>(limit))};
            });
        const std::vector<OnTheBus> arriving = damaged(traffic, random);
        const Outcome outcome = outcome_of(traffic, arriving);
        ASSERT_EQ(outcome.invented, 0) << "seed " << seed;
        for (const auto& [place, times] : outcome.delivered) {
            ASSERT_EQ(times, 1) << "seed " << seed;
        }
        const std::set<Place> whole = whole_in(arriving, traffic);
        for (const Place& place : whole) {
            ASSERT_TRUE(outcome.delivered.contains(place)) << "seed " << seed;
        }
        sent_count += traffic.sent.size();
        whole_count += whole.size();
    }
    EXPECT_GT(whole_count, sent_count / 4);
    EXPECT_LT(whole_count, sent_count * 3 / 4);
}

/// Impossible lengths, tail bytes of all kinds, ids near the wanted ones, times that jump.
TEST(DronecanTransferProperty, AnyFramesAtAllAreJudgedAndNoPayloadIsTooLong) {
    std::vector<WantedTransfer> wanted = kWanted;
    wanted[0].most_bytes = 0;
    wanted[1].most_bytes = 70;
    TransferReceiver receiver(wanted, 2);
    Random random(3);
    constexpr std::uint64_t kFrames = 200'000;
    std::uint64_t delivered = 0;
    for (std::uint64_t count = 0; count < kFrames; ++count) {
        CanFrame frame;
        frame.id = can_id_of(head_for(random.below(4), random.below(4), 0)) ^
                   (random.below(16) == 0 ? 1U << random.below(29) : 0U);
        frame.extended = random.below(32) != 0;
        frame.remote = random.below(32) == 0;
        frame.fd = random.below(2) == 0;
        frame.length = random.below(2) == 0 ? random.byte() : frame.fd ? 64 : 8;
        for (std::uint8_t& byte : frame.data) {
            byte = random.byte() & 0xE1U;
        }
        const Instant at = random.below(64) == 0 ? kNever : kStart + random.below(4000) * 1ms;
        const auto taken = receiver.take(frame, at);
        if (taken.transfer) {
            ++delivered;
            const bool first = taken.transfer->head.data_type_id == 1140;
            ASSERT_LE(taken.transfer->payload.size(), first ? 0 : kMostBytes);
        }
    }
    EXPECT_GT(delivered, 0U);
    EXPECT_EQ(std::reduce(receiver.counts().begin(), receiver.counts().end()), kFrames);
}

}  // namespace
}  // namespace tribus::dronecan::dronecan_transfer_property_test
