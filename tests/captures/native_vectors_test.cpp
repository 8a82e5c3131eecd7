#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iomanip>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/can_snapshots.h"
#include "tests/support/streams.h"
#include "tests/support/vectors.h"
#include "transports/codecs/e2e.h"
#include "transports/codecs/native_can/channels.h"

/// Published frames of the native format and of AUTOSAR's profiles. cantools decoded the values in
/// them (README of the recordings).
namespace tribus::native_vectors_test {
namespace {

using nlohmann::json;
using namespace can_channels;
using test::Bytes;

class NativeVectors : public testing::Test {
  protected:
    void SetUp() override {
        dbc_ = test::vectors("dbc_vectors.json");
        e2e_ = test::vectors("e2e_vectors.json");
    }

    json dbc_;
    json e2e_;
};

Bytes bytes_in(const json& hex) {
    return test::from_hex(hex.get<std::string>());
}

std::size_t index_of(const json& vector) {
    return vector["frame_id"].get<std::size_t>() - 0x300;
}

double value(const json& vector, const std::string& signal) {
    return vector["phys"].at(vector["message"].get<std::string>() + "_" + signal).get<double>();
}

std::string channel_name(std::size_t number) {
    std::ostringstream name;
    name << "Ch" << std::setw(2) << std::setfill('0') << number;
    return name.str();
}

CanChannelsStatus status_in(const json& vector) {
    return {.counter = static_cast<std::uint8_t>(value(vector, "Cnt")),
            .failsafe = value(vector, "Failsafe") != 0,
            .frame_lost = value(vector, "FrameLost") != 0,
            .digital_17 = value(vector, "Dig17") != 0,
            .digital_18 = value(vector, "Dig18") != 0};
}

CanChannelsOrigin origin_in(const json& vector, double age_step) {
    return {.link_quality = static_cast<std::uint8_t>(value(vector, "LinkQuality")),
            .channel_count = static_cast<std::uint8_t>(value(vector, "ChannelCount")),
            .source = static_cast<std::uint8_t>(value(vector, "Source")),
            .age = static_cast<std::uint16_t>(value(vector, "Age") / age_step + 0.5)};
}

/// Returns the raw value on the wire for the microseconds that a DBC states. A DBC does not know
/// "not available".
std::uint16_t raw_in(const json& vector, const PulseScale& scale, std::size_t number) {
    const double offset = scale.offset_eighths / 8.0;
    const double raw = (value(vector, channel_name(number)) - offset) * 8 / scale.step_eighths;
    return static_cast<std::uint16_t>(raw);
}

/// Writes the frame from its values, reads it again and compares the two.
template <class View, class Parse>
Bytes rewritten(const View& view, const CanChannelsFormat& format, const json& vector,
                Parse parse) {
    Bytes payload(vector["data"].get<std::string>().size() / 2);
    emit_can(view, payload);
    write_can_channels_crc(format, index_of(vector), payload);
    const View back = parse(payload);
    EXPECT_EQ(back.status, view.status);
    EXPECT_EQ(back.raw, view.raw);
    return payload;
}

Bytes rewritten(const json& vector, const CanChannelsFormat& format) {
    const std::size_t index = index_of(vector);
    const auto fill = [&](auto& raw, const PulseScale& scale, std::size_t first) {
        for (std::size_t place = 0; place < raw.size(); ++place) {
            raw[place] = raw_in(vector, scale, first + place + 1);
        }
    };
    if (index < kTailIndex) {
        CanChannelsQuad quad{.status = status_in(vector)};
        fill(quad.raw, kClassicPulse, index * kChannelsPerQuad);
        return rewritten(quad, format, vector, parse_can_quad);
    }
    if (index == kTailIndex) {
        CanChannelsTail tail{.status = status_in(vector), .origin = origin_in(vector, 0.25)};
        fill(tail.raw, kClassicPulse, kQuadChannels);
        EXPECT_EQ(parse_can_tail(bytes_in(vector["data"])).origin, tail.origin);
        return rewritten(tail, format, vector, parse_can_tail);
    }
    CanChannelsFd frame{.status = status_in(vector), .origin = origin_in(vector, 0.01)};
    fill(frame.raw, kFdPulse, 0);
    EXPECT_EQ(parse_can_fd(bytes_in(vector["data"])).origin, frame.origin);
    return rewritten(frame, format, vector, parse_can_fd);
}

TEST_F(NativeVectors, AreWhatTheSameValuesGive) {
    ASSERT_EQ(dbc_["native_vectors"].size(), 36U);
    for (const json& vector : dbc_["native_vectors"]) {
        const CanChannelsFormat p01{.crc = CanChannelsCrc::p01};
        EXPECT_EQ(rewritten(vector, p01), bytes_in(vector["data"])) << vector;
        if (!vector["fd"]) {
            EXPECT_EQ(rewritten(vector, {}), bytes_in(vector["data_with_p22_crc"])) << vector;
        }
    }
}

TEST_F(NativeVectors, HaveTheDataIdsOfTheFormat) {
    for (const json& vector : dbc_["native_vectors"]) {
        EXPECT_EQ(vector["data_id"].get<std::size_t>(), kFirstDataId + index_of(vector));
    }
}

/// Returns the frames of one snapshot, with another counter and new CRCs.
test::CanFrames snapshot_frames(const json& vectors, std::size_t first, bool fd, unsigned counter) {
    test::CanFrames frames;
    for (std::size_t at = first; at < first + kIds; ++at) {
        const json& vector = vectors[at];
        if (vector["fd"] != fd) {
            continue;
        }
        const Bytes data = bytes_in(vector[fd ? "data" : "data_with_p22_crc"]);
        CanFrame frame{.id = vector["frame_id"],
                       .fd = fd,
                       .bit_rate_switch = fd,
                       .length = static_cast<std::uint8_t>(data.size())};
        std::ranges::copy(data, frame.data.begin());
        const Field counter_field = fd ? kFdCounter : kCounter;
        const unsigned own = get(frame.bytes(), counter_field);
        // Clears the CRC and the counter before new ones are written.
        frame.data[0] = 0;
        frame.data[1] &= fd ? 0x00 : 0xF0;
        frame.data[2] = fd ? std::uint8_t{0} : frame.data[2];
        put(frame.bytes(), counter_field, (own + counter) % (fd ? 256U : 16U));
        write_can_channels_crc({.fd = fd}, index_of(vector), frame.bytes());
        frames.push_back(frame);
    }
    return frames;
}

/// Checks the third of three like snapshots: the first two prove the sender.
void expect_decoded(const json& vectors, std::size_t first, bool fd) {
    CanChannelsDecoder decoder({.fd = fd});
    std::vector<ChannelFrame> published;
    const unsigned values = fd ? 256 : 16;
    for (const unsigned counter : {values - 2, values - 1, 0U}) {
        published = test::feed(decoder, snapshot_frames(vectors, first, fd, counter),
                               test::can_time((counter + 2) % values * test::kCanPeriod));
    }
    ASSERT_EQ(published.size(), 1U) << "snapshot at vector " << first;
    const std::uint16_t absent = fd ? 0xFFFF : 0xFFF;
    const PulseScale& scale = fd ? kFdPulse : kClassicPulse;
    for (std::size_t at = first; at < first + kIds; ++at) {
        const json& vector = vectors[at];
        for (std::size_t number = 1; vector["fd"] == fd && number <= kChannelCount; ++number) {
            const std::string signal =
                vector["message"].get<std::string>() + "_" + channel_name(number);
            if (!vector["phys"].contains(signal)) {
                continue;
            }
            const auto channel = published[0].channel(number - 1);
            EXPECT_EQ(channel.has_value(), raw_in(vector, scale, number) != absent) << signal;
            EXPECT_EQ(channel ? channel->microseconds() : value(vector, channel_name(number)),
                      value(vector, channel_name(number)));
        }
        if (vector["fd"] == fd) {
            EXPECT_EQ(published[0].failsafe, value(vector, "Failsafe") != 0);
            EXPECT_EQ(published[0].frame_lost, value(vector, "FrameLost") != 0);
        }
    }
}

TEST_F(NativeVectors, DecodeToTheirValues) {
    const json& vectors = dbc_["native_vectors"];
    for (std::size_t first = 0; first < vectors.size(); first += kIds) {
        expect_decoded(vectors, first, false);
        expect_decoded(vectors, first, true);
    }
}

std::uint16_t number_in(const json& hex) {
    return static_cast<std::uint16_t>(std::stoul(hex.get<std::string>(), nullptr, 16));
}

TEST_F(NativeVectors, ProfilesGiveTheirExamples) {
    constexpr std::array<std::string_view, 4> kModes{"BOTH", "ALT", "LOW", "NIBBLE"};
    for (const json& vector : e2e_["p01"]) {
        const auto* mode = std::ranges::find(kModes, vector["mode"].get<std::string>());
        ASSERT_NE(mode, kModes.end());
        const Bytes payload = bytes_in(vector["payload"]);
        EXPECT_EQ(p01_crc(payload, number_in(vector["data_id"]),
                          static_cast<P01DataId>(mode - kModes.begin())),
                  payload[0])
            << vector;
    }
    for (const json& vector : e2e_["p22"]) {
        const Bytes payload = bytes_in(vector["payload"]);
        const Bytes list = bytes_in(vector["data_id_list"]);
        EXPECT_EQ(p22_crc(payload, list.at(vector["counter"])), payload[0]) << vector;
    }
    for (const json& vector : e2e_["p05"]) {
        const Bytes payload = bytes_in(vector["payload"]);
        const std::size_t offset = vector["offset_bytes"];
        EXPECT_EQ(p05_crc(payload, number_in(vector["data_id"]), offset),
                  payload[offset] | payload[offset + 1] << 8)
            << vector;
    }
}

}  // namespace
}  // namespace tribus::native_vectors_test
