#include "transports/codecs/dbc/file.h"

#include <algorithm>

#include "transports/codecs/dbc/resolve.h"
#include "transports/codecs/dbc/statements.h"

namespace tribus {
namespace {

template <class Named>
const Named* find_named(const std::vector<Named>& all, std::string_view name) {
    const auto found = std::find_if(all.begin(), all.end(),
                                    [&](const Named& named) { return named.name == name; });
    return found == all.end() ? nullptr : &*found;
}

}  // namespace

const DbcSignal* DbcMessage::find(std::string_view signal_name) const {
    return find_named(signals, signal_name);
}

const DbcMessage* DbcFile::find(std::string_view message_name) const {
    return find_named(messages, message_name);
}

tl::expected<DbcFile, DbcMistake> parse_dbc(std::string_view text) {
    if (text.size() > kLongestDbcText) {
        return tl::unexpected(DbcMistake{1, 1,
                                         "the text has " + std::to_string(text.size()) +
                                             " bytes; a DBC file has at most " +
                                             std::to_string(kLongestDbcText)});
    }
    if (text.starts_with("\xFF\xFE") || text.starts_with("\xFE\xFF")) {
        return tl::unexpected(
            DbcMistake{1, 1, "the text is UTF-16; save it as UTF-8 or as Windows-1252"});
    }
    return read_dbc_statements(text).map(resolve_dbc);
}

}  // namespace tribus
