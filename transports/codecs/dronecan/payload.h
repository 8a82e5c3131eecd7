#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <type_traits>

#include "transports/codecs/dronecan/bits.h"
#include "transports/codecs/dronecan/bounded_array.h"
#include "transports/codecs/dronecan/fields.h"
#include "transports/codecs/dronecan/float16.h"

/// Reads and writes the payloads of transfers from the descriptions of their types. Pure and
/// reentrant; no heap, no libm. Source: the DSDL chapter of the specification, "Data
/// serialization".
///
/// On classic CAN the length of an array at the very end is left out if its items have 8 bits or
/// more; it follows from the length of the transfer. "At the end" is the last field, also that of a
/// struct which is itself the last field, but not inside the items of such an array. On CAN FD,
/// where transfers may have zeros after their end, every length is sent.
namespace tribus::dronecan {

struct BitRange {
    std::size_t least = 0;
    std::size_t most = 0;
};

template <class T>
constexpr BitRange bit_range();

/// The least and most bits that a value can have. A dynamic array counts as at least 0 bits, since
/// its length may be left out.
class BitRangeOf {
  public:
    template <unsigned kBits, Cast kCast, class Value>
    static constexpr BitRange element(Unsigned<kBits, kCast>, std::type_identity<Value>) {
        static_assert(kBits <= std::numeric_limits<Value>::digits);
        return {kBits, kBits};
    }
    template <unsigned kBits, class Value>
    static constexpr BitRange element(Signed<kBits>, std::type_identity<Value>) {
        static_assert(std::is_signed_v<Value> && kBits <= sizeof(Value) * 8);
        return {kBits, kBits};
    }
    static constexpr BitRange element(Boolean, std::type_identity<bool>) { return {1, 1}; }
    static constexpr BitRange element(Float16, std::type_identity<float>) { return {16, 16}; }
    static constexpr BitRange element(Float32, std::type_identity<float>) { return {32, 32}; }
    template <class T>
    static constexpr BitRange element(Nested, std::type_identity<T>) {
        return bit_range<T>();
    }
    template <class Element, class Value, std::size_t kSize>
    static constexpr BitRange element(ArrayOf<Element>,
                                      std::type_identity<std::array<Value, kSize>>) {
        const BitRange one = element(Element{}, std::type_identity<Value>{});
        return {one.least * kSize, one.most * kSize};
    }
    template <class Element, class Array>
    static constexpr BitRange element(ArrayOf<Element>, std::type_identity<Array>) {
        const BitRange one = element(Element{}, std::type_identity<typename Array::Item>{});
        return {0, kLengthBits<Array> + one.most * Array::capacity()};
    }
};

template <class T>
constexpr BitRange bit_range() {
    BitRange sum;
    if constexpr (Union<T>) {
        sum.least = std::numeric_limits<std::size_t>::max();
        for_each_alternative<T>([&]<class Element>(Alternative<Element>, auto index) {
            using Value = std::variant_alternative_t<index(), decltype(T::held)>;
            const BitRange one = BitRangeOf::element(Element{}, std::type_identity<Value>{});
            sum = {std::min(sum.least, one.least), std::max(sum.most, one.most)};
        });
        return {sum.least + kTagBits<T>, sum.most + kTagBits<T>};
    } else {
        for_each_field<T>([&]<class Item>(const Item&, bool) {
            if constexpr (requires { typename Item::Element; }) {
                const BitRange one = BitRangeOf::element(
                    typename Item::Element{}, std::type_identity<typename Item::Value>{});
                sum = {sum.least + one.least, sum.most + one.most};
            } else {
                sum = {sum.least + Item::kBits, sum.most + Item::kBits};
            }
        });
        return sum;
    }
}

/// Bytes of the longest payload, without the zeros after the end that an FD transfer may have.
template <class T>
inline constexpr std::size_t kMostBytes = (bit_range<T>().most + 7) / 8;

/// With smaller items, the length of the transfer does not give the number of items of an array.
inline constexpr std::size_t kLeastBitsOfCountedItems = 8;

/// What a receiver needs to receive a message, request or response.
template <class T>
constexpr WantedTransfer wanted_transfer() {
    constexpr DataType kType = data_type_of<T>();
    return {.kind = kType.kind,
            .data_type_id = kType.id,
            .signature = kType.signature,
            .most_bytes = kMostBytes<T>};
}

class PayloadReader {
  public:
    explicit PayloadReader(std::span<const std::uint8_t> payload) : bits_(payload) {}

