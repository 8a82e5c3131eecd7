#include <algorithm>
#include <chrono>
#include <cstddef>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "transports/codecs/dbc/channel.h"
#include "transports/codecs/dbc/dbc.h"

namespace tribus {
namespace {

/// The signal of the part that ends last, and its least length of a frame.
struct LastSignal {
    std::string_view name;
    std::size_t needs = 0;
};

void look_at(LastSignal& last, std::string_view name, const DbcLayout& layout) {
    if (layout.needed_bytes() > last.needs) {
        last = {name, layout.needed_bytes()};
    }
}

LastSignal last_signal(const DbcMap& map, std::size_t message) {
    LastSignal last;
    for (const DbcPart& part : map.parts) {
        if (part.message != message) {
            continue;
        }
        for (const DbcChannel& channel : part.channels) {
            look_at(last, channel.signal, channel.layout);
        }
        for (const DbcFixed& fixed : part.fixed) {
            look_at(last, fixed.signal, fixed.layout);
        }
    }
    return last;
}

template <class... Values>
std::size_t write(std::span<char> text, fmt::format_string<Values...> form, Values&&... values) {
    const auto result =
        fmt::format_to_n(text.data(), text.size(), form, std::forward<Values>(values)...);
    return std::min<std::size_t>(result.size, text.size());
}

}  // namespace

std::size_t DbcDecoder::write_fault(std::span<char> text) const {
    for (std::size_t i = 0; i < parts_.size(); ++i) {
        const PartState& part = parts_[i];
        const std::string_view message = map_.messages[map_.parts[i].message].name;
        if (part.without_value != nullptr) {
            const std::size_t head =
                write(text, "message {:.40}, signal {:.40}: ", message, part.without_value->signal);
            return head + write_dbc_absence(*part.without_value, part.bits, text.subspan(head));
        }
        if (part.wrong_fixed != nullptr) {
            const DbcFixed& fixed = *part.wrong_fixed;
            return write(text, "message {:.40}, signal {:.40}: {} came, but it is fixed to {}",
                         message, fixed.signal, fixed.layout.physical(part.bits),
                         fixed.layout.physical(fixed.bits));
        }
    }
    if (absent_part_) {
        using Milliseconds = std::chrono::duration<double, std::milli>;
        return write(text, "message {:.40}: it has not come for {} ms",
                     map_.messages[map_.parts[*absent_part_].message].name,
                     Milliseconds(parts_[*absent_part_].longest_absence).count());
    }
    for (std::size_t i = 0; i < messages_.size(); ++i) {
        if (messages_[i].wrong_length) {
            const LastSignal last = last_signal(map_, i);
            return write(text,
                         "message {:.40}: a frame has {} bytes, but the DBC file gives it {}; "
                         "signal {:.40} needs byte {}",
                         map_.messages[i].name, *messages_[i].wrong_length, map_.messages[i].length,
                         last.name, last.needs);
        }
    }
    return 0;
}

}  // namespace tribus
