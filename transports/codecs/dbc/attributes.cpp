#include "transports/codecs/dbc/attributes.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace tribus {
namespace {

using Result = tl::expected<void, DbcMistake>;

/// Values of VFrameFormat (docs/protocols/can.md, "DBC files").
constexpr unsigned kJ1939 = 3;
constexpr unsigned kStandardFd = 14;
constexpr unsigned kExtendedFd = 15;

struct FormatName {
    std::string_view name;
    unsigned format;
};
constexpr std::array<FormatName, 5> kFormatNames{{
    {"StandardCAN", 0},
    {"ExtendedCAN", 1},
    {"J1939PG", kJ1939},
    {"StandardCAN_FD", kStandardFd},
    {"ExtendedCAN_FD", kExtendedFd},
}};

constexpr unsigned kLongestClassic = 8;
constexpr std::array<unsigned, 7> kLongerFdLengths{12, 16, 20, 24, 32, 48, 64};

std::optional<double> number_in(std::string_view text) {
    double value = 0;
    const char* const end = text.data() + text.size();
    const auto [stop, error] = std::from_chars(text.data(), end, value);
    const bool whole_text = error == std::errc{} && stop == end;
    return whole_text && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

/// The text of an ENUM value that the file gives as text or index; any other value as it is.
std::string chosen_text(const DbcAttributeValue& value, const std::vector<std::string>& choices) {
    const auto index = number_in(value.text);
    if (!value.quoted && index && *index >= 0 && *index < static_cast<double>(choices.size())) {
        return choices[static_cast<std::size_t>(*index)];
    }
    return value.text;
}

/// Compares names first, so that a list in another order is read correctly.
std::optional<unsigned> frame_format(const DbcAttributeValue& value,
                                     const std::vector<std::string>& choices) {
    const std::string text = chosen_text(value, choices);
    for (const FormatName& known : kFormatNames) {
        if (text == known.name) {
            return known.format;
        }
    }
    const auto number = number_in(value.text);
    if (!number || *number < 0 || *number > double{kExtendedFd}) {
        return std::nullopt;
    }
    return static_cast<unsigned>(*number);
}

class AttributesOfMessage {
  public:
    AttributesOfMessage(const std::vector<DbcAttributeDefinition>& definitions,
                        const DbcMessageAttributes& own, DbcMessage& message)
        : definitions_(definitions), own_(own), message_(message) {}

    void apply_frame_kind();
    Result check_length(DbcPlace place) const;
    Result apply_cycle_time();
    Result apply_data_id();

  private:
    const DbcAttributeValue* own(DbcAttribute attribute) const {
        return own_[static_cast<std::size_t>(attribute)];
    }
    const DbcAttributeDefinition& definition(DbcAttribute attribute) const {
        return definitions_[static_cast<std::size_t>(attribute)];
    }
    /// The message's own value, else the default of all messages, else nullptr.
    const DbcAttributeValue* value(DbcAttribute attribute) const {
        const auto& by_default = definition(attribute).by_default;
        return own(attribute) != nullptr ? own(attribute) : by_default ? &*by_default : nullptr;
    }

    const std::vector<DbcAttributeDefinition>& definitions_;
    const DbcMessageAttributes& own_;
    DbcMessage& message_;
};

void AttributesOfMessage::apply_frame_kind() {
    std::optional<unsigned> format;
    if (const auto* const given = value(DbcAttribute::frame_format); given != nullptr) {
        format = frame_format(*given, definition(DbcAttribute::frame_format).choices);
    }
    const bool longer = message_.length > kLongestClassic;
    message_.j1939 = format == kJ1939;
    message_.multi_packet = message_.j1939 && longer;
    message_.fd = !message_.j1939 && (longer || format == kStandardFd || format == kExtendedFd);
    const auto* const switched = value(DbcAttribute::bit_rate_switch);
    message_.bit_rate_switch =
        message_.fd && switched != nullptr &&
        chosen_text(*switched, definition(DbcAttribute::bit_rate_switch).choices) == "1";
}

Result AttributesOfMessage::check_length(DbcPlace place) const {
    const unsigned length = message_.length;
    const bool one_frame = length <= kLongestClassic ||
                           std::find(kLongerFdLengths.begin(), kLongerFdLengths.end(), length) !=
                               kLongerFdLengths.end();
    if (one_frame || message_.multi_packet) {
        return {};
    }
    return dbc_mistake(place,
                       "message " + message_.name + " has " + std::to_string(length) +
                           " bytes; a CAN frame has 0 to 8, with FD also 12, 16, 20, 24, 32, "
                           "48 or 64");
}

Result AttributesOfMessage::apply_cycle_time() {
    constexpr double kLongest = 1e9;
    const auto* const given = value(DbcAttribute::cycle_time);
    if (given == nullptr) {
        return {};
    }
    const auto milliseconds = number_in(given->text);
    if (!milliseconds || *milliseconds > kLongest) {
        return dbc_mistake(given->place,
                           "GenMsgCycleTime of message " + message_.name + " is '" + given->text +
                               "'; it is a number of milliseconds, at most 1000000000");
    }
    // Some tools write -1 for "not cyclic".
    if (*milliseconds > 0) {
        constexpr double kNanosecondsPerMillisecond = 1e6;
        message_.cycle_time = Duration(std::llround(*milliseconds * kNanosecondsPerMillisecond));
    }
    return {};
}

Result AttributesOfMessage::apply_data_id() {
    constexpr double kLast = 0xFFFFFFFFU;
    const auto* const given = value(DbcAttribute::e2e_data_id);
    if (given == nullptr) {
        return {};
    }
    const auto number = number_in(given->text);
    if (!number || *number < 0 || *number > kLast || *number != std::trunc(*number)) {
        return dbc_mistake(given->place, "RcE2eDataId of message " + message_.name + " is '" +
                                             given->text +
                                             "'; it is a whole number from 0 to 4294967295");
    }
    if (own(DbcAttribute::e2e_data_id) != nullptr || *number != 0) {
        message_.e2e_data_id = static_cast<std::uint32_t>(*number);
    }
    return {};
}

}  // namespace

tl::expected<void, DbcMistake> apply_dbc_attributes(
    const std::vector<DbcAttributeDefinition>& definitions, const DbcMessageAttributes& own,
    DbcPlace length_place, DbcMessage& message) {
    AttributesOfMessage attributes(definitions, own, message);
    attributes.apply_frame_kind();
    return attributes.check_length(length_place)
        .and_then([&] { return attributes.apply_cycle_time(); })
        .and_then([&] { return attributes.apply_data_id(); });
}

}  // namespace tribus
