#include <string>
#include <vector>

#include "tests/fuzz/fuzz.h"
#include "transports/codecs/dbc/file.h"
#include "transports/codecs/dbc/signal.h"

namespace tribus::fuzz::dbc_file_target {

/// A DBC text is refused with a place in it, or each of its signals can be read from a message and
/// written into one.
FUZZ_TARGET(dbc_file) {
    const std::string_view text = Input({data, size}).rest_as_text();
    const auto file = parse_dbc(text);
    if (!file) {
        const auto lines = 1 + static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n'));
        require(file.error().line >= 1 && file.error().line <= lines, "a mistake is in the file");
        require(file.error().column >= 1 && !file.error().text.empty(), "a mistake says what");
        return 0;
    }
    const std::vector<std::uint8_t> full(2048, 0xFF);
    for (const DbcMessage& message : file->messages) {
        const auto content = std::span(full).first(message.length);
        for (const DbcSignal& signal : message.signals) {
            const DbcLayout layout(signal);
            require(layout.needed_bytes() <= message.length, "a signal lies within its message");
            require(!signal.selector || *signal.selector < message.signals.size(),
                    "a selector is a signal of the message");
            const std::uint64_t bits = layout.raw_bits(content);
            layout.bits_from_physical(layout.physical(bits));
            std::vector<std::uint8_t> written(message.length);
            layout.set_raw_bits(written, bits);
            require(layout.raw_bits(written) == bits, "what is written can be read");
            present(message, signal, content);
        }
    }
    return 0;
}

}  // namespace tribus::fuzz::dbc_file_target