    /// Reads a whole struct. `at_end`: nothing follows it, so the transfer's length gives that of
    /// its last array.
    template <class T>
    void structure(T& value, bool at_end) {
        if constexpr (Union<T>) {
            alternative(value, at_end);
        } else {
            for_each_field<T>([&](const auto& item, bool is_last) {
                this->item(item, value, at_end && is_last);
            });
        }
    }

    const BitReader& bits() const { return bits_; }

  private:
    template <unsigned kBits, class T>
    void item(const Padding<kBits>&, T&, bool) {
        bits_.take(kBits);
    }
    template <class Element, class T, class Value>
    void item(const Field<Element, T, Value>& field, T& value, bool at_end) {
        element(Element{}, value.*field.member, at_end);
    }

    template <Union T>
    void alternative(T& value, bool at_end) {
        const std::uint64_t tag = bits_.take(kTagBits<T>);
        if (tag >= kAlternativeCount<T>) {
            bits_.refuse();
            return;
        }
        for_each_alternative<T>([&]<class Element>(Alternative<Element>, auto index) {
            if (tag == index()) {
                element(Element{}, value.held.template emplace<index()>(), at_end);
            }
        });
    }

    template <unsigned kBits, Cast kCast, class Value>
    void element(Unsigned<kBits, kCast>, Value& value, bool) {
        value = static_cast<Value>(bits_.take(kBits));
    }
    template <unsigned kBits, class Value>
    void element(Signed<kBits>, Value& value, bool) {
        constexpr unsigned kAbove = 64 - kBits;
        const auto at_top = static_cast<std::int64_t>(bits_.take(kBits) << kAbove);
        value = static_cast<Value>(at_top >> kAbove);
    }
    void element(Boolean, bool& value, bool) { value = bits_.take(1) != 0; }
    void element(Float16, float& value, bool) {
        value = float_from_float16(static_cast<std::uint16_t>(bits_.take(16)));
    }
    void element(Float32, float& value, bool) {
        value = std::bit_cast<float>(static_cast<std::uint32_t>(bits_.take(32)));
    }
    template <class T>
    void element(Nested, T& value, bool at_end) {
        structure(value, at_end);
    }
    template <class Element, class Value, std::size_t kSize>
    void element(ArrayOf<Element>, std::array<Value, kSize>& items, bool at_end) {
        for (std::size_t at = 0; at < kSize; ++at) {
            element(Element{}, items[at], at_end && at + 1 == kSize);
        }
    }
    template <class Element, class Value, std::size_t kMost>
    void element(ArrayOf<Element>, BoundedArray<Value, kMost>& items, bool at_end) {
        constexpr BitRange kItem = BitRangeOf::element(Element{}, std::type_identity<Value>{});
        if (kItem.least >= kLeastBitsOfCountedItems && at_end) {
            while (!items.full() && bits_.left() >= kItem.least) {
                items.resize(items.size() + 1);
                element(Element{}, items[items.size() - 1], false);
            }
            return;
        }
        const auto count =
            static_cast<std::size_t>(bits_.take(kLengthBits<BoundedArray<Value, kMost>>));
        if (count > kMost) {
            bits_.refuse();
            return;
        }
        items.resize(count);
        for (std::size_t at = 0; at < count; ++at) {
            element(Element{}, items[at], at_end && at + 1 == count);
        }
    }

    BitReader bits_;
};

class PayloadWriter {
  public:
    explicit PayloadWriter(std::span<std::uint8_t> payload) : bits_(payload) {}

