#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <vector>

/// The plain form of the DSM decoder: it sees the whole line, and keeps numbers of channels instead
/// of masks. Tests compare the fast decoder with it. Sources: docs/protocols/dsm.md.
namespace tribus::reference {

/// Bytes that were read together. Times in ms.
struct PlainDsmRead {
    std::vector<std::uint8_t> bytes;
    bool pause_before = false;
    double at = 0;
};

/// A frame that counts. Channels by their number, from 0; values of 11 bits.
struct PlainDsmFrame {
    std::size_t at = 0;
    std::map<unsigned, unsigned> values;
};

class PlainDsm {
  public:
    explicit PlainDsm(unsigned bits = 0) : bits_(bits) {}

    std::vector<PlainDsmFrame> frames_of(const std::vector<PlainDsmRead>& reads) {
        for (const PlainDsmRead& read : reads) {
            if (read.pause_before) {
                pause();
            }
            for (const std::uint8_t byte : read.bytes) {
                line_.push_back(byte);
                byte_came(read.at);
            }
        }
        return found_;
    }

  private:
    /// Each word as a number of a channel (with a phase: 100 more), unused, or an extension.
    static constexpr int kUnused = -1;
    static constexpr int kExtension = -2;
    using Places = std::vector<int>;
    struct Met {
        Places places;
        unsigned bits = 0;
        double at = 0;
        bool counts = false;
    };

    static std::optional<Places> places_of(std::span<const std::uint8_t> frame, unsigned bits) {
        Places places;
        std::set<unsigned> seen;
        for (std::size_t word = 0; word < 7; ++word) {
            unsigned value = frame[2 + 2 * word] * 256U + frame[3 + 2 * word];
            if (value == 65535) {
                places.push_back(kUnused);
                continue;
            }
            const bool phase = word == 0 && value >= 32768;
            value -= phase ? 32768 : 0;
            const unsigned number = value / (bits == 10 ? 1024 : 2048);
            if (bits == 11 && word > 0 && number % 16 == 12) {
                places.push_back(kExtension);
                continue;
            }
            if (number > (bits == 10 ? 6U : 11U) || !seen.insert(number).second) {
                return std::nullopt;
            }
            places.push_back(static_cast<int>(number) + (phase ? 100 : 0));
        }
        const std::size_t least = bits == 10 ? 5 : 1;
        if (seen.size() < least || std::ranges::count(places, kExtension) > 2) {
            return std::nullopt;
        }
        return places;
    }
    std::optional<Met> look(std::span<const std::uint8_t> frame) const {
        for (const unsigned bits : {11U, 10U}) {
            if (bits_ == 0 || bits_ == bits) {
                if (auto places = places_of(frame, bits)) {
                    return Met{*places, bits};
                }
            }
        }
        return std::nullopt;
    }
    static bool alike(const Met& one, const Met& other) {
        for (std::size_t word = 0; word < 7; ++word) {
            const int a = one.places[word];
            const int b = other.places[word];
            if (a != b && a != kExtension && b != kExtension) {
                return false;
            }
        }
        return one.bits == other.bits;
    }
    static std::set<int> numbers(const Met& met) {
        std::set<int> all;
        for (const int place : met.places) {
            if (place >= 0) {
                all.insert(place % 100);
            }
        }
        return all;
    }
    static bool has_primaries(const std::set<int>& all) {
        return all.contains(0) && all.contains(1) && all.contains(2) && all.contains(3);
    }

    /// A row that pauses may show to go on.
    struct OldRow {
        std::set<int> numbers;
        std::set<Places> counting;
    };

