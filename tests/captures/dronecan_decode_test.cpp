#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "app/cli/exit_status.h"
#include "app/wire/decode_dronecan.h"
#include "tests/support/outcome.h"
#include "tests/support/vectors.h"

/// Output of `decode` for the transfers and receive sequences that three independent
/// implementations agree on (dronecan_vectors.json).
namespace tribus::dronecan_decode_test {
namespace {

using nlohmann::ordered_json;
using test::Outcome;
using test::outcome_of;

std::string log_line(std::int64_t t_us, std::string_view frame) {
    return fmt::format("({}.{:06}) can0 {}\n", t_us / 1'000'000, t_us % 1'000'000, frame);
}

std::string log_of_transfer(const ordered_json& transfer) {
    std::string log;
    std::int64_t t_us = 1'000'000;
    for (const ordered_json& frame : transfer.at("candump")) {
        log += log_line(t_us, frame.get<std::string>());
        t_us += 130;
    }
    return log;
}

std::string log_of_sequence(const ordered_json& sequence) {
    const bool fd = sequence.at("can_fd");
    std::string log;
    for (const ordered_json& frame : sequence.at("frames")) {
        const std::string id = frame.at("can_id").get<std::string>().substr(2);
        const std::string data = frame.at("data");
        log += log_line(frame.at("t_us"), id + (fd ? "##1" : "#") + data);
    }
    return log;
}

Outcome decoded(const std::string& log, DecodeFormat format) {
    const auto recording = parse_recording(log, "vectors.log", RecordingKind::candump);
    EXPECT_TRUE(recording) << recording.error();
    return outcome_of([&](std::ostream& results, std::ostream& messages) {
        TransferDecoding decoding(std::nullopt,
                                  {format, RecordingKind::candump, results, messages});
        RecordingInMemory source(*recording);
        return decode_recording(source, decoding, messages);
    });
}

/// Returns all objects except the summary.
std::vector<ordered_json> transfers_in(const std::string& log) {
    std::vector<ordered_json> found;
    for (const std::string& line : decoded(log, DecodeFormat::json).lines()) {
        found.push_back(ordered_json::parse(line));
    }
    EXPECT_FALSE(found.empty());
    if (!found.empty()) {
        EXPECT_TRUE(found.back().contains("summary"));
        found.pop_back();
    }
    return found;
}

std::string in_lower_case(std::string text) {
    std::ranges::transform(text, text.begin(), [](unsigned char each) {
        return static_cast<char>(std::tolower(each));
    });
    return text;
}

/// Returns a value of the file as `decode` writes it: integers too large for some JSON readers as
/// text ("0xDEADBEEF"), and hex in capital letters.
ordered_json as_written(const std::string& name, const ordered_json& value) {
    if (value.is_object() || value.is_array()) {
        ordered_json written = value;
        for (auto& [inner, item] : written.items()) {
            item = as_written(inner, item);
        }
        return written;
    }
    const std::string text = value.is_string() ? value.get<std::string>() : "";
    if (text.starts_with("0x")) {
        return std::stoull(text, nullptr, 16);
    }
    return value.is_string() && name == "unique_id" ? ordered_json(in_lower_case(text)) : value;
}

std::string scalar_text(const ordered_json& value) {
    return value.is_number_float() ? fmt::format("{}", value.get<double>()) : value.dump();
}

/// Adds every `name value` that the text must have.
void add_named_values(const ordered_json& value, const std::string& name,
                      std::vector<std::string>& named) {
    const bool list = value.is_array() && (value.empty() || !value.front().is_object());
    if (list) {
        std::string items;
        for (const ordered_json& item : value) {
            items += (items.empty() ? "" : " ") + scalar_text(item);
        }
        named.push_back(name + " [" + items + "]");
    } else if (value.is_array() || value.is_object()) {
        for (const auto& [inner, item] : value.items()) {
            add_named_values(item, value.is_array() ? name : inner, named);
        }
    } else {
        named.push_back(name + " " + scalar_text(value));
    }
}

ordered_json node(const ordered_json& id) {
    return id == 0 ? ordered_json() : id;
}

class DroneCanDecodeVectors : public testing::Test {
  protected:
    void SetUp() override { vectors_ = test::vectors<ordered_json>("dronecan_vectors.json"); }

