#include <memory>
#include <vector>

#include "tests/fuzz/fuzz.h"
#include "tests/support/ibus_checksum.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/registry/registry.h"

namespace tribus::fuzz::serial_decoders_target {
namespace {

/// Returns the serial protocols that can be read.
std::vector<const Protocol*> readable() {
    std::vector<const Protocol*> found;
    for (const Protocol* protocol : protocols()) {
        if (protocol->shape == WireShape::bytes && protocol->make_decoder != nullptr) {
            found.push_back(protocol);
        }
    }
    return found;
}

/// Returns the default settings of the command line, or other choices where there are some.
SettingValues settings_of(const Protocol& protocol, Input& input) {
    SettingValues values;
    for (const Setting& setting : protocol.settings) {
        if (setting.type == SettingType::choice && !setting.choices.empty() &&
            input.below(2) == 1) {
            values.set(setting.key,
                       std::string(setting.choices[input.below(setting.choices.size())]));
        }
    }
    return values;
}

struct Found {
    std::vector<DecodedFrame> frames;
    std::uint64_t skipped = 0;

    bool operator==(const Found& other) const {
        return skipped == other.skipped &&
               std::ranges::equal(frames, other.frames, [](const auto& a, const auto& b) {
                   return a.first_byte == b.first_byte && a.length == b.length &&
                          a.channels.same_content(b.channels);
               });
    }
};

/// Bytes of a wire, and which of them came with a parity or framing error.
struct Line {
    std::vector<std::uint8_t> bytes;
    std::vector<bool> damaged;
};

/// Decodes in pieces of at most `piece` bytes.
Found decode(ByteDecoder& decoder, const Line& line, std::size_t piece) {
    Found found;
    for (std::size_t at = 0; at < line.bytes.size();) {
        if (line.damaged[at]) {
            decoder.damaged_byte();
            ++at;
            continue;
        }
        std::size_t end = at + 1;
        while (end < line.bytes.size() && end - at < piece && !line.damaged[end]) {
            ++end;
        }
        auto read = std::span<const std::uint8_t>(line.bytes).subspan(at, end - at);
        at = end;
        DecodedFrame frame;
        while (decoder.next(read, {}, frame)) {
            found.frames.push_back(frame);
        }
        require(read.empty(), "a decoder that returns nothing has taken all bytes");
    }
    if (const auto last = decoder.finish()) {
        found.frames.push_back(*last);
    }
    found.skipped = decoder.skipped_bytes();
    return found;
}

void require_places(const Found& found, std::size_t size) {
    std::uint64_t end = 0;
    for (const DecodedFrame& frame : found.frames) {
        require(frame.length > 0, "a frame has bytes");
        require(frame.first_byte >= end, "frames do not overlap and come in order");
        end = frame.first_byte + frame.length;
        require(end <= size, "a frame lies within what was received");
    }
    require(found.skipped <= size, "no more was skipped than received");
}

/// No random input has the right checksum, so checksums are put where the bytes before can be a
/// frame.
void put_checksums(std::vector<std::uint8_t>& bytes, bool sensors) {
    const auto length_at = [&](std::size_t at) -> std::size_t {
        const std::size_t first = bytes[at];
        if (sensors) {
            return first == 4 || first == 6 || first == 8 ? first : 0;
        }
        return first == 0x20 && at + 1 < bytes.size() && bytes[at + 1] == 0x40 ? first : 0;
    };
    for (std::size_t at = 0; at < bytes.size();) {
        const std::size_t length = length_at(at);
        if (length == 0 || at + length > bytes.size()) {
            ++at;
            continue;
        }
        const unsigned sum = test::ibus_checksum(std::span(bytes).subspan(at, length - 2));
        bytes[at + length - 2] = static_cast<std::uint8_t>(sum);
        bytes[at + length - 1] = static_cast<std::uint8_t>(sum >> 8U);
        at += length;
    }
}

/// Returns the rest of the input, with checksums or without, and up to three damaged bytes.
Line line_from(Input& input, bool sensors) {
    const std::uint8_t choice = input.byte();
    std::vector<std::size_t> places(choice / 2 % 4);
    for (std::size_t& place : places) {
        place = input.byte();
    }
    const auto rest = input.rest();
    Line line{.bytes = {rest.begin(), rest.end()}, .damaged = std::vector<bool>(rest.size())};
    for (const std::size_t place : places) {
        if (place < rest.size()) {
            line.damaged[place] = true;
        }
    }
    if (choice % 2 == 1) {
        put_checksums(line.bytes, sensors);
    }
    return line;
}

void decode_sensor_frames(std::span<const std::uint8_t> bytes, std::size_t piece) {
    SensorFrameParser parser;
    std::uint64_t end = 0;
    const std::size_t size = bytes.size();
    while (!bytes.empty()) {
        std::span<const std::uint8_t> read = bytes.first(std::min(piece, bytes.size()));
        bytes = bytes.subspan(read.size());
        while (const auto frame = parser.next(read, {})) {
            require(frame->first_byte >= end, "frames of a sensor bus come in order");
            require(frame->data_size <= kMostSensorData, "a value fits");
            end = frame->first_byte + 1;
        }
        require(read.empty(), "a parser that returns nothing has taken all bytes");
    }
    require(end <= size && parser.skipped_bytes() <= size,
            "positions are within what was received");
}

}  // namespace

/// Bytes of a wire: the same frames come out however reads cut them. Each frame is within the
/// received bytes, and no two overlap.
FUZZ_TARGET(serial_decoders) {
    Input input({data, size});
    static const auto protocols = readable();
    const std::size_t which = input.below(protocols.size() + 1);
    const std::size_t piece = 1 + input.byte();
    if (which == protocols.size()) {
        decode_sensor_frames(line_from(input, true).bytes, piece);
        return 0;
    }
    const auto& protocol = *protocols[which];
    const auto settings = settings_of(protocol, input);
    const Line line = line_from(input, false);
    const auto whole = decode(*make_byte_decoder(protocol, settings), line, line.bytes.size());
    const auto pieces = decode(*make_byte_decoder(protocol, settings), line, piece);
    require_places(whole, line.bytes.size());
    require(whole == pieces, "how reads cut a stream changes nothing");
    return 0;
}

}  // namespace tribus::fuzz::serial_decoders_target
