#include "transports/codecs/dbc/signal_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>

#include "core/link_cause.h"
#include "core/quotes.h"
#include "transports/codecs/dbc/roles.h"
#include "transports/codecs/dbc/signal.h"

namespace tribus {
namespace {

using Mistakes = std::vector<SettingMistake>;

constexpr unsigned kMostCounterBits = 32;
/// "yes" and "no", and in J1939 "error" and "not available".
constexpr unsigned kMostStatusBits = 2;

DbcConditions conditions_of(const DbcMessage& message, const DbcSignal& signal) {
    DbcConditions conditions;
    const DbcSignal* at = &signal;
    for (std::size_t depth = 0; at->selector && depth < kDeepestDbcMultiplexing; ++depth) {
        const DbcSignal& selector = message.signals[*at->selector];
        conditions.insert(conditions.begin(), {&selector, at->selected_by});
        at = &selector;
    }
    return conditions;
}

/// Whether the file says on which selectors and values the signal and its selectors depend.
bool pages_known(const DbcSignal& signal, const DbcConditions& conditions) {
    return !signal.page_unknown &&
           std::ranges::none_of(conditions, [](const DbcCondition& condition) {
               return condition.selector->page_unknown;
           });
}

std::string shown(double number) {
    std::string text = std::to_string(number);
    text.erase(text.find_last_not_of('0') + 1);
    return text.ends_with('.') ? text.substr(0, text.size() - 1) : text;
}

/// Checks one role against its signal.
class SignalMapper {
  public:
    SignalMapper(const DbcMessage& message, const DbcSignal& signal, std::vector<std::string> path,
                 Mistakes& mistakes)
        : message_(message),
          signal_(signal),
          layout_(signal),
          path_(std::move(path)),
          conditions_(conditions_of(message, signal)),
          mistakes_(mistakes) {}

    std::optional<DbcMappedSignal> map(const DbcRole& role) {
        if (!pages_known(signal_, conditions_)) {
            complain(
                "the DBC file says that it is multiplexed, but not by which signal or with "
                "which values of it; allowed: a signal marked m0, m1, ... in a message with "
                "one signal marked M, or one with a range in SG_MUL_VAL_");
            return std::nullopt;
        }
        const std::size_t before = mistakes_.size();
        auto use = std::visit(
            [&](const auto& known) -> std::optional<DbcUse> { return use_of(known); }, role);
        if (!use || mistakes_.size() > before) {
            return std::nullopt;
        }
        return DbcMappedSignal{&signal_, path_, conditions_, *use};
    }

  private:
    void complain(std::string text) { mistakes_.push_back({path_, std::move(text)}); }
    void complain_at(std::string_view key, std::string text) {
        auto path = path_;
        path.emplace_back(key);
        mistakes_.push_back({std::move(path), std::move(text)});
    }

    bool in_every_frame() const { return conditions_.empty(); }
    bool integer() const { return signal_.kind == DbcValueKind::integer; }
    bool in_microseconds() const { return signal_.unit == "us" || signal_.unit == "\u00B5s"; }
    /// Whether the signal can hold this value, within one step.
    bool can_hold(double value) const {
        const double held = layout_.physical(layout_.bits_from_physical(value));
        return !integer() || std::abs(held - value) <= std::abs(signal_.factor);
    }

    std::optional<DbcUse> use_of(const DbcChannelRole& role) {
        const auto value = value_points(role);
        if (!value) {
            return std::nullopt;
        }
        DbcChannel channel{.channel = role.channel,
                           .signal = signal_.name,
                           .layout = layout_,
                           .value = *value,
                           .microseconds = role.microseconds,
                           .optional = role.optional};
        if (!role.value && in_microseconds()) {
            channel.microseconds = channel.value;
        }
        if (signal_.has_range()) {
            channel.range = {signal_.minimum, signal_.maximum};
        }
        channel.not_available = code(role.not_available, "not_available");
        channel.error = code(role.error, "error");
        if (message_.j1939) {
            channel.usual_not_available = j1939_not_available(signal_);
        }
        channel.negative = status(role.negative, "negative");
        channel.positive = status(role.positive, "positive");
        channel.neutral = status(role.neutral, "neutral");
        return channel;
    }

    std::optional<DbcUse> use_of(const DbcFlagRole& role) {
        constexpr unsigned kCauseBits = 3;
        static_assert(static_cast<unsigned>(LinkCause::channels_missing) < 1U << kCauseBits);
        if (role.meaning == DbcFlagMeaning::cause && signal_.bit_length < kCauseBits) {
            complain_at("flag", in_quotes(signal_.name) +
                                    " is too narrow for a cause; allowed: 3 bits or more");
            return std::nullopt;
        }
        return DbcFlag{role.meaning, layout_};
    }

