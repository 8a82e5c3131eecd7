#include "app/wire/frames/waveform.h"

#include <algorithm>
#include <bit>

namespace tribus {
namespace {

constexpr unsigned kDataBits = 8;

std::int64_t in_units(Duration time) {
    return (time + Waveform::kTimescale / 2) / Waveform::kTimescale;
}

}  // namespace

void Waveform::level(std::string& dump, Duration at, bool mark) {
    if (mark == mark_) {
        return;
    }
    mark_ = mark;
    dump += '#';
    dump += std::to_string(in_units(at));
    dump += mark != line_.inverted_wire ? "\n1!\n" : "\n0!\n";
}

void Waveform::begin(std::string& dump, Duration first_start) {
    moved_ = std::max(Duration::zero(), line_.bytes_time(1) - first_start);
    free_from_ = Duration::zero();
    mark_ = true;
    dump += "$timescale " + std::to_string(kTimescale.count()) + " ns $end\n";
    dump +=
        "$scope module tribus $end\n"
        "$var wire 1 ! wire $end\n"
        "$upscope $end\n"
        "$enddefinitions $end\n"
        "#0\n";
    dump += line_.inverted_wire ? "0!\n" : "1!\n";
}

void Waveform::byte(std::string& dump, Duration frame_start, std::uint64_t bit,
                    std::uint8_t value) {
    const auto next_level = [&](bool mark) {
        level(dump, frame_start + line_.bits_time(bit++), mark);
    };
    next_level(false);
    for (unsigned data = 0; data < kDataBits; ++data) {
        next_level(((value >> data) & 1U) != 0);
    }
    if (line_.parity == Parity::even) {
        next_level(std::popcount(value) % 2 != 0);
    }
    next_level(true);
}

void Waveform::frame(std::string& dump, Duration start, std::span<const std::uint8_t> bytes) {
    const Duration wanted = start + moved_;
    const Duration begin = std::max(wanted, free_from_);
    delayed_ += begin - wanted >= line_.bytes_time(1) ? 1U : 0U;
    for (std::size_t index = 0; index < bytes.size(); ++index) {
        byte(dump, begin, index * line_.bits_per_byte(), bytes[index]);
    }
    free_from_ = begin + line_.bytes_time(bytes.size());
}

void Waveform::end(std::string& dump) const {
    dump += '#';
    dump += std::to_string(in_units(free_from_ + line_.bytes_time(1)));
    dump += '\n';
}

}  // namespace tribus
