#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>
#include <nlohmann/json.hpp>

#include "app/wire/decode_dronecan.h"
#include "app/wire/dronecan/dronecan_explainer.h"
#include "transports/codecs/dronecan/known_payloads.h"
#include "transports/codecs/dronecan/transfer.h"

/// Whatever is on a bus, `decode` accounts for every frame in every output format.
namespace tribus::dronecan_decode_property_test {
namespace {

using dronecan::TransferHead;

Recording recording_of(const std::vector<CanFrame>& frames, Duration between) {
    Recording recording;
    recording.kind = RecordingKind::candump;
    Duration at{};
    for (const CanFrame& frame : frames) {
        recording.can_frames.push_back({at, "can0", frame});
        at += between;
    }
    return recording;
}

TransferHead any_head() {
    const auto known = dronecan::known_payloads();
    const auto& type = known[*rc::gen::inRange<std::size_t>(0, known.size())].type;
    const bool service = type.kind != dronecan::TransferKind::message;
    return {.kind = type.kind,
            .data_type_id = type.id,
            .source = *rc::gen::inRange<std::uint8_t>(service ? 1 : 0, 4),
            .destination = service ? *rc::gen::inRange<std::uint8_t>(1, 4) : dronecan::kNobody,
            .priority = *rc::gen::inRange<std::uint8_t>(0, 32),
            .transfer_id = *rc::gen::inRange<std::uint8_t>(0, 32)};
}

/// Returns a frame of a known type with any bytes. Its tail byte is any consistent one, or missing.
CanFrame any_frame() {
    CanFrame frame;
    frame.extended = true;
    frame.fd = *rc::gen::arbitrary<bool>();
    frame.bit_rate_switch = frame.fd;
    frame.id = dronecan::can_id_of(any_head());
    const std::size_t length = *rc::gen::inRange<std::size_t>(0, frame.fd ? 65 : 9);
    frame.length = static_cast<std::uint8_t>(can_length_for(length));
    for (std::uint8_t& byte : frame.bytes()) {
        byte = *rc::gen::arbitrary<std::uint8_t>();
    }
    return frame;
}

std::vector<std::string> lines_of(const Recording& recording, DecodeFormat format) {
    std::ostringstream results;
    std::ostringstream messages;
    TransferDecoding decoding(60, {format, RecordingKind::candump, results, messages});
    RecordingInMemory source(recording);
    decode_recording(source, decoding, messages);
    std::vector<std::string> lines;
    std::istringstream text(results.str());
    for (std::string line; std::getline(text, line);) {
        lines.push_back(line);
    }
    return lines;
}

RC_GTEST_PROP(DroneCanDecode, AnyFramesAreAccountedForAndSaidAsJsonAndText, ()) {
    std::vector<CanFrame> frames(*rc::gen::inRange<std::size_t>(0, 60));
    std::generate(frames.begin(), frames.end(), any_frame);
    const Recording recording =
        recording_of(frames, std::chrono::milliseconds(*rc::gen::element(1, 300, 1500)));
    const auto lines = lines_of(recording, DecodeFormat::json);
    std::uint64_t rejected = 0;
    std::uint64_t whole = 0;
    for (std::size_t at = 0; at + 1 < lines.size(); ++at) {
        const auto object = nlohmann::json::parse(lines[at]);
        (object.contains("broken") ? rejected : whole) += 1;
    }
    RC_ASSERT(!lines.empty());
    const auto summary = nlohmann::json::parse(lines.back()).at("summary");
    RC_ASSERT(summary.at("can_frames") == frames.size());
    RC_ASSERT(summary.at("frames") == whole);
    std::uint64_t told = 0;
    for (const auto& [reason, count] : summary.at("rejected").items()) {
        told += count.get<std::uint64_t>();
    }
    RC_ASSERT(told == rejected);
    RC_ASSERT(lines_of(recording, DecodeFormat::text).size() > 1U);
    RC_ASSERT(lines_of(recording, DecodeFormat::csv).size() == lines.size());
}

/// Returns successive transfers of one sender and type.
std::vector<CanFrame> some_transfers(std::size_t transfers, std::vector<TransferHead>& heads) {
    std::vector<CanFrame> frames;
    TransferHead head = {.data_type_id = 1140, .source = 9, .priority = 8, .transfer_id = 0};
    for (std::size_t each = 0; each < transfers; ++each) {
        // An RCInput whose channels are 0 us: its bytes are zeros.
        const std::vector<std::uint8_t> payload(4 + 3 * *rc::gen::inRange<std::size_t>(2, 16));
        std::array<CanFrame, 16> room;
        const std::size_t count = dronecan::encode_transfer(
            head, dronecan::find_known_payload(head.kind, 1140)->type.signature, payload, false,
            room);
        frames.insert(frames.end(), room.begin(), room.begin() + static_cast<int>(count));
        heads.push_back(head);
        head.transfer_id = (head.transfer_id + 1U) & dronecan::kMostTransferId;
    }
    return frames;
}

RC_GTEST_PROP(DroneCanDecode, WhereOneFrameIsLostOneTransferIsBrokenAndNoneIsUntold, ()) {
    std::vector<TransferHead> heads;
    std::vector<CanFrame> frames = some_transfers(*rc::gen::inRange<std::size_t>(2, 20), heads);
    const auto lost = *rc::gen::inRange<std::size_t>(0, frames.size());
    frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(lost));
    std::vector<TransferHead> whole;
    std::vector<TransferHead> broken;
    DroneCanExplainer explainer([&](const ExplainedTransfer& transfer) {
        (transfer.fault == TransferFault::none ? whole : broken).push_back(transfer.head);
    });
    for (const RecordedCanFrame& frame :
         recording_of(frames, std::chrono::milliseconds(1)).can_frames) {
        explainer.feed(frame);
    }
    explainer.finish();
    RC_ASSERT(broken.size() == 1U);
    RC_ASSERT(whole.size() + 1 == heads.size());
    std::erase(heads, broken.front());
    RC_ASSERT(whole == heads);
}

}  // namespace
}  // namespace tribus::dronecan_decode_property_test
