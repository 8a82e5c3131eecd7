#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <span>
#include <string_view>

#include "config/keys/keys.h"

/// Values of the configuration as JSON, in the notation of a file and in the order of the rows.
namespace tribus {

/// A number. Whole numbers have no decimal point.
nlohmann::ordered_json number_json(double number);

/// A value in the notation of its type.
nlohmann::ordered_json value_json(SettingType type, const SettingValue& value);

/// The values of `keys`, in that order and in the notation of their types.
nlohmann::ordered_json values_json(const SettingValues& values, std::span<const Key> keys);

/// The members of `object` that rows name, in the order of the rows.
nlohmann::ordered_json members_json(const void* object, const char* owner,
                                    std::span<const Key> keys);
template <class Owner>
nlohmann::ordered_json fields_json(const Owner& object, std::span<const Key> keys) {
    return members_json(&object, &kOwner<Owner>, keys);
}

/// The members of `json` that `wanted` accepts, in the order of the rows, followed by those that
/// are no rows.
nlohmann::ordered_json in_order_of_rows(
    const nlohmann::ordered_json& json, std::span<const Key> keys,
    const std::function<bool(std::string_view key)>& wanted = [](std::string_view) {
        return true;
    });

}  // namespace tribus
