#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json.hpp>

namespace tribus {

/// An object of JSON that is written member by member and entry by entry. The whole as a tree would
/// take a multiple of its text, of a heap that longer-lived things share, which would keep it from
/// shrinking again.
class ObjectText {
  public:
    /// Beyond the threshold of the heap (app/run.cpp), so that not even the text grows in it.
    ObjectText() {
        text_.reserve(kLongText);
        text_ += '{';
    }

    void add(std::string_view key, const nlohmann::ordered_json& value) {
        open_member(key);
        append(value);
    }
    /// One entry for each of `count`.
    template <class Entry>
    void add_list(std::string_view key, std::size_t count, Entry entry) {
        open_member(key);
        text_ += '[';
        for (std::size_t i = 0; i < count; ++i) {
            text_ += i == 0 ? "" : ",";
            append(entry(i));
        }
        text_ += ']';
    }
    std::string end() && {
        text_ += '}';
        return std::move(text_);
    }

  private:
    static constexpr std::size_t kLongText = std::size_t{128} * 1024;

    void open_member(std::string_view key) {
        text_ += text_.size() == 1 ? "\"" : ",\"";
        text_ += key;
        text_ += "\":";
    }
    /// File names and those of devices may be of any bytes.
    void append(const nlohmann::ordered_json& value) {
        text_ += value.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
    }

    std::string text_;
};

}  // namespace tribus
