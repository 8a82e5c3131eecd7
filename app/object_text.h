#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json_fwd.hpp>

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

    void add(std::string_view key, const nlohmann::ordered_json& value);
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

    void open_member(std::string_view key);
    void append(const nlohmann::ordered_json& value);

    std::string text_;
};

}  // namespace tribus