    void new_row() {
        if (row_ >= 2) {
            old_row_ = OldRow{in_row_, {}};
            for (const Met& met : met_) {
                if (met.counts) {
                    old_row_->counting.insert(met.places);
                }
            }
        }
        row_ = 0;
        in_row_.clear();
        for (Met& met : met_) {
            met.counts = false;
        }
    }
    void forget() {
        new_row();
        met_.clear();
        old_row_.reset();
        needs_pause_ = false;
    }
    void pause() {
        if (needs_pause_ && aligned_ && line_.size() - begin_ == 16) {
            needs_pause_ = false;
            frame_came(waits_since_);
        } else if (begin_ != line_.size()) {
            new_row();
        }
        begin_ = line_.size();
        const std::size_t burst = begin_ - burst_begin_;
        burst_begin_ = begin_;
        aligned_ = true;
        if (burst % 16 != 0 && old_row_ && row_ < 2) {
            row_ = 2;
            in_row_ = old_row_->numbers;
            for (Met& met : met_) {
                met.counts = old_row_->counting.contains(met.places);
            }
            needs_pause_ = true;
        }
        if (burst != 0) {
            old_row_.reset();
        }
    }
    /// Whether the 16 bytes from `begin_` on count with the pause behind them.
    bool waits(double at) {
        const auto frame = std::span(line_).subspan(begin_, 16);
        const auto now = look(frame);
        const bool in_row = now && std::ranges::any_of(met_, [&](const Met& met) {
                                return met.counts && met.places == now->places;
                            });
        if (in_row && at - latest_ <= 100 && line_.size() - begin_ == 16) {
            waits_since_ = at;
            return true;
        }
        needs_pause_ = false;
        new_row();
        return false;
    }
    void byte_came(double at) {
        if (aligned_ && line_.size() - begin_ >= 16 && !(needs_pause_ && waits(at))) {
            frame_came(at);
            begin_ += 16;
        }
        if (!aligned_ && line_.size() - begin_ == 79) {
            search(at);
        }
    }
    void search(double at) {
        std::vector<std::size_t> places;
        for (std::size_t start = begin_; start < begin_ + 16; ++start) {
            if (proven(start)) {
                places.push_back(start);
            }
        }
        if (places.size() != 1) {
            begin_ += 16;
            return;
        }
        forget();
        begin_ = places.front();
        const std::size_t before = found_.size();
        for (int frame = 0; frame < 4; ++frame) {
            found_.resize(before);  // Only the last of the four counts.
            frame_came(at);
            begin_ += 16;
        }
        aligned_ = true;
    }
    bool proven(std::size_t start) const {
        std::vector<Met> all;
        for (std::size_t frame = 0; frame < 4; ++frame) {
            const auto bytes = std::span(line_).subspan(start + 16 * frame, 16);
            const auto met = look(bytes);
            const unsigned system = bytes[1];
            if (!met || system != line_[start + 1] ||
                (met->bits == 10 ? system != 0x01
                                 : system != 0x12 && system != 0xA2 && system != 0xB2)) {
                return false;
            }
            all.push_back(*met);
        }
        std::set<int> both = numbers(all[2]);
        both.merge(numbers(all[3]));
        return (alike(all[2], all[0]) || alike(all[2], all[1])) &&
               (alike(all[3], all[0]) || alike(all[3], all[1])) && has_primaries(both);
    }
    /// The 16 bytes from `begin_` on.
    void frame_came(double at) {
        const auto bytes = std::span(line_).subspan(begin_, 16);
        if (at - latest_ > 100) {
            forget();
        }
        auto now = look(bytes);
        if (!now) {
            new_row();
            aligned_ = false;
            return;
        }
        latest_ = at;
        if (std::ranges::any_of(met_, [&](const Met& met) { return met.bits != now->bits; })) {
            forget();
        }
        const bool agrees = std::ranges::any_of(met_, [&](const Met& m) { return alike(m, *now); });
        now->at = at;
        now->counts = agrees;
        std::erase_if(met_, [&](const Met& met) { return met.places == now->places; });
        met_.push_back(*now);
        while (met_.size() > 4) {
            met_.pop_front();
        }
        if (!agrees) {
            new_row();
            aligned_ = false;
            return;
        }
        ++row_;
        in_row_.merge(numbers(*now));
        for (std::size_t word = 0; word < 7; ++word) {
            if (now->places[word] >= 0) {
                const unsigned value = bytes[2 + 2 * word] * 256U + bytes[3 + 2 * word];
                values_[static_cast<unsigned>(now->places[word] % 100)] =
                    now->bits == 10 ? value % 1024 * 2 : value % 2048;
            }
        }
        if (row_ >= 2 && has_primaries(in_row_)) {
            give(at);
        }
    }
    void give(double at) {
        std::set<int> fresh;
        for (const Met& met : met_) {
            if (met.counts && at - met.at <= 100) {
                fresh.merge(numbers(met));
            }
        }
        PlainDsmFrame frame{begin_, {}};
        for (const int number : fresh) {
            frame.values[static_cast<unsigned>(number)] = values_[static_cast<unsigned>(number)];
        }
        found_.push_back(frame);
    }

    unsigned bits_;
    std::vector<std::uint8_t> line_;
    std::size_t begin_ = 0;
    bool aligned_ = false;
    std::size_t burst_begin_ = 0;
    bool needs_pause_ = false;
    double waits_since_ = 0;
    std::optional<OldRow> old_row_;
    int row_ = 0;
    std::set<int> in_row_;
    std::deque<Met> met_;
    double latest_ = 0;
    std::map<unsigned, unsigned> values_;
    std::vector<PlainDsmFrame> found_;
};

}  // namespace tribus::reference
