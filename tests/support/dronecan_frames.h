#pragma once

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "core/can_frame.h"
#include "core/time.h"
#include "transports/codecs/codec.h"
#include "transports/codecs/dronecan/fields.h"
#include "transports/codecs/dronecan/payload.h"
#include "transports/codecs/dronecan/transfer.h"

/// Functions that write and read DroneCAN frames for tests.
namespace tribus::test {

inline constexpr Instant kStart = Instant{} + std::chrono::seconds(1000);

inline std::vector<CanFrame> frames_from(std::uint32_t id, const std::vector<std::string>& hex) {
    std::vector<CanFrame> frames;
    for (const std::string& text : hex) {
        CanFrame& frame = frames.emplace_back();
        frame.id = id;
        frame.extended = true;
        frame.length = static_cast<std::uint8_t>(text.size() / 2);
        for (std::size_t i = 0; i < frame.length; ++i) {
            frame.data[i] =
                static_cast<std::uint8_t>(std::stoul(text.substr(2 * i, 2), nullptr, 16));
        }
    }
    return frames;
}

/// Returns the frames of a message, request or response.
template <class Message>
std::vector<CanFrame> frames_of_transfer(dronecan::TransferHead head, const Message& message,
                                         bool fd = false) {
    constexpr dronecan::DataType kType = dronecan::data_type_of<Message>();
    head.kind = kType.kind;
    head.data_type_id = kType.id;
    std::vector<CanFrame> frames(64);
    frames.resize(
        dronecan::encode_transfer(head, kType.signature, dronecan::write(message, fd), fd, frames));
    return frames;
}

template <class Message>
std::vector<CanFrame> frames_of_message(const Message& message, dronecan::NodeId source,
                                        std::uint8_t transfer_id, bool fd = false) {
    return frames_of_transfer({.source = source, .priority = 8, .transfer_id = transfer_id},
                              message, fd);
}

/// Returns the content of one whole transfer.
template <class Message>
Message message_of_frames(std::span<const CanFrame> frames, bool fd = false) {
    constexpr dronecan::DataType kType = dronecan::data_type_of<Message>();
    dronecan::TransferReceiver receiver(
        {{kType.kind, kType.id, kType.signature, dronecan::kMostBytes<Message>}}, 1);
    for (const CanFrame& frame : frames) {
        if (const auto taken = receiver.take(frame, kStart); taken.transfer) {
            const auto message = dronecan::read<Message>(taken.transfer->payload, fd);
            EXPECT_TRUE(message) << "not a " << kType.name;
            return message.value_or(Message{});
        }
    }
    ADD_FAILURE() << "no whole " << kType.name;
    return {};
}

inline std::uint64_t count_named(std::span<const NamedCount> counts, std::string_view name) {
    for (const NamedCount& count : counts) {
        if (count.name == name) {
            return count.count;
        }
    }
    ADD_FAILURE() << "no reject count is called " << name;
    return 0;
}

}  // namespace tribus::test
