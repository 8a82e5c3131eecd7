#include <memory>
#include <vector>

#include "tests/fuzz/fuzz.h"
#include "transports/codecs/ibus_sensor.h"
#include "transports/registry/registry.h"

namespace tribus::fuzz {
namespace {

/// The serial protocols that can be read.
std::vector<const Protocol*> readable() {
    std::vector<const Protocol*> found;
    for (const Protocol* protocol : protocols()) {
        if (protocol->make_decoder != nullptr) {
            found.push_back(protocol);
        }
    }
    return found;
}

/// Settings as the command line's defaults have them, or another choice where there are some.
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

/// In pieces of at most that many bytes.
Found decode(Decoder& decoder, std::span<const std::uint8_t> bytes, std::size_t piece) {
    Found found;
    while (!bytes.empty()) {
        std::span<const std::uint8_t> read = bytes.first(std::min(piece, bytes.size()));
        bytes = bytes.subspan(read.size());
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
}  // namespace tribus::fuzz

/// Bytes of a wire: the same frames come out however reads cut them, each within what came, none
/// over another.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace tribus::fuzz;
    Input input({data, size});
    static const auto protocols = readable();
    const std::size_t which = input.below(protocols.size() + 1);
    const std::size_t piece = 1 + input.byte();
    if (which == protocols.size()) {
        decode_sensor_frames(input.rest(), piece);
        return 0;
    }
    const auto& protocol = *protocols[which];
    const auto settings = settings_of(protocol, input);
    const auto bytes = input.rest();
    const auto whole = decode(*protocol.make_decoder(settings), bytes, bytes.size());
    const auto pieces = decode(*protocol.make_decoder(settings), bytes, piece);
    require_places(whole, bytes.size());
    require(whole == pieces, "how reads cut a stream changes nothing");
    return 0;
}
