#include "tests/sim/can_chain.h"

#include <algorithm>

#include <fmt/format.h>

namespace tribus::test {
namespace {

std::string sender_configuration(const ChainSettings& settings) {
    return fmt::format(R"([input.receiver]
protocol  = "ibus"
device    = "/dev/ttyAMA5"
[output.bus]
protocol  = "{}"
interface = "can0"
period    = "7ms"
{}
{}
[pipeline.main]
from = "receiver"
to   = "bus"
)",
                       settings.protocol, settings.format, settings.sender_lines);
}

std::string reader_configuration(const ChainSettings& settings) {
    return fmt::format(R"([input.bus]
protocol  = "{}"
interface = "can0"
{}
[output.servos]
protocol  = "sbus"
device    = "/dev/ttyAMA3"
period    = "7ms"
[pipeline.main]
from = "bus"
to   = "servos"
)",
                       settings.protocol, settings.format);
}

/// Returns what the reader's interface receives, in the order of arrival.
std::vector<ReceivedCanFrame> carry(const std::vector<WrittenToCan>& written,
                                    const ChainSettings& settings) {
    CanFaultInjector faults(settings.faults, settings.seed);
    std::vector<ReceivedCanFrame> heard;
    for (const WrittenToCan& snapshot : written) {
        Instant arrival = snapshot.at;
        for (std::size_t i = 0; i < snapshot.count; ++i) {
            arrival += kCanFrameTime;
            CanReception out;
            faults.apply({.frame = snapshot.frames[i], .at = arrival}, out);
            for (const ReceivedCanFrame& frame : out.view()) {
                if (frame.at < settings.bus_dies || frame.at >= settings.bus_returns) {
                    heard.push_back(frame);
                }
            }
        }
    }
    std::ranges::stable_sort(heard, {}, &ReceivedCanFrame::at);
    return heard;
}

}  // namespace

CanChain::CanChain(const ChainSettings& settings)
    : a_(configuration_of(sender_configuration(settings)),
         {Sender{.last = settings.input_ends, .faults = {}}}, settings.seed),
      b_(configuration_of(reader_configuration(settings)), {}, settings.seed) {
    a_.run_until(settings.end);
    for (const ReceivedCanFrame& heard : carry(a_.written_to_can(), settings)) {
        b_.receive(0, heard.frame, heard.at);
    }
    b_.run_until(settings.end);
}

Duration CanChain::age(const Written& written) const {
    return written.at - *a_.arrived_at(0, *written.number);
}

bool whole(const Written& written) {
    if (!written.number) {
        return false;
    }
    const ChannelFrame sent = numbered_frame(*written.number);
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        if (written.frame.channel_or(channel, Pulse{}).whole_microseconds() !=
            sent.channel(channel)->whole_microseconds()) {
            return false;
        }
    }
    return true;
}

}  // namespace tribus::test
