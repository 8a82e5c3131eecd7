#include "config/show/mistakes_json.h"

#include <utility>

#include <nlohmann/json.hpp>

namespace tribus {

nlohmann::ordered_json mistakes_json(std::span<const Mistake> mistakes) {
    auto list = nlohmann::ordered_json::array();
    for (const Mistake& mistake : mistakes) {
        nlohmann::ordered_json json{{"file", mistake.file}};
        if (mistake.where.line != 0) {
            json["line"] = mistake.where.line;
            json["column"] = mistake.where.column;
        }
        json["text"] = mistake.text;
        list.push_back(std::move(json));
    }
    return list;
}

std::string mistakes_document(std::span<const Mistake> mistakes) {
    const nlohmann::ordered_json document{{"mistakes", mistakes_json(mistakes)}};
    // The name of a file may have bytes that are not UTF-8.
    return document.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace tribus
