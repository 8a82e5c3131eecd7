#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <utility>

#include <nlohmann/json_fwd.hpp>

namespace tribus {

/// Writes a JSON object member by member. A tree of the whole would take several times the memory
/// of the text, in the heap that long-lived objects share, and would keep it from shrinking.
class ObjectText {
  public:
    /// Larger than the threshold of the heap (app/daemon/run.cpp), so that not even the text is in
    /// the heap.
    ObjectText() {
        text_.reserve(kLongText);
        text_ += '{';
    }

    /// Adds a member.
    void add(std::string_view key, const nlohmann::ordered_json& value);
    /// Adds a list of `count` entries.
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
    /// The whole text; the object is used up.
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

/// Dumps on one line. Bytes that are not UTF-8, of file names for example, are replaced.
std::string json_text(const nlohmann::ordered_json& json);

/// `{"type":"error","error":text}`.
std::string error_object(std::string_view text);

}  // namespace tribus
