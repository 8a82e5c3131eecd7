#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>
#include <variant>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/transfer.h"

/// Description of a DroneCAN data type, used for everything: payload.h reads and writes it,
/// signature.h computes its signature, visit.h shows its values.
///
/// A type is a plain struct. It has
///  - `kName`, its full name;
///  - `fields()`, a tuple of its fields in order; a union instead has a variant `held` and
///    `alternatives()`, a tuple of them in the order of the variant;
///  - if it is sent on its own: `kId`, `kSignature`, and `kKind` for a message, or for a service
///    the structs `Request` and `Response`, which have `Service`, `kKind` and their fields.
namespace tribus::dronecan {

/// How a value is sent that does not fit into its field.
enum class Cast : std::uint8_t { saturated, truncated };

/// Elements: the wire form of one value. Tags only. The C++ type of the value gives the rest:
/// std::array is an array of fixed size, BoundedArray or BoundedText one of any size up to N.
template <unsigned kBits, Cast kCast = Cast::saturated>
struct Unsigned {};
template <unsigned kBits>
struct Signed {};
struct Boolean {};
struct Float16 {};  ///< C++ type float; unknown values are NaN
struct Float32 {};
struct Nested {};  ///< another struct
template <class Element>
struct ArrayOf {};

template <class ElementType, class OwnerType, class ValueType>
struct Field {
    using Element = ElementType;
    using Value = ValueType;
    std::string_view name;
    ValueType OwnerType::*member;
    std::string_view unit;  ///< empty if there is none, or if it depends on other fields
};

template <class Element, class Owner, class Value>
constexpr Field<Element, Owner, Value> field(std::string_view name, Value Owner::*member,
                                             std::string_view unit = {}) {
    return {name, member, unit};
}

/// Unused bits: sent as zero, ignored when received.
template <unsigned kBitCount>
struct Padding {
    static constexpr unsigned kBits = kBitCount;
};

template <class ElementType>
struct Alternative {
    using Element = ElementType;
    std::string_view name;
};

template <class T>
concept Union = requires {
    T::alternatives();
};

template <class T>
concept ServiceType = requires {
    typename T::Request;
    typename T::Response;
};

/// The request or the response of a service.
template <class T>
concept PartOfService = requires {
    typename T::Service;
};

/// Calls `visit(field, is_last)` in wire order. `field` is a Field or a Padding.
template <class T, class Visit>
constexpr void for_each_field(Visit&& visit) {
    const auto fields = T::fields();
    [&]<std::size_t... kAt>(std::index_sequence<kAt...>) {
        (visit(std::get<kAt>(fields), kAt + 1 == sizeof...(kAt)), ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(T::fields())>>{});
}

/// Calls `visit(alternative, index)`. `index` is a std::integral_constant.
template <Union T, class Visit>
constexpr void for_each_alternative(Visit&& visit) {
    const auto alternatives = T::alternatives();
    [&]<std::size_t... kAt>(std::index_sequence<kAt...>) {
        (visit(std::get<kAt>(alternatives), std::integral_constant<std::size_t, kAt>{}), ...);
    }
    (std::make_index_sequence<std::tuple_size_v<decltype(T::alternatives())>>{});
}

template <Union T>
inline constexpr std::size_t kAlternativeCount = std::variant_size_v<decltype(T::held)>;
template <Union T>
inline constexpr unsigned kTagBits = std::bit_width(kAlternativeCount<T> - 1);

/// Bits of the length in front of the items of a dynamic array.
template <class Array>
inline constexpr unsigned kLengthBits = std::bit_width(Array::capacity());

/// Identifies the kind of a payload on the bus.
struct DataType {
    std::string_view name;
    TransferKind kind = TransferKind::message;
    std::uint16_t id = 0;
    std::uint64_t signature = 0;

    bool operator==(const DataType&) const = default;
};

/// The data type of a message, or of the request or response of a service.
template <class T>
constexpr DataType data_type_of() {
    if constexpr (PartOfService<T>) {
        using Service = typename T::Service;
        return {Service::kName, T::kKind, Service::kId, Service::kSignature};
    } else {
        return {T::kName, T::kKind, T::kId, T::kSignature};
    }
}

}  // namespace tribus::dronecan