    template <class T>
    void structure(const T& value, bool at_end) {
        if constexpr (Union<T>) {
            bits_.put(value.held.index(), kTagBits<T>);
            for_each_alternative<T>([&]<class Element>(Alternative<Element>, auto index) {
                if (const auto* held = std::get_if<index()>(&value.held)) {
                    element(Element{}, *held, at_end);
                }
            });
        } else {
            for_each_field<T>([&](const auto& item, bool is_last) {
                this->item(item, value, at_end && is_last);
            });
        }
    }

    const BitWriter& bits() const { return bits_; }

  private:
    template <unsigned kBits, class T>
    void item(const Padding<kBits>&, const T&, bool) {
        bits_.put(0, kBits);
    }
    template <class Element, class T, class Value>
    void item(const Field<Element, T, Value>& field, const T& value, bool at_end) {
        element(Element{}, value.*field.member, at_end);
    }

    template <unsigned kBits, Cast kCast>
    void element(Unsigned<kBits, kCast>, std::uint64_t value, bool) {
        constexpr std::uint64_t kMost = std::numeric_limits<std::uint64_t>::max() >> (64 - kBits);
        bits_.put(kCast == Cast::saturated ? std::min(value, kMost) : value & kMost, kBits);
    }
    template <unsigned kBits>
    void element(Signed<kBits>, std::int64_t value, bool) {
        constexpr std::int64_t kMost = std::numeric_limits<std::int64_t>::max() >> (64 - kBits);
        bits_.put(static_cast<std::uint64_t>(std::clamp(value, -kMost - 1, kMost)), kBits);
    }
    void element(Boolean, bool value, bool) { bits_.put(value ? 1 : 0, 1); }
    void element(Float16, float value, bool) { bits_.put(float16_from_float(value), 16); }
    void element(Float32, float value, bool) { bits_.put(std::bit_cast<std::uint32_t>(value), 32); }
    template <class T>
    void element(Nested, const T& value, bool at_end) {
        structure(value, at_end);
    }
    template <class Element, class Value, std::size_t kSize>
    void element(ArrayOf<Element>, const std::array<Value, kSize>& items, bool at_end) {
        all(Element{}, std::span(items), at_end);
    }
    template <class Element, class Value, std::size_t kMost>
    void element(ArrayOf<Element>, const BoundedArray<Value, kMost>& items, bool at_end) {
        constexpr BitRange kItem = BitRangeOf::element(Element{}, std::type_identity<Value>{});
        const bool counted = kItem.least >= kLeastBitsOfCountedItems && at_end;
        if (!counted) {
            bits_.put(items.size(), kLengthBits<BoundedArray<Value, kMost>>);
        }
        all(Element{}, std::span(items.begin(), items.size()), at_end && !counted);
    }

    template <class Element, class Items>
    void all(Element, Items items, bool at_end) {
        for (std::size_t at = 0; at < items.size(); ++at) {
            element(Element{}, items[at], at_end && at + 1 == items.size());
        }
    }

    BitWriter bits_;
};

/// Reads the payload of a transfer from TransferReceiver. Returns nothing if it cannot be a T: on
/// classic CAN if its length differs from what was read, rounded up to bytes; on FD if it is
/// shorter; an array longer than the type allows; an unknown alternative. Padding is ignored.
template <class T>
std::optional<T> read(std::span<const std::uint8_t> payload, bool fd) {
    std::optional<T> value(std::in_place);
    PayloadReader reader(payload);
    reader.structure(*value, !fd);
    if (reader.bits().refused() || (!fd && reader.bits().left() >= 8)) {
        value.reset();
    }
    return value;
}

/// Has room for one byte even if empty, so that data() is never null.
template <class T>
using Payload = BoundedArray<std::uint8_t, std::max<std::size_t>(kMostBytes<T>, 1)>;

/// Writes a payload. Every value has an encoding: too large numbers are saturated, or truncated if
/// the type requires it.
template <class T>
Payload<T> write(const T& value, bool fd) {
    Payload<T> payload;
    payload.resize(kMostBytes<T>);
    PayloadWriter writer(std::span(payload.begin(), payload.size()));
    writer.structure(value, !fd);
    payload.resize(writer.bits().bytes_put());
    return payload;
}

}  // namespace tribus::dronecan
