#include "app/wire/dronecan/dronecan_fields.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <type_traits>
#include <utility>
#include <variant>

#include "transports/codecs/dronecan/payload.h"
#include "transports/codecs/dronecan/types_command.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;

/// The shortest decimal number that stands for the same float.
OrderedJson as_json(double value) {
    return std::isnan(value) ? OrderedJson()
                             : OrderedJson(std::stod(fmt::format("{}", float(value))));
}
OrderedJson as_json(std::span<const std::uint8_t> bytes) {
    return fmt::format("{:02x}", fmt::join(bytes, ""));
}
OrderedJson as_json(dronecan::NoItems) {
    return OrderedJson::array();
}
template <class Value>
OrderedJson as_json(const Value& value) {
    return value;
}

std::size_t leading_number(std::string_view digits) {
    std::size_t number = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), number);
    return number;
}

/// The place of a path in the tree, such as `commands[2].actuator_id`.
OrderedJson& place_of(std::string_view path, OrderedJson& root) {
    OrderedJson* at = &root;
    while (!path.empty()) {
        const std::size_t end = path.find_first_of(".[", 1);
        const std::string_view step = path.substr(0, end);
        if (step.front() == '[') {
            at = &(*at)[leading_number(step.substr(1))];
        } else {
            at = &(*at)[std::string(step.substr(step.front() == '.' ? 1 : 0))];
        }
        path = end == std::string_view::npos ? std::string_view() : path.substr(end);
    }
    return *at;
}

std::string without_numbers(std::string_view path) {
    std::string names;
    bool in_number = false;
    for (const char each : path) {
        in_number = each == '[' || (in_number && each != ']');
        if (!in_number && each != ']') {
            names += each;
        }
    }
    return names;
}

/// Text of a tree of values with their units.
class TextOf {
  public:
    explicit TextOf(const OrderedJson& units) : units_(units) {}

    std::string value(const OrderedJson& value, const std::string& path) const {
        if (value.is_object()) {
            return "{" + members(value, path) + "}";
        }
        if (value.is_array()) {
            return items(value, path) + unit(path);
        }
        return scalar(value) + (value.is_null() ? "" : unit(path));
    }
    std::string members(const OrderedJson& object, const std::string& path) const {
        std::string text;
        for (const auto& [name, value] : object.items()) {
            text += text.empty() ? "" : ", ";
            text += name;
            text += ' ';
            text += this->value(value, path.empty() ? name : fmt::format("{}.{}", path, name));
        }
        return text;
    }

  private:
    std::string items(const OrderedJson& array, const std::string& path) const {
        std::string text;
        for (const OrderedJson& item : array) {
            text += text.empty() ? "" : item.is_object() ? ", " : " ";
            text += item.is_object() ? value(item, path) : scalar(item);
        }
        return "[" + text + "]";
    }
    std::string unit(const std::string& path) const {
        const auto found = units_.find(path);
        return found == units_.end() ? "" : " " + found->get<std::string>();
    }
    static std::string scalar(const OrderedJson& value) {
        if (value.is_null()) {
            return "not available";
        }
        return value.is_number_float() ? fmt::format("{}", value.get<double>()) : plain_json(value);
    }

    const OrderedJson& units_;
};

}  // namespace

ExplainedFields fields_of(const ExplainedTransfer& transfer) {
    ExplainedFields fields;
    if (transfer.type == nullptr || transfer.fault != TransferFault::none) {
        return fields;
    }
    transfer.type->visit(transfer.payload, transfer.fd, [&](const dronecan::FieldValue& named) {
        place_of(named.path, fields.values) =
            std::visit([](const auto& value) { return as_json(value); }, named.value);
        if (!named.unit.empty()) {
            fields.units[without_numbers(named.path)] = named.unit;
        }
    });
    return fields;
}

std::optional<RcInputChannels> rc_input_of(const ExplainedTransfer& transfer) {
    using dronecan::RcInput;
    const bool whole = transfer.fault == TransferFault::none && transfer.type != nullptr &&
                       transfer.type->type == dronecan::data_type_of<RcInput>();
    const auto input =
        whole ? dronecan::read<RcInput>(transfer.payload, transfer.fd) : std::nullopt;
    if (!input) {
        return std::nullopt;
    }
    RcInputChannels found;
    found.failsafe = (input->status & RcInput::kFailsafe) != 0;
    const std::size_t count = std::min(input->rcin.size(), found.channels.size());
    std::copy_n(input->rcin.begin(), count, found.channels.begin());
    return found;
}

std::string fields_text(const ExplainedFields& fields) {
    return TextOf(fields.units).members(fields.values, {});
}

std::string plain_json(const nlohmann::ordered_json& value) {
    return value.dump(-1, ' ', true, OrderedJson::error_handler_t::replace);
}

}  // namespace tribus
