#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <variant>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"

/// The values of a message for people to read. Pure and reentrant; uses heap, so not for the data
/// path.
namespace tribus::dronecan {

/// An empty array; never one of bytes.
struct NoItems {};

/// Valid only during the call.
struct FieldValue {
    std::string_view path;  ///< "status.uptime_sec", "commands[2].actuator_id"
    /// Unknown measurements are NaN. Text may contain any bytes.
    std::variant<std::uint64_t, std::int64_t, bool, double, std::string_view,
                 std::span<const std::uint8_t>, NoItems>
        value;
    std::string_view unit;  ///< empty if there is none
};

template <class Visit>
class ValueVisitor {
  public:
    explicit ValueVisitor(Visit& visit) : visit_(visit) {}

    template <class T>
    void structure(const T& value) {
        if constexpr (Union<T>) {
            for_each_alternative<T>([&]<class Element>(const Alternative<Element>& one, auto at) {
                if (const auto* held = std::get_if<at()>(&value.held)) {
                    named(Element{}, one.name, *held, {});
                }
            });
        } else {
            for_each_field<T>([&](const auto& item, bool) { this->item(item, value); });
        }
    }

  private:
    template <unsigned kBits, class T>
    void item(const Padding<kBits>&, const T&) {}
    template <class Element, class T, class Value>
    void item(const Field<Element, T, Value>& field, const T& value) {
        named(Element{}, field.name, value.*field.member, field.unit);
    }

    template <class Element, class Value>
    void named(Element, std::string_view name, const Value& value, std::string_view unit) {
        const std::size_t outer = path_.size();
        path_ += path_.empty() ? "" : ".";
        path_ += name;
        element(Element{}, value, unit);
        path_.resize(outer);
    }

    template <unsigned kBits, Cast kCast>
    void element(Unsigned<kBits, kCast>, std::uint64_t value, std::string_view unit) {
        visit_(FieldValue{path_, value, unit});
    }
    template <unsigned kBits>
    void element(Signed<kBits>, std::int64_t value, std::string_view unit) {
        visit_(FieldValue{path_, value, unit});
    }
    void element(Boolean, bool value, std::string_view unit) {
        visit_(FieldValue{path_, value, unit});
    }
    void element(Float16, float value, std::string_view unit) {
        visit_(FieldValue{path_, double{value}, unit});
    }
    void element(Float32, float value, std::string_view unit) {
        visit_(FieldValue{path_, double{value}, unit});
    }
    /// A struct without fields, as an alternative of a union, is shown as "true".
    template <class T>
    void element(Nested, const T& value, std::string_view unit) {
        if constexpr (std::is_empty_v<T>) {
            visit_(FieldValue{path_, true, unit});
        } else {
            structure(value);
        }
    }
    template <std::size_t kMost>
    void element(ArrayOf<Unsigned<8>>, const BoundedText<kMost>& text, std::string_view unit) {
        visit_(FieldValue{path_, text.view(), unit});
    }
    template <std::size_t kMost>
    void element(ArrayOf<Unsigned<8>>, const BoundedArray<std::uint8_t, kMost>& bytes,
                 std::string_view unit) {
        visit_(FieldValue{path_, std::span(bytes.data(), bytes.size()), unit});
    }
    template <std::size_t kSize>
    void element(ArrayOf<Unsigned<8>>, const std::array<std::uint8_t, kSize>& bytes,
                 std::string_view unit) {
        visit_(FieldValue{path_, std::span<const std::uint8_t>(bytes), unit});
    }
    template <class Element, class Items>
    void element(ArrayOf<Element>, const Items& items, std::string_view unit) {
        if (items.size() == 0) {
            visit_(FieldValue{path_, NoItems{}, unit});
        }
        const std::size_t outer = path_.size();
        for (std::size_t at = 0; at < items.size(); ++at) {
            path_ += "[" + std::to_string(at) + "]";
            element(Element{}, items[at], unit);
            path_.resize(outer);
        }
    }

    Visit& visit_;
    std::string path_;
};

/// Calls `visit` with a FieldValue for each value in wire order.
template <class T, class Visit>
void visit_values(const T& value, Visit&& visit) {
    ValueVisitor<std::remove_reference_t<Visit>>(visit).structure(value);
}

}  // namespace tribus::dronecan
