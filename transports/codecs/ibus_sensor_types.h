#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// What the numbers on an i.Bus sensor bus mean (docs/protocols/ibus.md, "Sensor types"), as data.
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
    /// The raw value that says that there is none.
    std::optional<std::int64_t> not_available{};
    /// The lowest raw value, where that is neither 0 nor what a sign makes it: a heading that some
    /// send as -180 to 180 degrees, and others as 0 to 360.
    std::optional<std::int64_t> least{};

    bool operator==(const SensorField&) const = default;
};

struct SensorType {
    std::string name;  ///< "external_voltage"
    std::uint8_t id = 0;
    std::uint8_t size = 2;            ///< bytes of the value; what a type reply says wins over it
    std::vector<SensorField> fields;  ///< one, but for a few types that pack more

    bool operator==(const SensorType&) const = default;
};

/// Whose meaning of the disputed types.
enum class SensorDialect : std::uint8_t { flysky, betaflight, inav, ardupilot, edgetx, flyplus };

/// In the order of the dialects, as people call them.
inline constexpr std::array<std::string_view, 6> kSensorDialectNames{
    "flysky", "betaflight", "inav", "ardupilot", "edgetx", "flyplus"};

/// The type table of one dialect, with the user's own types in front: one replaces that of the same
/// id, and that of the same name. No two have the same. Not for the data path.
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

/// The type as it is where a sensor says another size than the table: one plain number of that
/// size, with the sign and scale of the first field. Size 0 and those beyond 8 bytes: the same
/// type.
SensorType with_size(const SensorType& type, std::uint8_t size);

/// The raw value of a field, sign extended. `data` is the whole value; nothing if it is too short.
/// Reentrant, no heap.
std::optional<std::int64_t> raw_in(const SensorField& field, std::span<const std::uint8_t> data);
/// The whole of up to 8 bytes as one number without a sign, of a type that nobody knows.
std::optional<std::uint64_t> plain_raw_in(std::span<const std::uint8_t> data);
/// Writes the raw value's bits into `data`; the others stay. Nothing happens if it is too short.
void put_raw(const SensorField& field, std::int64_t raw, std::span<std::uint8_t> data);

/// The number of a raw value; nothing for "not available".
std::optional<double> number_of(const SensorField& field, std::int64_t raw);
/// The nearest raw value, halves away from zero. Saturates at what the field can hold, never
/// wraps, and never becomes "not available": a number beyond is the nearest one that is a number.
/// Of not-a-number: "not available", or raw 0 where there is no such code.
std::int64_t raw_of(const SensorField& field, double number);

}  // namespace tribus