    std::optional<DbcUse> use_of(const DbcFixedRole& role) {
        const std::uint64_t bits = layout_.bits_from_physical(role.value);
        const double step = integer() ? std::abs(signal_.factor) : std::abs(role.value);
        constexpr double kRounding = 1e-3;
        if (std::abs(layout_.physical(bits) - role.value) > step * kRounding) {
            complain_at("fixed", in_quotes(signal_.name) + " cannot be " + shown(role.value) +
                                     "; the nearest possible value is " +
                                     shown(layout_.physical(bits)));
            return std::nullopt;
        }
        return DbcFixed{signal_.name, layout_, bits};
    }

    std::optional<DbcUse> use_of(const DbcCounterRole& role) {
        if (!in_every_frame() || signal_.is_signed || !integer() ||
            signal_.bit_length > kMostCounterBits) {
            complain(
                "this signal cannot be a counter; allowed: an unsigned signal of up to 32 bits "
                "that every frame of the message has");
            return std::nullopt;
        }
        const std::uint64_t fits = (std::uint64_t{1} << signal_.bit_length) - 1;
        const auto most = role.most ? static_cast<std::uint64_t>(*role.most) : fits;
        if (most > fits) {
            complain_at("most", in_quotes(signal_.name) + " cannot count that far; allowed: 1 to " +
                                    std::to_string(fits));
            return std::nullopt;
        }
        return DbcCounter{layout_, most};
    }

    std::optional<DbcUse> use_of(const DbcChecksumRole& role) {
        if (!holds_checksum(role.kind)) {
            complain(std::string("this signal cannot hold that checksum; allowed: ") +
                     (role.kind == DbcChecksumKind::p05
                          ? "bytes 0 and 1, low byte first (0|16@1+), and data after them"
                      : role.kind == DbcChecksumKind::p01
                          ? "byte 0 (0|8@1+), and data after it"
                          : "one whole byte that every frame of the message has"));
            return std::nullopt;
        }
        const auto from_file = message_.e2e_data_id;
        const bool profile = is_profile(role.kind);
        if (profile && !role.data_id && (!from_file || *from_file > 0xFFFF)) {
            complain(
                "the profile needs the data id of the message; allowed: data_id = 0 to "
                "65535, or the attribute RcE2eDataId in the DBC file");
            return std::nullopt;
        }
        const auto id =
            role.data_id ? static_cast<std::uint32_t>(*role.data_id) : from_file.value_or(0);
        return DbcChecksum{role.kind, layout_, signal_.start_bit / 8,
                           static_cast<std::uint16_t>(id)};
    }

    std::optional<DbcUse> use_of(const DbcValueRole& role) {
        DbcValue value{
            .from = role.from, .signal = signal_.name, .unit = signal_.unit, .layout = layout_};
        if (signal_.has_range()) {
            value.range = {signal_.minimum, signal_.maximum};
        }
        if (message_.j1939) {
            value.most_bits = most_j1939_bits(signal_);
        }
        value.not_available = role.not_available ? code(role.not_available, "not_available")
                              : message_.j1939   ? j1939_not_available(signal_)
                                                 : std::nullopt;
        return value;
    }

    bool holds_checksum(DbcChecksumKind kind) const {
        const bool motorola = signal_.byte_order == DbcByteOrder::motorola;
        const bool wide = kind == DbcChecksumKind::p05;
        const bool whole = signal_.start_bit % 8 == (motorola ? 7U : 0U) &&
                           signal_.bit_length == (wide ? 16U : 8U) && integer();
        const bool first = signal_.start_bit / 8 == 0 && message_.length > signal_.bit_length / 8;
        return whole && in_every_frame() && !(wide && motorola) && (!is_profile(kind) || first);
    }

    std::optional<std::array<double, 2>> value_points(const DbcChannelRole& role) {
        if (role.value) {
            return checked_points(*role.value, role, "value");
        }
        if (in_microseconds()) {
            return checked_points({1000, 2000}, role, "channel");
        }
        if (signal_.has_range()) {
            const double most = signal_.maximum;
            return std::array{role.negative.empty() ? signal_.minimum : -most, most};
        }
        complain("the file gives no range of " + in_quotes(signal_.name) +
                 ", so its values have no pulses; allowed: { channel = 1, value = [-100, 100], us "
                 "= [1000, 2000] }");
        return std::nullopt;
    }

