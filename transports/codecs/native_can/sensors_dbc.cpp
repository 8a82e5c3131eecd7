#include "transports/codecs/native_can/sensors_dbc.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "transports/codecs/dbc/statements.h"

namespace tribus {

using namespace sensor_can;

namespace {

constexpr unsigned kRawBit = kRawByte * 8;
constexpr unsigned kRawBits = 32;

struct PageSignal {
    std::string name;
    const SensorType* type = nullptr;
    const SensorField* field = nullptr;
    unsigned first_bit = 0;
    unsigned bits = 0;
};

bool fits(const SensorType& type) {
    return std::ranges::all_of(type.fields, [](const SensorField& field) {
        return field.first_bit + field.bits <= kRawBits;
    });
}

/// A field that is the whole value takes all bits of the raw value, so that it is read correctly
/// whatever size the sensor reports.
std::vector<PageSignal> page_signals(const SensorTypes& types) {
    std::vector<PageSignal> signals;
    for (const SensorType& type : types.all()) {
        // The user's own types come first and replace others.
        if (!fits(type) || types.find(type.id) != &type) {
            continue;
        }
        for (const SensorField& field : type.fields) {
            const bool sole = field.first_bit == 0 && field.bits == type.size * 8U;
            signals.push_back(
                {.name = type.fields.size() == 1 ? type.name : type.name + "_" + field.name,
                 .type = &type,
                 .field = &field,
                 .first_bit = kRawBit + (sole ? 0 : field.first_bit),
                 .bits = sole ? kRawBits : field.bits});
        }
    }
    return signals;
}

/// The range of raw values that are numbers, without a "not available" at either end.
std::pair<std::int64_t, std::int64_t> raw_range(const SensorField& field) {
    const std::int64_t values = std::int64_t{1} << field.bits;
    std::int64_t least = field.least.value_or(field.is_signed ? -values / 2 : 0);
    std::int64_t most = least + values - 1;
    least += field.not_available == least ? 1 : 0;
    most -= field.not_available == most ? 1 : 0;
    return {least, most};
}

class SensorsDbcText {
  public:
    SensorsDbcText(const SensorCanFormat& format, const SensorTypes& types)
        : format_(format), types_(types), pages_(page_signals(types)) {}

    std::string write() {
        add("VERSION \"1\"\n\nNS_ :\n\tCM_\n\tBA_DEF_\n\tBA_\n\tVAL_\n\tBA_DEF_DEF_\n\n"
            "BS_:\n\nBU_: SensorGateway Consumer\n\n");
        for (std::size_t address = 1; address <= kMostSensors; ++address) {
            add_message(address);
        }
        add("CM_ \"The readings of an i.Bus sensor bus, a message for each address, with the raw "
            "value that the sensor sent. The type gives its meaning. A reading is valid while "
            "available is 1.\";\n");
        add_attributes();
        for (std::size_t address = 1; address <= kMostSensors; ++address) {
            add_value_names(address);
        }
        return std::move(text_);
    }

  private:
    template <class... Values>
    void add(fmt::format_string<Values...> format, Values&&... values) {
        text_ += fmt::format(format, std::forward<Values>(values)...);
    }

    std::uint32_t id_of(std::size_t address) const {
        return (format_.base_id + static_cast<std::uint32_t>(address - 1)) |
               (format_.extended ? kDbcExtendedFlag : 0);
    }

    void add_message(std::size_t address) {
        add("BO_ {} Sensor{}: {} SensorGateway\n", id_of(address), address, kMostClassicBytes);
        add(" SG_ type M : {}|8@1+ (1,0) [0|255] \"\" Consumer\n", kTypeByte * 8);
        add(" SG_ available : {}|1@1+ (1,0) [0|1] \"\" Consumer\n", kStateByte * 8);
        add(" SG_ counter : {}|4@1+ (1,0) [0|{}] \"\" Consumer\n", kStateByte * 8 + kCounterShift,
            kMostCounter);
        add(" SG_ age : {}|16@1+ (1,0) [0|65535] \"ms\" Consumer\n", kAgeByte * 8);
        for (const PageSignal& signal : pages_) {
            add_page_signal(signal);
        }
        add("\n");
    }

    void add_page_signal(const PageSignal& signal) {
        const SensorField& field = *signal.field;
        const auto [least, most] = raw_range(field);
        const auto number = [&](std::int64_t raw) {
            return static_cast<double>(raw) * field.scale + field.offset;
        };
        add(" SG_ {} m{} : {}|{}@1{} ({:.12g},{:.12g}) [{:.12g}|{:.12g}] \"{}\" Consumer\n",
            signal.name, signal.type->id, signal.first_bit, signal.bits,
            field.is_signed ? '-' : '+', field.scale, field.offset,
            std::min(number(least), number(most)), std::max(number(least), number(most)),
            field.unit);
    }

    void add_attributes() {
        add("BA_DEF_ BO_ \"GenMsgCycleTime\" INT 0 65535;\n"
            "BA_DEF_ BO_ \"VFrameFormat\" ENUM \"StandardCAN\",\"ExtendedCAN\";\n"
            "BA_DEF_ \"BusType\" STRING ;\n"
            "BA_DEF_DEF_ \"GenMsgCycleTime\" {};\n"
            "BA_DEF_DEF_ \"VFrameFormat\" \"{}\";\n"
            "BA_DEF_DEF_ \"BusType\" \"CAN\";\n",
            std::chrono::duration_cast<std::chrono::milliseconds>(kDefaultPeriod).count(),
            format_.extended ? "ExtendedCAN" : "StandardCAN");
    }

    void add_value_names(std::size_t address) {
        add("VAL_ {} type", id_of(address));
        for (const SensorType& type : types_.all()) {
            if (types_.find(type.id) == &type) {
                add(" {} \"{}\"", type.id, type.name);
            }
        }
        add(" ;\n");
        for (const PageSignal& signal : pages_) {
            if (const auto none = signal.field->not_available) {
                add("VAL_ {} {} {} \"NotAvailable\" ;\n", id_of(address), signal.name, *none);
            }
        }
    }

    const SensorCanFormat& format_;
    const SensorTypes& types_;
    std::vector<PageSignal> pages_;
    std::string text_;
};

}  // namespace

std::string sensor_can_dbc(const SensorCanFormat& format, const SensorTypes& types) {
    return SensorsDbcText(format, types).write();
}

}  // namespace tribus
