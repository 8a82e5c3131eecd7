#pragma once

#include <chrono>
#include <optional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/raw_can.h"
#include "tests/loopback/program.h"
#include "tests/support/dronecan_frames.h"
#include "transports/codecs/dronecan/payload.h"
#include "transports/codecs/dronecan/transfer.h"

/// DroneCAN nodes that the tests simulate.
namespace tribus::test {

inline void send(RawCan& bus, const std::vector<CanFrame>& frames) {
    for (const CanFrame& frame : frames) {
        EXPECT_EQ(bus.send(frame), 0);
    }
}

/// Assembles the received transfers of one type.
template <class Message>
class Ear {
  public:
    std::optional<std::pair<dronecan::TransferHead, Message>> take(const CanFrame& frame) {
        const auto taken = receiver_.take(frame, now_ += std::chrono::milliseconds(1));
        if (!taken.transfer) {
            return std::nullopt;
        }
        const auto message = dronecan::read<Message>(taken.transfer->payload, taken.transfer->fd);
        EXPECT_TRUE(message);
        return message ? std::optional(std::pair(taken.transfer->head, *message)) : std::nullopt;
    }

  private:
    static constexpr dronecan::DataType kType = dronecan::data_type_of<Message>();
    dronecan::TransferReceiver receiver_{
        {{kType.kind, kType.id, kType.signature, dronecan::kMostBytes<Message>}}, 8};
    Instant now_ = kStart;
};

/// Receives messages until `done` returns true for one. Returns false when kPatience is over.
template <class Message, class Done>
bool hear_until(RawCan& bus, Done done) {
    Ear<Message> ear;
    return eventually([&] {
        for (const CanSight& sight : bus.receive_all()) {
            if (const auto heard = ear.take(sight.frame);
                heard && done(heard->first, heard->second)) {
                return true;
            }
        }
        return false;
    });
}

}  // namespace tribus::test
