#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Meaning of the numbers on an i.Bus sensor bus (docs/protocols/ibus.md, "Sensor types"), as data.
namespace tribus {

/// One number in a sensor's value: number = raw * scale + offset.
struct SensorField {
    std::string name;  ///< "voltage"
    std::string unit;  ///< "V", "degC"; empty for codes and counts
    unsigned first_bit = 0;
    unsigned bits = 16;
    bool is_signed = false;
    double scale = 1;
    double offset = 0;
    /// The raw value that means "not available".
    std::optional<std::int64_t> not_available{};
    /// The lowest raw value, if it is neither 0 nor that of a signed number: a heading that some
    /// senders send as -180 to 180 degrees, and others as 0 to 360.
    std::optional<std::int64_t> least{};

    bool operator==(const SensorField&) const = default;
};

struct SensorType {
    std::string name;  ///< "external_voltage"
    std::uint8_t id = 0;
    std::uint8_t size = 2;            ///< bytes of the value; the size in a type answer overrides
                                      ///< it
    std::vector<SensorField> fields;  ///< one, except for a few types that pack more

    bool operator==(const SensorType&) const = default;
};

/// Sender whose meaning applies to the disputed types.
enum class SensorDialect : std::uint8_t { flysky, betaflight, inav, ardupilot, edgetx, flyplus };

/// Names for configuration files, in the order of SensorDialect.
inline constexpr std::array<std::string_view, 6> kSensorDialectNames{
    "flysky", "betaflight", "inav", "ardupilot", "edgetx", "flyplus"};

/// The type table of one dialect. The user's own types come first; each replaces the types with its
/// id or its name. Ids and names are unique. Not for the data path.
class SensorTypes {
  public:
    explicit SensorTypes(SensorDialect dialect = SensorDialect::flysky,
                         std::vector<SensorType> own = {});
    const SensorType* find(std::uint8_t id) const;
    const SensorType* find(std::string_view name) const;
    std::span<const SensorType> all() const { return types_; }

  private:
    std::vector<SensorType> types_;
};

/// The type for a sensor that reports another size than the table: one plain number of that size,
/// with sign and scale of the first field. For size 0 and sizes above 8 bytes, `type` unchanged.
SensorType with_size(const SensorType& type, std::uint8_t size);

/// The raw value of a field, sign extended. `data` is the whole value; returns nothing if it is too
/// short. Reentrant, no heap.
std::optional<std::int64_t> raw_in(const SensorField& field, std::span<const std::uint8_t> data);
/// Up to 8 bytes as one unsigned number, for a type that is not in the table.
std::optional<std::uint64_t> plain_raw_in(std::span<const std::uint8_t> data);
/// Writes the raw value's bits into `data`; the other bits stay. Does nothing if `data` is too
/// short.
void put_raw(const SensorField& field, std::int64_t raw, std::span<std::uint8_t> data);

/// The number of a raw value, or nothing for "not available".
std::optional<double> number_of(const SensorField& field, std::int64_t raw);
/// The nearest raw value, halves away from zero. Saturates at the range of the field and avoids the
/// raw value that means "not available". Not-a-number gives "not available", or raw 0 if there is
/// no such value.
std::int64_t raw_of(const SensorField& field, double number);

/// Whether the number is negative and the nearest that the field can hold is not.
bool lacks_sign_for(const SensorField& field, double number);

}  // namespace tribus
