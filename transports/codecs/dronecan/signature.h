#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>
#include <variant>

#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"

/// The DSDL definition of a described type, and its signature. An error in a name, a length or the
/// order of fields gives another signature. Pure and reentrant; no heap; usable at compile time.
/// Source: the DSDL chapter of the specification, "Signature".
namespace tribus::dronecan {

/// CRC-64-WE.
class SignatureHash {
  public:
    constexpr void add(std::string_view text) {
        for (const char letter : text) {
            add_byte(static_cast<std::uint8_t>(letter));
        }
    }
    /// Adds the signature of a nested type, then the value before it.
    constexpr void extend(std::uint64_t signature) {
        const std::uint64_t before = value();
        add_low_byte_first(signature);
        add_low_byte_first(before);
    }
    constexpr std::uint64_t value() const { return ~crc_; }

  private:
    constexpr void add_byte(std::uint8_t byte) {
        constexpr std::uint64_t kPolynomial = 0x42F0E1EBA9EA3693;
        crc_ ^= std::uint64_t{byte} << 56U;
        for (int bit = 0; bit < 8; ++bit) {
            crc_ = (crc_ << 1U) ^ ((crc_ >> 63U) != 0 ? kPolynomial : 0);
        }
    }
    constexpr void add_low_byte_first(std::uint64_t value) {
        for (unsigned shift = 0; shift < 64; shift += 8) {
            add_byte(static_cast<std::uint8_t>(value >> shift));
        }
    }

    std::uint64_t crc_ = ~std::uint64_t{0};
};

/// Writes the normalised definition: one line for the name and one for each field, without a line
/// feed at the end. `Text` has add(std::string_view).
template <class Text>
class DefinitionWriter {
  public:
    constexpr explicit DefinitionWriter(Text& text) : text_(text) {}

    /// A message, a service or a nested type.
    template <class T>
    constexpr void type() {
        text_.add(T::kName);
        if constexpr (ServiceType<T>) {
            structure<typename T::Request>();
            text_.add("\n---");
            structure<typename T::Response>();
        } else {
            structure<T>();
        }
    }

  private:
    template <class T>
    constexpr void structure() {
        if constexpr (Union<T>) {
            text_.add("\n@union");
            for_each_alternative<T>([&]<class Element>(const Alternative<Element>& one, auto at) {
                using Value = std::variant_alternative_t<at(), decltype(T::held)>;
                line(Element{}, std::type_identity<Value>{}, one.name);
            });
        } else {
            for_each_field<T>([&](const auto& item, bool) { this->item(item); });
        }
    }

    template <unsigned kBits>
    constexpr void item(const Padding<kBits>&) {
        text_.add("\nvoid");
        number(kBits);
    }
    template <class Element, class Owner, class Value>
    constexpr void item(const Field<Element, Owner, Value>& field) {
        line(Element{}, std::type_identity<Value>{}, field.name);
    }

    template <class Element, class Value>
    constexpr void line(Element, std::type_identity<Value> value, std::string_view name) {
        text_.add("\n");
        element(Element{}, value);
        text_.add(" ");
        text_.add(name);
    }

    template <unsigned kBits, Cast kCast, class Value>
    constexpr void element(Unsigned<kBits, kCast>, Value) {
        text_.add(kCast == Cast::saturated ? "saturated uint" : "truncated uint");
        number(kBits);
    }
    template <unsigned kBits, class Value>
    constexpr void element(Signed<kBits>, Value) {
        text_.add("saturated int");
        number(kBits);
    }
    template <class Value>
    constexpr void element(Boolean, Value) {
        text_.add("saturated bool");
    }
    template <class Value>
    constexpr void element(Float16, Value) {
        text_.add("saturated float16");
    }
    template <class Value>
    constexpr void element(Float32, Value) {
        text_.add("saturated float32");
    }
    template <class T>
    constexpr void element(Nested, std::type_identity<T>) {
        text_.add(T::kName);
    }
    template <class Element, class Value, std::size_t kSize>
    constexpr void element(ArrayOf<Element>, std::type_identity<std::array<Value, kSize>>) {
        element(Element{}, std::type_identity<Value>{});
        text_.add("[");
        number(kSize);
        text_.add("]");
    }
    template <class Element, class Array>
    constexpr void element(ArrayOf<Element>, std::type_identity<Array>) {
        element(Element{}, std::type_identity<typename Array::Item>{});
        text_.add("[<=");
        number(Array::capacity());
        text_.add("]");
    }

    constexpr void number(std::size_t value) {
        if (value >= 10) {
            number(value / 10);
        }
        const char digit = static_cast<char>('0' + value % 10);
        text_.add(std::string_view(&digit, 1));
    }

    Text& text_;
};

/// The signature of a message, a service or a nested type.
template <class T>
constexpr std::uint64_t computed_signature();

/// Adds the signatures of the nested types in the order of the fields.
template <class T>
constexpr void extend_by_nested(SignatureHash& hash);

template <class Element, class Value>
constexpr void extend_by_element(SignatureHash& hash, Element, std::type_identity<Value>) {
    if constexpr (std::is_same_v<Element, Nested>) {
        hash.extend(computed_signature<Value>());
    }
}
template <class Element, class Array>
constexpr void extend_by_element(SignatureHash& hash, ArrayOf<Element>, std::type_identity<Array>) {
    using Value = std::remove_reference_t<decltype(Array{}[0])>;
    extend_by_element(hash, Element{}, std::type_identity<Value>{});
}

template <class T>
constexpr void extend_by_nested(SignatureHash& hash) {
    if constexpr (ServiceType<T>) {
        extend_by_nested<typename T::Request>(hash);
        extend_by_nested<typename T::Response>(hash);
    } else if constexpr (Union<T>) {
        for_each_alternative<T>([&]<class Element>(const Alternative<Element>&, auto at) {
            using Value = std::variant_alternative_t<at(), decltype(T::held)>;
            extend_by_element(hash, Element{}, std::type_identity<Value>{});
        });
    } else {
        for_each_field<T>([&]<class Item>(const Item&, bool) {
            if constexpr (requires { typename Item::Element; }) {
                extend_by_element(hash, typename Item::Element{},
                                  std::type_identity<typename Item::Value>{});
            }
        });
    }
}

template <class T>
constexpr std::uint64_t computed_signature() {
    SignatureHash hash;
    DefinitionWriter(hash).template type<T>();
    extend_by_nested<T>(hash);
    return hash.value();
}

}  // namespace tribus::dronecan
