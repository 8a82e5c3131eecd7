#include "config/language/key_parts.h"

#include <string>

#include "config/language/places.h"

namespace tribus {
namespace {

/// Scans a text as a TOML parser does as long as it finds no mistake.
class Scan {
  public:
    explicit Scan(std::string_view text) : text_(text) {}

    std::optional<Location> find() {
        while (!at_end()) {
            const char c = text_[at_];
            if (c == '#') {
                skip_comment();
            } else if (c == '"' || c == '\'') {
                skip_quoted(c);
            } else {
                step();
                count(c);
            }
            if (parts_ > kMostKeyParts) {
                return place_.where();
            }
        }
        return std::nullopt;
    }

  private:
    bool at_end() const { return at_ >= text_.size(); }
    bool stands(std::string_view what) const { return text_.substr(at_).starts_with(what); }

    void step() {
        place_.pass(text_[at_]);
        ++at_;
    }
    void step(std::size_t count) {
        for (; count > 0 && !at_end(); --count) {
            step();
        }
    }
    void count(char c) {
        constexpr std::string_view kBetweenKeys = "\n=,[]{}";
        if (c == '.') {
            ++parts_;
        } else if (kBetweenKeys.find(c) != std::string_view::npos) {
            parts_ = 1;
        }
    }
    void skip_comment() {
        while (!at_end() && text_[at_] != '\n') {
            step();
        }
    }
    void skip_quoted(char quote) {
        const std::string three(3, quote);
        const bool lines = stands(three);
        const std::string end = lines ? three : std::string(1, quote);
        step(end.size());
        while (!at_end() && !stands(end) && (lines || text_[at_] != '\n')) {
            step(quote == '"' && text_[at_] == '\\' ? 2 : 1);
        }
        if (stands(end)) {
            step(end.size());
        }
    }

    std::string_view text_;
    std::size_t at_ = 0;
    TextPlace place_;
    std::size_t parts_ = 1;
};

}  // namespace

std::optional<Location> find_key_of_too_many_parts(std::string_view text) {
    return Scan(text).find();
}

}  // namespace tribus
