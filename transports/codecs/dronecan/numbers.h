#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"

/// The numbers of a message in wire order. The list is always the same, independent of the length
/// of arrays, so each number has a fixed index. Texts and bytes are not included. Pure and
/// reentrant; no heap.
namespace tribus::dronecan {

/// `Visit` has
///  - `enter(name)` and `leave()` around everything with a name;
///  - `enter(index)` and `leave()` around each item of an array;
///  - `number(field, number, unit)`, where `field` is the address of the value, and
///    `missing(unit)` for items that an array could have but does not.
template <class Visit>
class NumberWalk {
  public:
    explicit NumberWalk(Visit& visit) : visit_(visit) {}

    template <class T>
    requires(!Union<T>) void structure(const T& value, bool there = true) {
        for_each_field<T>([&](const auto& item, bool) { this->item(item, value, there); });
    }

  private:
    template <unsigned kBits, class T>
    void item(const Padding<kBits>&, const T&, bool) {}
    template <class Element, class T, class Value>
    void item(const Field<Element, T, Value>& field, const T& value, bool there) {
        visit_.enter(field.name);
        element(Element{}, value.*field.member, there, field.unit);
        visit_.leave();
    }

    template <class Number>
    void number(const Number& number, bool there, std::string_view unit) {
        if (there) {
            visit_.number(&number, static_cast<double>(number), unit);
        } else {
            visit_.missing(unit);
        }
    }
    template <unsigned kBits, Cast kCast, class Number>
    void element(Unsigned<kBits, kCast>, const Number& value, bool there, std::string_view unit) {
        number(value, there, unit);
    }
    template <unsigned kBits, class Number>
    void element(Signed<kBits>, const Number& value, bool there, std::string_view unit) {
        number(value, there, unit);
    }
    void element(Boolean, const bool& value, bool there, std::string_view unit) {
        number(value, there, unit);
    }
    void element(Float16, const float& value, bool there, std::string_view unit) {
        number(value, there, unit);
    }
    void element(Float32, const float& value, bool there, std::string_view unit) {
        number(value, there, unit);
    }
    template <class T>
    void element(Nested, const T& value, bool there, std::string_view) {
        structure(value, there);
    }
    template <class Items>
    void element(ArrayOf<Unsigned<8>>, const Items&, bool, std::string_view) {}
    template <class Element, class Item, std::size_t kSize>
    void element(ArrayOf<Element>, const std::array<Item, kSize>& items, bool there,
                 std::string_view unit) {
        for (std::size_t at = 0; at < kSize; ++at) {
            visit_.enter(at);
            element(Element{}, items[at], there, unit);
            visit_.leave();
        }
    }
    template <class Element, class Item, std::size_t kMost>
    void element(ArrayOf<Element>, const BoundedArray<Item, kMost>& items, bool there,
                 std::string_view unit) {
        static constexpr Item kNone{};
        for (std::size_t at = 0; at < kMost; ++at) {
            visit_.enter(at);
            const bool item_there = there && at < items.size();
            element(Element{}, item_there ? items[at] : kNone, item_there, unit);
            visit_.leave();
        }
    }

    Visit& visit_;
};

template <class T, class Visit>
void walk_numbers(const T& value, Visit& visit) {
    NumberWalk<Visit>(visit).structure(value);
}

}  // namespace tribus::dronecan
