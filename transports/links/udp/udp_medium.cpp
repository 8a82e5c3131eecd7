#include "transports/links/udp/udp_medium.h"

#include <array>

#include "transports/links/udp/udp_link.h"

namespace tribus {
namespace {

constexpr std::array kUdpSettings{
    Setting{.key = "public",
            .type = SettingType::boolean,
            .fallback = "false",
            .help = "`true`: allows an `address` outside of this machine. UDP has no password: who "
                    "reaches the address of an input moves the servos",
            .example = "true"},
    Setting{.key = "sender",
            .type = SettingType::text,
            .absent = "everybody",
            .scope = SettingScope::input,
            .help = "IP address whose datagrams are read; those of others are dropped. Who can "
                    "forge an address on your network still gets in",
            .example = "\"127.0.0.1\""},
};

std::vector<SettingMistake> check(const std::string& place, const SettingValues& settings,
                                  SettingScope /*way*/, KeyUse key) {
    const auto address = parse_udp_address(place);
    if (!address) {
        return {{{"address"},
                 "\"address\" is \"" + place + "\": " + address.error() +
                     "; allowed: an IP address in digits and a port from 1 to 65535, such as "
                     "\"127.0.0.1:5501\" or \"[::1]:5501\""}};
    }
    if (!address->loopback && key == KeyUse::possible) {
        return {{{"address"},
                 "\"address\" is \"" + place +
                     "\", outside of this machine; allowed: a loopback address, such as "
                     "\"127.0.0.1:5501\", or add a \"key\" (`tribus key new` makes one)"}};
    }
    if (!address->loopback && key == KeyUse::impossible && !settings.get_or("public", false)) {
        return {{{"address"},
                 "\"address\" is \"" + place +
                     "\", outside of this machine; allowed: a loopback address, such as "
                     "\"127.0.0.1:5501\", or add public = true (UDP has no password: who reaches "
                     "an input moves the servos)"}};
    }
    const auto* sender = settings.find_as<std::string>("sender");
    if (sender == nullptr) {
        return {};
    }
    const auto from = parse_udp_address(*sender + ":1");
    if (!from || from->storage.ss_family != address->storage.ss_family) {
        return {{{"sender"},
                 "\"sender\" is \"" + *sender +
                     "\"; allowed: an IP address in digits without a port, of the same version as "
                     "\"address\", such as \"127.0.0.1\" or \"[::1]\""}};
    }
    return {};
}

bool reaches(const std::string& sent_to, const std::string& heard_at) {
    const auto to = parse_udp_address(sent_to);
    const auto at = parse_udp_address(heard_at);
    return to && at && is_delivered(*to, *at);
}

}  // namespace

constinit const Medium kUdpMedium{
    .name = "UDP",
    .shape = WireShape::bytes,
    .place = {.key = "address",
              .required = true,
              .help = "IP address and port for UDP, one frame a datagram: an input receives there, "
                      "an output sends there",
              .example = "\"127.0.0.1:5501\""},
    .place_absent = "required on UDP",
    .settings = kUdpSettings,
    .check = check,
    .has_datagrams = true,
    .users = Users::one,
    .silence = {.nothing = "no datagram yet; check that its sender runs, that it sends to this "
                           "address and port, and what `sender` and a firewall let pass",
                .no_frame = "but no frame yet; check that the sender uses the same protocol, and "
                            "sends whole frames in a datagram",
                .counts = "byte"},
    .is_missing = UdpLink::is_missing,
    .reaches = reaches,
    .open =
        [](const std::string& address, const LinkUse& use) {
            return as_link(
                UdpLink::open(address, use.way, use.settings.get_or("sender", std::string())));
        },
};

}  // namespace tribus
