#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/dronecan/transfer.h"

/// Transfers and receive sequences that three independent codecs agree on (README of the
/// recordings).
namespace tribus::dronecan::dronecan_transfer_test {
namespace {

using nlohmann::json;
using test::Bytes;

class DronecanVectors : public testing::Test {
  protected:
    void SetUp() override { vectors_ = test::vectors("dronecan_vectors.json"); }

    json vectors_;
};

Bytes bytes_in(const json& hex) {
    return test::from_hex(hex.get<std::string>());
}

std::uint64_t number_in(const json& hex) {
    return std::stoull(hex.get<std::string>(), nullptr, 16);
}

NodeId node_in(const json& number) {
    return number.is_null() ? kNobody : number.get<NodeId>();
}

TransferKind kind_in(const json& transfer) {
    const auto name = transfer["transfer_kind"].get<std::string>();
    EXPECT_TRUE(name == "message" || name == "request" || name == "response") << name;
    return name == "request"    ? TransferKind::request
           : name == "response" ? TransferKind::response
                                : TransferKind::message;
}

TransferHead head_in(const json& transfer) {
    return {.kind = kind_in(transfer),
            .data_type_id = transfer["data_type_id"].get<std::uint16_t>(),
            .source = node_in(transfer["source_node_id"]),
            .destination = node_in(transfer["destination_node_id"]),
            .priority = transfer["priority"].get<std::uint8_t>(),
            .transfer_id = transfer["transfer_id"].get<std::uint8_t>()};
}

CanFrame frame_in(const json& vector, bool fd) {
    CanFrame frame{.id = static_cast<std::uint32_t>(number_in(vector["can_id"])),
                   .extended = true,
                   .fd = fd,
                   .bit_rate_switch = fd};
    const Bytes data = bytes_in(vector["data"]);
    frame.length = static_cast<std::uint8_t>(data.size());
    std::ranges::copy(data, frame.data.begin());
    return frame;
}

std::vector<CanFrame> frames_in(const json& vector) {
    std::vector<CanFrame> frames;
    for (const json& frame : vector["frames"]) {
        frames.push_back(frame_in(frame, vector["can_fd"].get<bool>()));
    }
    return frames;
}

Bytes copy_of(const ReceivedTransfer& transfer) {
    return {transfer.payload.begin(), transfer.payload.end()};
}

TEST_F(DronecanVectors, AllTransfersAreSentAsTheirFrames) {
    for (const json& transfer : vectors_["transfers"]) {
        const Bytes payload = bytes_in(transfer["payload_hex"]);
        std::array<CanFrame, 16> frames;
        const std::size_t count =
            encode_transfer(head_in(transfer), number_in(transfer["signature"]), payload,
                            transfer["can_fd"].get<bool>(), frames);
        EXPECT_EQ(std::vector(frames.begin(), frames.begin() + static_cast<std::ptrdiff_t>(count)),
                  frames_in(transfer))
            << transfer["name"];
    }
    EXPECT_EQ(vectors_["transfers"].size(), 31);
}

TEST_F(DronecanVectors, TransfersOfSeveralFramesHaveTheirCrc) {
    int seen = 0;
    for (const json& transfer : vectors_["transfers"]) {
        if (!transfer["transfer_crc"].is_null()) {
            EXPECT_EQ(
                transfer_crc(number_in(transfer["signature"]), bytes_in(transfer["payload_hex"])),
                number_in(transfer["transfer_crc"]))
                << transfer["name"];
            ++seen;
        }
    }
    EXPECT_EQ(seen, 16);
}

TEST_F(DronecanVectors, AllTransfersAreReceivedFromTheirFrames) {
    for (const json& vector : vectors_["transfers"]) {
        const TransferHead head = head_in(vector);
        const Bytes payload = bytes_in(vector["payload_hex"]);
        TransferReceiver receiver({{.kind = head.kind,
                                    .data_type_id = head.data_type_id,
                                    .signature = number_in(vector["signature"]),
                                    .most_bytes = payload.size()}},
                                  1);
        std::vector<Bytes> received;
        for (const CanFrame& frame : frames_in(vector)) {
            if (const auto taken = receiver.take(frame, Instant{}); taken.transfer) {
                EXPECT_EQ(taken.transfer->head, head) << vector["name"];
                received.push_back(copy_of(*taken.transfer));
            }
        }
        EXPECT_EQ(received, std::vector<Bytes>{payload}) << vector["name"];
    }
}

struct Delivered {
    NodeId source = kNobody;
    std::uint8_t transfer_id = 0;
    std::uint16_t data_type_id = 0;
    Bytes payload;

    bool operator==(const Delivered&) const = default;
};

std::vector<Delivered> expected_of(const json& sequence) {
    std::vector<Delivered> all;
    for (const json& accepted : sequence["accepted_by_spec_pseudocode"]) {
        all.push_back(
            {accepted["source_node_id"].get<NodeId>(), accepted["transfer_id"].get<std::uint8_t>(),
             accepted["data_type_id"].get<std::uint16_t>(), bytes_in(accepted["payload_hex"])});
    }
    return all;
}

constexpr std::size_t kMostRcInputBytes = 53;

std::vector<Delivered> delivered_of(const json& sequence) {
    TransferReceiver receiver({{.data_type_id = 1140,
                                .signature = number_in(sequence["signature"]),
                                .most_bytes = kMostRcInputBytes}},
                              2);
    std::vector<Delivered> all;
    for (const json& frame : sequence["frames"]) {
        const Instant at{std::chrono::microseconds(frame["t_us"].get<std::int64_t>())};
        const auto taken = receiver.take(frame_in(frame, sequence["can_fd"].get<bool>()), at);
        if (taken.transfer) {
            all.push_back({taken.transfer->head.source, taken.transfer->head.transfer_id,
                           taken.transfer->head.data_type_id, copy_of(*taken.transfer)});
        }
    }
    return all;
}

TEST_F(DronecanVectors, AllSequencesAreReceivedAsTheSpecificationSays) {
    for (const json& sequence : vectors_["receive_sequences"]) {
        EXPECT_EQ(delivered_of(sequence), expected_of(sequence)) << sequence["name"];
    }
    EXPECT_EQ(vectors_["receive_sequences"].size(), 18);
}

}  // namespace
}  // namespace tribus::dronecan::dronecan_transfer_test
