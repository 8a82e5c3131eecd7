#pragma once

#include <cstddef>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

namespace tribus {

/// An object that gets each key once. `ordered_json` looks for a key among all before it, and
/// copies them where it grows: some 5 % of what a status with an input and an output costs.
class JsonFields {
  public:
    JsonFields() { members().reserve(kMost); }
    void add(std::string_view key, nlohmann::ordered_json value) {
        members().emplace_back(key, std::move(value));
    }
    nlohmann::ordered_json take() { return std::move(object_); }

  private:
    static constexpr std::size_t kMost = 48;
    nlohmann::ordered_json::object_t::Container& members() {
        return object_.get_ref<nlohmann::ordered_json::object_t&>();
    }
    nlohmann::ordered_json object_ = nlohmann::ordered_json::object();
};

}  // namespace tribus
