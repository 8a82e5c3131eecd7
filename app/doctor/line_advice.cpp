#include "app/doctor/line_advice.h"

#include <algorithm>
#include <chrono>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/doctor/listening/line_heard.h"
#include "config/schema/notation.h"
#include "core/quotes.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/registry/registry.h"

namespace tribus::doctor {
namespace {

constexpr std::string_view kWiring =
    "circuits are in /usr/share/doc/tribus/docs/boards/wiring.md (docs/boards/ in the sources)";
/// Default timeout of an input.
constexpr Duration kUsualTimeout = std::chrono::milliseconds(100);
/// Threshold: one byte in a hundred belongs to no frame.
constexpr std::uint64_t kBadShare = 100;

std::string name_of(std::string_view protocol) {
    return std::string(find_protocol(protocol)->title);
}

std::string format_of(const LineSettings& line) {
    return fmt::format("{} baud 8{}{}", line.baud, line.parity == Parity::even ? 'E' : 'N',
                       line.stop_bits);
}

std::string milliseconds_of(Duration time) {
    constexpr double kMillisecond = 1e6;
    return fmt::format("{:.2f} ms", static_cast<double>(time.count()) / kMillisecond);
}

std::string seconds_text(Duration time) {
    return fmt::format("{:.1f} s", seconds_of(time));
}

std::string channels_of(const LineStory& story) {
    if (story.protocol != "sbus") {
        return fmt::format(", {} channels", story.channels);
    }
    return fmt::format("{}, 16 channels and 2 switches", story.sbus2 ? " (SBUS2)" : "");
}

std::string describe_frames(const LineStory& story) {
    std::string text = name_of(story.protocol);
    const bool sensor_bus = story.protocol == kSensorBusName;
    if (!sensor_bus) {
        text += channels_of(story);
    }
    text += fmt::format(", {}, not inverted as this port sees it", format_of(story.line));
    if (story.period) {
        text += fmt::format("; a {} each {}", sensor_bus ? "request" : "frame",
                            milliseconds_of(*story.period));
    }
    text += fmt::format("; {} frames in {}", story.frames, seconds_text(story.listened));
    if (sensor_bus) {
        text += fmt::format(", {} requests and {} replies", story.requests, story.replies);
    }
    text += story.lost_bytes == 0
                ? ", nothing else"
                : fmt::format(", {} of {} bytes in no frame", story.lost_bytes, story.bytes);
    if (story.least_us && story.most_us) {
        text += fmt::format("; values from {:.0f} to {:.0f} us{}", *story.least_us, *story.most_us,
                            story.protocol == "sbus" ? " in the default scale" : "");
    }
    return text;
}

Finding finding(Severity severity, std::string_view id, std::string what, std::string why,
                std::string fix) {
    return {severity, id, {}, std::move(what), std::move(why), std::move(fix)};
}

Finding inverted(const LineStory& story) {
    const bool needs_inverter = find_protocol(story.protocol)->line.inverted_wire;
    return finding(
        Severity::problem, "line.inverted",
        fmt::format("{} is on it, but inverted", name_of(story.protocol)),
        "Linux has no setting that inverts a line.",
        needs_inverter
            ? fmt::format("Put an inverter between the receiver and RX: a gate 74LVC1G04, a "
                          "transistor, or an FTDI FT232R whose EEPROM inverts RXD; {}.",
                          kWiring)
            : fmt::format("{} needs no inverter: remove it, or set the receiver's output to "
                          "not inverted. If an FTDI adapter was set to invert for SBUS, set it "
                          "back or use another one.",
                          name_of(story.protocol)));
}

Finding wrong_parity(const LineStory& story) {
    const bool sbus = story.protocol == "sbus";
    return finding(Severity::problem, "line.wrong_parity",
                   fmt::format("{} is on it, but {}", name_of(story.protocol),
                               sbus ? "without the even parity bit" : "with a parity bit"),
                   "Every frame is rejected; without this rule a disturbed one could move a servo.",
                   sbus ? "Set the sender to 8 data bits, even parity, 2 stop bits. (Receivers do "
                          "that by default; home-made programs often do not.)"
                        : "Set the sender to 8 data bits without parity, 1 stop bit.");
}

Finding low_line(const LineStory& story) {
    const std::string regular =
        story.period ? fmt::format(" and something comes each {}", milliseconds_of(*story.period))
                     : std::string();
    return finding(Severity::problem, "line.low",
                   fmt::format("the line is low most of the time{}", regular),
                   "An idle line is high. It is low if an SBUS line has no inverter or one too "
                   "many, or if nothing drives the wire.",
                   fmt::format("With the receiver on, a voltmeter at RX should show about 3 V. If "
                               "it shows about 0 V and this is SBUS, add an inverter; {}.",
                               kWiring));
}

Finding silence(const LineStory& story) {
    return finding(Severity::problem, "line.silence",
                   fmt::format("no byte came in {}", seconds_text(story.listened)), "",
                   "Is the receiver powered and bound, its output wired to RX (not TX) of this "
                   "port, ground to ground? Some receivers send nothing while the transmitter is "
                   "off: switch it on.");
}

Finding unknown(const LineStory& story) {
    return finding(
        Severity::problem, "line.unknown",
        fmt::format("{} bytes came, {} of them with errors, but no frame of a protocol that "
                    "tribus reads",
                    story.bytes, story.damaged),
        "It is another protocol (MAVLink, MSP), another rate, or a wire that picks up noise.",
        "Set the receiver's output to i.Bus, SBUS or CRSF at its usual rate. If it is set so: "
        "check ground and the wire, "
        "and give a recording to `tribus decode`.");
}

Finding ibus2() {
    return finding(Severity::problem, "line.ibus2", "i-BUS2 is on it, another protocol",
                   "An input of i.Bus cannot read it.",
                   "Set this output of the receiver to i.BUS (servo), in the transmitter's menu. "
                   "Beside an i-BUS2 device that asks for the key, `protocol = \"ibus2\"` reads "
                   "it.");
}

Finding sbus24() {
    return finding(Severity::problem, "line.sbus24",
                   "FrSky's SBUS with 24 channels is on it, whose frames have 36 bytes",
                   "An input of SBUS reads frames of 25 bytes only.",
                   "Set the receiver to SBUS with 16 channels, in the transmitter's menu.");
}

void judge_frames(const LineStory& story, std::vector<Finding>& findings) {
    if (kBadShare * story.lost_bytes > story.bytes) {
        findings.push_back(
            finding(Severity::advice, "line.disturbed",
                    fmt::format("{} of {} bytes belong to no frame, {} came with errors",
                                story.lost_bytes, story.bytes, story.damaged),
                    "Each error costs a frame.",
                    "Ground the receiver at the board, keep the wire short and away from motors, "
                    "and use a fast inverter."));
    }
    if (story.failsafe == story.frames && story.frames > 0) {
        findings.push_back(
            finding(Severity::advice, "line.failsafe", "every frame is marked failsafe",
                    "The receiver has no radio link.", "Switch the transmitter on, or bind it."));
    } else if (2 * story.frame_lost > story.frames) {
        findings.push_back(
            finding(Severity::advice, "line.frame_lost", "most frames are marked frame-lost",
                    "The radio link is weak; values are old.", "Check the antennas."));
    }
    if (story.protocol == "ibus" && story.requests > 0) {
        findings.push_back(
            finding(Severity::note, "line.shared", "requests of the sensor bus are on it, too",
                    "SERVO and SENS are joined on this wire.",
                    "Name the same device in [input.NAME] and in [sensor_bus.NAME]."));
    }
    if (story.protocol == kSensorBusName && story.replies > 0) {
        findings.push_back(finding(
            Severity::note, "line.sensors_answer", "sensors reply on it already",
            "Two sensors that reply at one address destroy each other's bytes.",
            "Set `address` above theirs, or only listen: `tribus decode --protocol ibus-sensor`."));
    }
    if (story.protocol == "sbus" && story.scale.name.empty()) {
        findings.push_back(
            finding(Severity::note, "line.scale_unknown", story.scale.reason, "", ""));
    }
}

}  // namespace

std::string describe(const LineStory& story) {
    switch (story.sound) {
        case LineSound::frames:
            return describe_frames(story);
        case LineSound::inverted:
        case LineSound::wrong_parity: {
            const std::string period =
                story.period ? fmt::format(", each {}", milliseconds_of(*story.period))
                             : std::string();
            return fmt::format(
                "{} at {} baud{}{}", name_of(story.protocol), story.line.baud,
                story.sound == LineSound::inverted ? ", inverted" : ", with another parity",
                period);
        }
        case LineSound::silence:
            return "nothing";
        case LineSound::breaks:
            return "a line that is low most of the time";
        case LineSound::ibus2:
            return "i-BUS2";
        case LineSound::sbus24:
            return fmt::format("FrSky's SBUS with 24 channels, {}; {} frames in {}",
                               format_of(story.line), story.frames, seconds_text(story.listened));
        case LineSound::unknown:
            break;
    }
    return "bytes of no known protocol";
}

std::vector<Finding> judge_story(const LineStory& story, const std::string& node) {
    std::vector<Finding> findings;
    switch (story.sound) {
        case LineSound::frames:
            judge_frames(story, findings);
            break;
        case LineSound::silence:
            findings.push_back(silence(story));
            break;
        case LineSound::wrong_parity:
            findings.push_back(wrong_parity(story));
            break;
        case LineSound::inverted:
            findings.push_back(inverted(story));
            break;
        case LineSound::breaks:
            findings.push_back(low_line(story));
            break;
        case LineSound::ibus2:
            findings.push_back(ibus2());
            break;
        case LineSound::sbus24:
            findings.push_back(sbus24());
            break;
        case LineSound::unknown:
            findings.push_back(unknown(story));
            break;
    }
    for (Finding& one : findings) {
        one.where = node;
    }
    return findings;
}

std::vector<HeardKey> heard_keys(const LineStory& story) {
    std::vector<HeardKey> keys;
    const Protocol* const protocol = find_protocol(story.protocol);
    if (protocol != nullptr && story.line.baud != protocol->line.baud) {
        keys.push_back({"baud", fmt::format("{}", story.line.baud)});
    }
    if (!story.scale.name.empty() && story.scale.name != "betaflight") {
        keys.push_back({"scale", in_quotes(story.scale.name)});
    }
    const Duration usual_timeout =
        protocol == nullptr ? kUsualTimeout : protocol->default_timeout.value_or(kUsualTimeout);
    if (story.period && 3 * *story.period > usual_timeout) {
        constexpr auto kStep = std::chrono::milliseconds(10);
        const auto steps = (3 * *story.period + kStep - Duration(1)) / kStep;
        keys.push_back({"timeout", in_quotes(format_duration(steps * kStep))});
    }
    return keys;
}

std::vector<std::string> configuration_lines(const LineStory& story, const std::string& device) {
    const bool readable = story.sound == LineSound::frames ||
                          (story.sound == LineSound::inverted && story.protocol != kSensorBusName);
    if (!readable) {
        return {};
    }
    if (story.protocol == kSensorBusName) {
        return {"[sensor_bus.telemetry]",
                fmt::format("device = {}", in_quotes(device)),
                "role   = \"sensor\"",
                "",
                "[[sensor_bus.telemetry.sensor]]",
                "type  = \"temperature\"",
                "value = \"machine.temperature\""};
    }
    std::vector<std::string> lines{"[input.receiver]",
                                   fmt::format("protocol = {}", in_quotes(story.protocol)),
                                   fmt::format("device   = {}", in_quotes(device))};
    for (const HeardKey& heard : heard_keys(story)) {
        lines.push_back(fmt::format("{:<8} = {}", heard.key, heard.value));
    }
    return lines;
}

}  // namespace tribus::doctor
