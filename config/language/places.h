#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "config/schema/schema.h"

namespace tribus {

/// Goes through a text and counts lines and columns. A column is a character.
class TextPlace {
  public:
    Location where() const { return where_; }

    void pass(char byte) {
        if (byte == '\n') {
            ++where_.line;
            where_.column = 1;
        } else if ((static_cast<unsigned char>(byte) & 0xC0U) != 0x80U) {
            // A byte that continues a character of UTF-8 is no column of its own.
            ++where_.column;
        }
    }
    void pass(std::string_view bytes) {
        for (const char byte : bytes) {
            pass(byte);
        }
    }

  private:
    Location where_{1, 1};
};

/// The places of one kind of mistake that is reported once.
class RepeatedMistake {
  public:
    void add(Location where) {
        first_ = lines_.empty() ? where : first_;
        if (lines_.empty() || lines_.back() != where.line) {
            lines_.push_back(where.line);
        }
    }
    bool empty() const { return lines_.empty(); }
    Location first() const { return first_; }
    /// ` (also in lines 3, 5, 8)`; empty if all are in one line.
    std::string further_lines() const;

  private:
    Location first_;
    std::vector<unsigned> lines_;
};

}  // namespace tribus
