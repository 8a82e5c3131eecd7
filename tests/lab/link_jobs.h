#pragma once

#include <cstdint>
#include <string>

#include "tests/lab/two_programs.h"

namespace tribus::test {

inline constexpr std::uint16_t kLinkPort = 5700;
inline const std::string kKeyLine = "\nkey = \"@boat.key\"";
inline const BusJob kFdBus{.format = "protocol = \"can\"\nfd = true"};
inline const BusJob kClassicBus{.format = "protocol = \"can\""};
inline const BusJob kUdp{
    .sender_interface = "",
    .reader_interface = "",
    .format = "protocol = \"network\"\naddress = \"127.0.0.1:" + std::to_string(kLinkPort) + "\""};

/// The same job with a key for the link.
inline BusJob with_key(BusJob job) {
    job.format += kKeyLine;
    return job;
}

}  // namespace tribus::test
