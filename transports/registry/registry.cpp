#include "transports/registry/registry.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace tribus {

#define TRIBUS_ROW(name) extern const Protocol name;
#include "transports/registry/protocols.inc"
#undef TRIBUS_ROW
#define TRIBUS_ROW(name) extern const Medium name;
#include "transports/registry/media.inc"
#undef TRIBUS_ROW

#define TRIBUS_ROW(name) &(name),

std::span<const Protocol* const> protocols() {
    static constexpr std::array kProtocols{
#include "transports/registry/protocols.inc"
    };
    return kProtocols;
}

const Protocol* find_protocol(std::string_view name) {
    const auto found = std::ranges::find(protocols(), name, &Protocol::name);
    return found == protocols().end() ? nullptr : *found;
}

std::span<const Medium* const> media() {
    static constexpr std::array kMedia{
#include "transports/registry/media.inc"
    };
    return kMedia;
}

bool carries(const Medium& medium, const Protocol& protocol) {
    // F.Port, which tribus only reads, has questions and answers on its wire: a port that listens
    // in blocks finds too many pauses there.
    const bool inverted = protocol.line.inverted_wire && protocol.goes(SettingScope::both);
    return medium.shape == protocol.shape && (!medium.inverts || inverted) &&
           (protocol.only_on.empty() ? !medium.only_own_protocols
                                     : protocol.only_on == medium.name);
}

std::vector<const Medium*> media_for(const Protocol& protocol) {
    std::vector<const Medium*> found;
    std::ranges::copy_if(media(), std::back_inserter(found),
                         [&](const Medium* medium) { return carries(*medium, protocol); });
    return found;
}

}  // namespace tribus