    /// If an end of the stick's travel is outside the range of the signal, output values would be
    /// cut off without notice, and full travel of an input would be read as no value.
    std::optional<std::array<double, 2>> checked_points(const std::array<double, 2>& points,
                                                        const DbcChannelRole& role,
                                                        std::string_view key) {
        for (const double point : points) {
            const double value = role.negative.empty() ? point : std::abs(point);
            const bool beyond_range = role.value && signal_.has_range() &&
                                      (value < signal_.minimum || value > signal_.maximum);
            if (beyond_range || !can_hold(value)) {
                complain_at(key,
                            in_quotes(signal_.name) + " cannot be " + shown(value) +
                                (beyond_range ? "; the file allows " + shown(signal_.minimum) +
                                                    " to " + shown(signal_.maximum)
                                              : "; allowed: values that fit its " +
                                                    std::to_string(signal_.bit_length) + " bits"));
                return std::nullopt;
            }
        }
        return points;
    }

    std::optional<std::uint64_t> code(std::optional<std::int64_t> raw, std::string_view key) {
        const auto bits = raw ? layout_.bits_from_raw(*raw) : std::nullopt;
        if (raw && !bits) {
            complain_at(key, std::to_string(*raw) + " does not fit the " +
                                 std::to_string(signal_.bit_length) + " bits of " +
                                 in_quotes(signal_.name) + "; allowed: a raw value that does");
        }
        return bits;
    }

    std::optional<DbcLayout> status(const std::string& name, std::string_view key) {
        if (name.empty()) {
            return std::nullopt;
        }
        const DbcSignal* other = message_.find(name);
        if (other == nullptr) {
            complain_at(key, "message " + in_quotes(message_.name) + " has no signal " +
                                 in_quotes(name) + "; allowed: " + dbc_names(message_.signals));
            return std::nullopt;
        }
        const auto needed = conditions_of(message_, *other);
        const bool with_it = pages_known(*other, needed) && needed.size() <= conditions_.size() &&
                             std::equal(needed.begin(), needed.end(), conditions_.begin());
        if (other->bit_length > kMostStatusBits || !with_it || other == &signal_) {
            complain_at(key, in_quotes(name) + " cannot give the direction of " +
                                 in_quotes(signal_.name) +
                                 "; allowed: another signal of 1 or 2 bits in the same "
                                 "frames");
            return std::nullopt;
        }
        return DbcLayout(*other);
    }

    const DbcMessage& message_;
    const DbcSignal& signal_;
    DbcLayout layout_;
    std::vector<std::string> path_;
    DbcConditions conditions_;
    Mistakes& mistakes_;
};

}  // namespace

std::string unusable_in_dbc(std::string_view kind, const DbcUnusable& part) {
    return std::string(kind) + " " + in_quotes(part.name) +
           " cannot be used because of a mistake in line " + std::to_string(part.why.line) +
           ", column " + std::to_string(part.why.column) + " of the DBC file: " + part.why.text;
}

std::string no_dbc_message(const DbcFile& file, std::string_view name) {
    const auto unusable = std::ranges::find(file.unusable, name, &DbcUnusable::name);
    if (unusable != file.unusable.end()) {
        return unusable_in_dbc("message", *unusable);
    }
    return "the DBC file has no message " + in_quotes(name) +
           (file.messages.empty() ? "; it has no messages: no line begins with BO_"
                                  : "; allowed: " + dbc_names(file.messages));
}

std::optional<DbcMappedSignal> map_dbc_signal(const DbcMessage& message, const SettingEntry& entry,
                                              const std::vector<std::string>& path,
                                              Mistakes& mistakes) {
    const DbcSignal* signal = message.find(entry.key);
    const auto unusable = std::ranges::find(message.unusable, entry.key, &DbcUnusable::name);
    if (unusable != message.unusable.end()) {
        mistakes.push_back({path, unusable_in_dbc("signal", *unusable)});
        return std::nullopt;
    }
    if (signal == nullptr) {
        mistakes.push_back({path, "message " + in_quotes(message.name) + " has no signal " +
                                      in_quotes(entry.key) +
                                      "; allowed: " + dbc_names(message.signals)});
        return std::nullopt;
    }
    const auto role = read_dbc_role(entry.value, path, mistakes);
    return role ? SignalMapper(message, *signal, path, mistakes).map(*role) : std::nullopt;
}

}  // namespace tribus
