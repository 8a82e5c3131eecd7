#pragma once

#include <cstdint>
#include <string>
#include <utility>

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
/// The same job with a key, and a reader that does not answer. `folder`: where the ends keep their
/// numbers; by default that of the test.
inline BusJob with_epoch(BusJob job, const std::string& folder = "@") {
    job = with_key(std::move(job));
    job.sender_lines += "\nepoch = \"" + folder + "sender.epoch\"";
    job.reader_lines += "\nepoch = \"" + folder + "reader.epoch\"";
    return job;
}

}  // namespace tribus::test
