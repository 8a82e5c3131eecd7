#include <array>
#include <chrono>
#include <memory>
#include <vector>

#include "transports/codecs/authenticated/broadcast_ends.h"
#include "transports/codecs/authenticated/link_settings.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/network/network.h"

namespace tribus {
namespace {

constexpr std::array kNetworkSettings{authenticated::kKeySetting, authenticated::kOldKeySetting,
                                      authenticated::kLinkSetting, authenticated::kEpochSetting};
constexpr std::array kNetworkBeginnings{FrameBeginning{network::kFirstByte, network::kSecondByte}};
constexpr CanChannelsFormat kMessages{.fd = true};

std::optional<LinkWithKey> network_link(const SettingValues& settings) {
    return authenticated::link_of(settings, "network");
}

std::vector<SettingMistake> check_network(const SettingValues& settings, SettingScope /*scope*/) {
    std::vector<SettingMistake> mistakes;
    authenticated::check_link(settings, mistakes);
    return mistakes;
}

/// The ids are of no meaning here, but must differ.
authenticated::FdLink in_datagrams(const LinkWithKey& link) {
    // An answer is a datagram, to whom the latest one came from.
    return {.keys = link, .sender_id = 1, .receiver_id = 0, .answers = 1};
}

AnyDecoder make_network_decoder(const SettingValues& settings) {
    std::unique_ptr<CanDecoder> messages;
    if (const auto link = network_link(settings)) {
        messages = authenticated::make_fd_decoder(in_datagrams(*link));
    } else {
        messages = std::make_unique<CanChannelsDecoder>(kMessages);
    }
    return std::make_unique<NetworkDecoder>(std::move(messages));
}

AnyEncoder make_network_encoder(const SettingValues& settings) {
    std::unique_ptr<CanEncoder> messages;
    if (const auto link = network_link(settings)) {
        messages = authenticated::make_fd_encoder(in_datagrams(*link));
    } else {
        messages = std::make_unique<CanChannelsEncoder>(kMessages);
    }
    return std::make_unique<NetworkEncoder>(std::move(messages));
}

}  // namespace

// The way over a network takes tens of milliseconds, and loses several datagrams in a row.
const Protocol kNetworkProtocol{
    .name = "network",
    .title = "Network",
    .description = "18 channels in UDP datagrams between two boxes, proved by a key",
    .only_on = "UDP",
    .line = {.baud = 115200, .parity = Parity::none, .stop_bits = 1},
    .beginnings = kNetworkBeginnings,
    .settings = kNetworkSettings,
    .longest_frame = network::kLongestFrame,
    .default_period = std::chrono::milliseconds(20),
    .least_period = std::chrono::milliseconds(2),
    .default_timeout = std::chrono::milliseconds(500),
    .signals_failsafe = always_signals_failsafe,
    .check = check_network,
    .link_with_key = network_link,
    .make_decoder = make_network_decoder,
    .make_encoder = make_network_encoder,
};

}  // namespace tribus
