#include "transports/codecs/native_can/channels_dbc.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <iterator>
#include <string_view>
#include <utility>
#include <vector>

#include "transports/codecs/dbc/statements.h"

namespace tribus {

using namespace can_channels;

namespace {

struct ValueName {
    unsigned raw = 0;
    std::string_view name;
};

struct SignalText {
    std::string name;
    Field field;
    double factor = 1;
    double offset = 0;
    double most = 0;
    std::string_view unit = {};
    std::vector<ValueName> values = {};
};

struct MessageText {
    std::string name;
    std::size_t index = 0;  ///< distance of the frame's id from the base id
    std::vector<SignalText> signals;
};

constexpr std::string_view kNotAvailable = "NotAvailable";
constexpr std::array<std::string_view, kIds> kMessageNames{"RcA", "RcB", "RcC",
                                                           "RcD", "RcE", "RcFd"};
constexpr std::array<std::string_view, kFlagCount> kFlagNames{"Failsafe", "FrameLost", "Dig17",
                                                              "Dig18"};
constexpr unsigned kEighths = Pulse::kEighthsPerMicrosecond;
// Positions in the list of VFrameFormat (docs/protocols/can.md, "DBC files").
constexpr unsigned kStandardFormat = 0;
constexpr unsigned kExtendedFormat = 1;
constexpr unsigned kFdFormats = 14;

SignalText plain(std::string name, Field field) {
    return {.name = std::move(name), .field = field, .most = static_cast<double>(field.most())};
}

SignalText channel(const PulseScale& scale, std::size_t number, Field field) {
    const double factor = static_cast<double>(scale.step_eighths) / kEighths;
    const double offset = static_cast<double>(scale.offset_eighths) / kEighths;
    return {.name = fmt::format("Ch{:02}", number),
            .field = field,
            .factor = factor,
            .offset = offset,
            .most = offset + factor * (scale.not_available - 1),
            .unit = "us",
            .values = {{scale.not_available, kNotAvailable}}};
}

void add_flags(MessageText& message, const std::array<Field, kFlagCount>& fields) {
    for (std::size_t flag = 0; flag < kFlagCount; ++flag) {
        message.signals.push_back(plain(std::string(kFlagNames[flag]), fields[flag]));
    }
}

SignalText link_quality(Field field) {
    return {.name = "LinkQuality",
            .field = field,
            .most = kMostLinkQuality,
            .unit = "%",
            .values = {{kLinkQualityNotAvailable, kNotAvailable}}};
}

SignalText channel_count(Field field) {
    return {.name = "ChannelCount", .field = field, .most = kChannelCount};
}

SignalText source(Field field) {
    SignalText signal = plain("Source", field);
    for (const Source& known : kSources) {
        signal.values.push_back({known.raw, known.name});
    }
    signal.values.push_back({kSourceNotAvailable, kNotAvailable});
    return signal;
}

SignalText age(const AgeScale& scale, Field field) {
    const double factor = scale.step_microseconds / 1000.0;
    return {.name = "Age",
            .field = field,
            .factor = factor,
            .most = factor * (scale.not_available - 1),
            .unit = "ms",
            .values = {{scale.not_available, kNotAvailable}}};
}

MessageText classic_message(std::size_t index) {
    MessageText message{.name = std::string(kMessageNames[index]), .index = index, .signals = {}};
    message.signals.push_back(plain("Crc", kCrc8));
    message.signals.push_back(plain("Cnt", kCounter));
    add_flags(message, kFlags);
    const std::size_t count = index == kTailIndex ? kTailChannels : kChannelsPerQuad;
    for (std::size_t place = 0; place < count; ++place) {
        message.signals.push_back(
            channel(kClassicPulse, index * kChannelsPerQuad + place + 1, classic_channel(place)));
    }
    if (index == kTailIndex) {
        message.signals.push_back(link_quality(kTailLinkQuality));
        message.signals.push_back(channel_count(kTailChannelCount));
        message.signals.push_back(source(kTailSource));
        message.signals.push_back(age(kTailAgeScale, kTailAge));
    }
    return message;
}

MessageText fd_message() {
    MessageText message{
        .name = std::string(kMessageNames[kFdIndex]), .index = kFdIndex, .signals = {}};
    message.signals.push_back(plain("Crc", kFdCrc));
    message.signals.push_back(plain("Cnt", kFdCounter));
    add_flags(message, kFdFlags);
    message.signals.push_back(source(kFdSource));
    message.signals.push_back(channel_count(kFdChannelCount));
    message.signals.push_back(link_quality(kFdLinkQuality));
    message.signals.push_back(age(kFdAgeScale, kFdAge));
    for (std::size_t number = 1; number <= kChannelCount; ++number) {
        message.signals.push_back(channel(kFdPulse, number, fd_channel(number - 1)));
    }
    return message;
}

class ChannelsDbcText {
  public:
    explicit ChannelsDbcText(const CanChannelsFormat& format) : format_(format) {
        for (std::size_t index = 0; index < kFdIndex; ++index) {
            messages_.push_back(classic_message(index));
        }
        messages_.push_back(fd_message());
    }

