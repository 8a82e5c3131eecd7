#include "transports/codecs/dbc/value_reader.h"

#include <algorithm>
#include <cmath>

#include "transports/codecs/dbc/message_map.h"
#include "transports/codecs/dbc/signal_map.h"

namespace tribus {

DbcValueReader::DbcValueReader(const DbcMessage& message)
    : message_(message), wanted_(received_ids(message)) {
    for (const DbcSignal& signal : message_.signals) {
        signals_.push_back({signal.name, signal.unit});
        layouts_.emplace_back(signal);
        most_bits_.push_back(message_.j1939 ? most_j1939_bits(signal) : std::nullopt);
    }
}

std::optional<Instant> DbcValueReader::take(const CanFrame& frame, Instant at,
                                            std::span<ValueReading> readings) {
    if (!wanted_.matches(frame)) {
        return std::nullopt;
    }
    if (frame.remote) {
        ++rejected_[kRemote].count;
        return std::nullopt;
    }
    if (frame.length < message_.length || frame.fd != message_.fd) {
        ++rejected_[kLength].count;
        return std::nullopt;
    }
    for (std::size_t signal = 0; signal < layouts_.size(); ++signal) {
        readings[signal] = read(signal, frame.bytes());
    }
    return at;
}

ValueReading DbcValueReader::read(std::size_t signal, std::span<const std::uint8_t> data) const {
    if (!present(message_, message_.signals[signal], data)) {
        return {};
    }
    const std::uint64_t bits = layouts_[signal].raw_bits(data);
    const double value = layouts_[signal].physical(bits);
    if (!is_number(signal, bits, value)) {
        return {.state = ValueReading::State::not_available};
    }
    return {.state = ValueReading::State::number, .number = value};
}

bool DbcValueReader::is_number(std::size_t index, std::uint64_t bits, double value) const {
    const DbcSignal& signal = message_.signals[index];
    if (!std::isfinite(value) || (most_bits_[index] && bits > *most_bits_[index])) {
        return false;
    }
    if (!signal.has_range()) {
        return true;
    }
    // Within the rounding of the limits.
    const double allowed = std::clamp(value, signal.minimum, signal.maximum);
    return allowed == value || layouts_[index].bits_from_physical(allowed) == bits;
}

tl::expected<DbcValueReader, std::string> make_dbc_value_reader(const DbcFile& file,
                                                                std::string_view message) {
    const DbcMessage* found = file.find(message);
    if (found == nullptr) {
        return tl::unexpected(no_dbc_message(file, message));
    }
    if (found->multi_packet) {
        return tl::unexpected(
            std::string("the message is longer than a frame; allowed: messages of one frame"));
    }
    return DbcValueReader(*found);
}

}  // namespace tribus