    ordered_json vectors_;
};

TEST_F(DroneCanDecodeVectors, EveryTransferIsOneObjectWithItsHeadAndItsFields) {
    for (const ordered_json& transfer : vectors_.at("transfers")) {
        SCOPED_TRACE(transfer.at("name").get<std::string>());
        const auto found = transfers_in(log_of_transfer(transfer));
        ASSERT_EQ(found.size(), 1U);
        const ordered_json& object = found.front();
        EXPECT_FALSE(object.contains("broken")) << object;
        EXPECT_EQ(object.at("type"), transfer.at("data_type"));
        EXPECT_EQ(object.at("type_id"), transfer.at("data_type_id"));
        EXPECT_EQ(object.at("kind"), transfer.at("transfer_kind"));
        EXPECT_EQ(object.at("source"), node(transfer.at("source_node_id")));
        EXPECT_EQ(object.at("destination"), transfer.at("destination_node_id"));
        EXPECT_EQ(object.at("priority"), transfer.at("priority"));
        EXPECT_EQ(object.at("transfer_id"), transfer.at("transfer_id"));
        EXPECT_EQ(object.at("fd"), transfer.at("can_fd"));
        EXPECT_EQ(object.at("frames"), transfer.at("frames").size());
        EXPECT_EQ(object.at("fields"), as_written("", transfer.at("fields")));
    }
}

TEST_F(DroneCanDecodeVectors, EveryTransferIsOneLineOfTextWithItsTypeAndTheNamesAndValues) {
    for (const ordered_json& transfer : vectors_.at("transfers")) {
        SCOPED_TRACE(transfer.at("name").get<std::string>());
        const Outcome outcome = decoded(log_of_transfer(transfer), DecodeFormat::text);
        EXPECT_EQ(outcome.status, kExitFine);
        ASSERT_GE(outcome.lines().size(), 3U);
        const std::string line = outcome.lines()[1];
        EXPECT_NE(line.find(transfer.at("data_type").get<std::string>()), std::string::npos);
        std::vector<std::string> named;
        add_named_values(as_written("", transfer.at("fields")), "", named);
        for (const std::string& value : named) {
            EXPECT_NE(line.find(value), std::string::npos) << value << " in " << line;
        }
        EXPECT_EQ(outcome.lines()[2].substr(0, 14), "1 transfer in ");
    }
}

using Reasons = std::vector<std::string>;

/// Reasons why transfers of a sequence are refused. In all other sequences every transfer is
/// accepted.
const std::map<std::string, Reasons> kBroken{{"bad_crc_middle", {"bad_crc"}},
                                             {"payload_bit_flip", {"bad_crc"}},
                                             {"missing_second_frame", {"frames_missing"}},
                                             {"missing_first_frame", {"start_missing"}},
                                             {"missing_last_frame", {"broke_off"}},
                                             {"duplicated_whole_transfer", {"repeated"}},
                                             {"duplicated_single_frame", {"repeated"}},
                                             {"stray_end_frame", {"start_missing"}},
                                             {"wrong_type_signature_crc", {"bad_crc"}}};

TEST_F(DroneCanDecodeVectors, ShowTheAcceptedTransfersOfEverySequenceAndAReasonForTheOthers) {
    for (const ordered_json& sequence : vectors_.at("receive_sequences")) {
        const std::string name = sequence.at("name");
        SCOPED_TRACE(name);
        const ordered_json& accepted = sequence.at("accepted_by_spec_pseudocode");
        std::size_t whole = 0;
        Reasons reasons;
        for (const ordered_json& object : transfers_in(log_of_sequence(sequence))) {
            if (object.contains("broken")) {
                reasons.push_back(object.at("broken"));
                continue;
            }
            ASSERT_LT(whole, accepted.size());
            const ordered_json& expected = accepted[whole++];
            EXPECT_EQ(object.at("source"), expected.at("source_node_id"));
            EXPECT_EQ(object.at("transfer_id"), expected.at("transfer_id"));
            EXPECT_EQ(object.at("payload").get<std::string>(),
                      in_lower_case(expected.at("payload_hex")));
            EXPECT_TRUE(object.contains("channels"));
        }
        EXPECT_EQ(whole, accepted.size());
        const auto known = kBroken.find(name);
        EXPECT_EQ(reasons, known == kBroken.end() ? Reasons{} : known->second);
    }
}

}  // namespace
}  // namespace tribus::dronecan_decode_test