    std::string write() {
        add("VERSION \"1\"\n\nNS_ :\n\tCM_\n\tBA_DEF_\n\tBA_\n\tVAL_\n\tBA_DEF_DEF_\n\n"
            "BS_:\n\nBU_: RcGateway Consumer\n\n");
        for (const MessageText& message : messages_) {
            add_message(message);
        }
        add_comments();
        add_attributes();
        for (const MessageText& message : messages_) {
            add_value_names(message);
        }
        return std::move(text_);
    }

  private:
    template <class... Values>
    void add(fmt::format_string<Values...> format, Values&&... values) {
        text_ += fmt::format(format, std::forward<Values>(values)...);
    }

    std::uint32_t id_of(const MessageText& message) const {
        return (format_.base_id + static_cast<std::uint32_t>(message.index)) |
               (format_.extended ? kDbcExtendedFlag : 0);
    }

    unsigned frame_format(const MessageText& message) const {
        return (format_.extended ? kExtendedFormat : kStandardFormat) +
               (message.index == kFdIndex ? kFdFormats : 0);
    }

    void add_message(const MessageText& message) {
        add("BO_ {} {}: {} RcGateway\n", id_of(message), message.name,
            message.index == kFdIndex ? kFdLength : kClassicLength);
        for (const SignalText& signal : message.signals) {
            add(" SG_ {}_{} : {}|{}@1+ ({},{}) [{}|{}] \"{}\" Consumer\n", message.name,
                signal.name, signal.field.start, signal.field.width, signal.factor, signal.offset,
                signal.offset, signal.most, signal.unit);
        }
        add("\n");
    }

    void add_comments() {
        add("CM_ \"RC channels on CAN, the native format of tribus. A snapshot of the channels is "
            "either RcA to RcE, in this order, with the same counter, or RcFd; RcE may be "
            "omitted. The CRC is AUTOSAR E2E profile 22 in the 8-byte frames (or profile 1, if "
            "both ends are configured so) and profile 5 in RcFd. Profile 1 and 5: the data id is "
            "RcE2eDataId. Profile 22: the data id list of a message is 16 x (RcE2eDataId - {}) + "
            "counter.\";\n",
            kFirstDataId);
        for (const MessageText& message : messages_) {
            const bool fd = message.index == kFdIndex;
            add("CM_ SG_ {} {}_Crc \"{}\";\n", id_of(message), message.name,
                fd ? "CRC-16 0x1021 of E2E profile 5, over bytes 2 to 47"
                   : "CRC-8 of E2E profile 22 (0x2F) or 1 (0x1D), over bytes 1 to 7");
            add("CM_ SG_ {} {}_Cnt \"{}\";\n", id_of(message), message.name,
                fd ? "Increases by 1 with each snapshot, 0 to 255"
                   : "Increases by 1 with each snapshot, the same in all of its frames: 0 to 15 "
                     "with profile 22, 0 to 14 with profile 1");
            add("CM_ SG_ {} {}_Failsafe \"The RC link is down: the channels are presets or held\""
                ";\n",
                id_of(message), message.name);
            add("CM_ SG_ {} {}_FrameLost \"The channels are old, but the RC link is up\";\n",
                id_of(message), message.name);
        }
    }

    void add_attributes() {
        add("BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\n"
            "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\",\"reserved\","
            "\"J1939PG\",\"reserved\",\"reserved\",\"reserved\",\"reserved\",\"reserved\","
            "\"reserved\",\"reserved\",\"reserved\",\"reserved\",\"reserved\",\"StandardCAN_FD\","
            "\"ExtendedCAN_FD\";\n"
            "BA_DEF_ BO_ \"CANFD_BRS\" ENUM \"0\",\"1\";\n"
            "BA_DEF_ BO_ \"RcE2eDataId\" INT 0 65535;\n"
            "BA_DEF_ \"BusType\" STRING ;\n"
            "BA_DEF_DEF_ \"GenMsgCycleTime\" 0;\n"
            "BA_DEF_DEF_ \"VFrameFormat\" \"StandardCAN\";\n"
            "BA_DEF_DEF_ \"CANFD_BRS\" \"1\";\n"
            "BA_DEF_DEF_ \"RcE2eDataId\" 0;\n"
            "BA_DEF_DEF_ \"BusType\" \"CAN\";\n"
            "BA_ \"BusType\" \"CAN FD\";\n");
        for (const MessageText& message : messages_) {
            add("BA_ \"GenMsgCycleTime\" BO_ {} {};\n", id_of(message), kDefaultPeriodMilliseconds);
        }
        for (const MessageText& message : messages_) {
            add("BA_ \"RcE2eDataId\" BO_ {} {};\n", id_of(message), kFirstDataId + message.index);
        }
        for (const MessageText& message : messages_) {
            if (frame_format(message) != kStandardFormat) {
                add("BA_ \"VFrameFormat\" BO_ {} {};\n", id_of(message), frame_format(message));
            }
        }
    }

    void add_value_names(const MessageText& message) {
        for (const SignalText& signal : message.signals) {
            if (signal.values.empty()) {
                continue;
            }
            add("VAL_ {} {}_{}", id_of(message), message.name, signal.name);
            for (const ValueName& value : signal.values) {
                add(" {} \"{}\"", value.raw, value.name);
            }
            add(" ;\n");
        }
    }

    CanChannelsFormat format_;
    std::vector<MessageText> messages_;
    std::string text_;
};

}  // namespace

std::string native_dbc(const CanChannelsFormat& format) {
    return ChannelsDbcText(format).write();
}

}  // namespace tribus
