#include "app/init/attachment.h"

#include <algorithm>
#include <iterator>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/doctor/examine.h"
#include "app/doctor/port_kind.h"
#include "config/language/protocol_words.h"
#include "core/quotes.h"
#include "transports/codecs/gamepad/gamepad.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"
#include "transports/links/spi/spi_serial_medium.h"
#include "transports/registry/registry.h"

namespace tribus::init {
namespace {

using doctor::Finding;
using doctor::LineSound;
using doctor::LineStory;
using doctor::Severity;
using Refused = tl::unexpected<std::string>;

std::vector<std::string_view> required_keys(const Protocol& protocol, SettingScope way) {
    std::vector<std::string_view> keys;
    for (const Setting& setting : protocol.settings) {
        if (setting.required && (setting.scope == SettingScope::both || setting.scope == way)) {
            keys.push_back(setting.key);
        }
    }
    return keys;
}

/// Whether it runs on a kind of place that `init` looks at.
bool has_place(const Protocol& protocol) {
    return carries(kSerialMedium, protocol) || carries(kCanMedium, protocol) ||
           carries(kSpiSerialMedium, protocol);
}

std::vector<std::string_view> offered_names(SettingScope way) {
    std::vector<std::string_view> names;
    std::ranges::transform(offered_protocols(way), std::back_inserter(names), &Protocol::name);
    return names;
}

/// Why a word is not allowed as the protocol of an input or output.
std::string protocol_refusal(std::string_view word, SettingScope way) {
    const Protocol* const protocol = find_protocol(word);
    const auto allowed = offered_names(way);
    if (protocol == nullptr) {
        return fmt::format("there is no protocol {}; {}", in_quotes(word),
                           protocol_suggestion(word, allowed));
    }
    if (!protocol->goes(way)) {
        return fmt::format("{} cannot be {}; allowed: {}", word,
                           way == SettingScope::input ? "an input" : "an output",
                           fmt::join(allowed, ", "));
    }
    if (!has_place(*protocol)) {
        return fmt::format(
            "{} runs on {} only, and `init` writes lines for serial devices, SPI ports and CAN "
            "interfaces; {}; allowed here: {}",
            word, media_for(*protocol).front()->name,
            protocol == &kGamepadProtocol ? "`tribus learn DEVICE` prints the lines of a gamepad"
                                          : "tribus.toml(5) describes its keys",
            fmt::join(allowed, ", "));
    }
    const auto keys = required_keys(*protocol, way);
    const std::string needs = keys.empty() ? std::string("keys that say what it sends")
                                           : fmt::format("the keys {}", fmt::join(keys, " and "));
    return fmt::format(
        "{} needs {}, which only you know; allowed here: {}. For {}, start from an example in "
        "/usr/share/doc/tribus/examples",
        word, needs, fmt::join(allowed, ", "), word);
}

/// Why the protocol does not run on this kind of link; empty if it does.
std::string link_refusal(const ExaminedPlace& examined, const Protocol& protocol) {
    if (carries(*examined.medium, protocol)) {
        return {};
    }
    if (examined.medium == &kSpiSerialMedium) {
        return fmt::format("{} does not run on an SPI port; sbus does", protocol.name);
    }
    return examined.medium == &kSerialMedium
               ? fmt::format("{} runs on a CAN interface, such as can0; this is a serial device",
                             protocol.name)
               : fmt::format(
                     "{} runs on a serial device, such as /dev/ttyUSB0; this is a CAN interface",
                     protocol.name);
}

/// Why this place can never run the protocol; empty if no reason is known.
std::string permanent_refusal(const ExaminedPlace& examined, const Protocol& protocol) {
    if (!examined.other_end.empty()) {
        return examined.other_end;
    }
    const auto not_serial = std::ranges::find(examined.findings, "port.not_serial", &Finding::id);
    if (not_serial != examined.findings.end()) {
        return not_serial->what;
    }
    if (std::string refusal = link_refusal(examined, protocol); !refusal.empty()) {
        return refusal;
    }
    return examined.refusal(protocol);
}

std::string unknown_place(const ExaminedPlace& examined, const Protocol* named) {
    const bool named_for_can = named != nullptr && named->shape == WireShape::can_frames;
    if (examined.known || named_for_can) {
        return {};
    }
    return "there is no CAN interface and no serial device of this name; a serial device is a "
           "path, such as /dev/ttyUSB0";
}

/// Whether the line carries a known protocol with channels, which may need a correction.
bool has_channels(const LineStory& story) {
    const bool identified = story.sound == LineSound::frames ||
                            story.sound == LineSound::inverted ||
                            story.sound == LineSound::wrong_parity;
    const Protocol* const protocol = find_protocol(story.protocol);
    return identified && protocol != nullptr && protocol->goes(SettingScope::input);
}

/// Why the protocol of an input is not known from listening.
std::string why_not_heard(const ExaminedPlace& examined) {
    if (!examined.story) {
        const auto problem =
            std::ranges::find(examined.findings, Severity::problem, &Finding::severity);
        return problem == examined.findings.end() ? "tribus could not listen to it" : problem->what;
    }
    if (!examined.story->protocol.empty()) {
        return "this is the i.Bus sensor bus, which has no channels; connect the receiver's SERVO "
               "output";
    }
    return examined.story->sound == LineSound::silence ? "nothing was heard"
                                                       : "no known protocol was heard";
}

void take_story(const LineStory& story, Attachment& input) {
    if (story.sound == LineSound::silence) {
        return;
    }
    input.remarks.push_back("Heard: " + doctor::describe(story));
    if (story.protocol == input.protocol->name) {
        input.keys = doctor::heard_keys(story);
        input.channels = story.channels;
        if (!story.scale.name.empty()) {
            input.remarks.push_back("Scale: " + story.scale.reason);
        }
    }
}

/// The finding that another protocol was heard than the user named.
std::optional<Finding> contradiction(const ExaminedPlace& examined, const Protocol& named) {
    if (!examined.story || !has_channels(*examined.story) ||
        examined.story->protocol == named.name) {
        return std::nullopt;
    }
    return Finding{
        Severity::problem,
        "line.other_protocol",
        examined.node,
        fmt::format("{} was heard, not {}", examined.story->protocol, named.name),
        "",
        fmt::format("Set the receiver's output to {}, or name the protocol that was heard: {}={}",
                    named.name, examined.node, examined.story->protocol)};
}

/// The findings for the user. Notes about a port are among them only if they explain a refusal.
std::vector<Finding> findings_to_print(const std::vector<Finding>& findings, bool refused) {
    std::vector<Finding> printed;
    std::ranges::copy_if(findings, std::back_inserter(printed), [refused](const Finding& finding) {
        const bool explains =
            finding.id == "port.mini_uart" || finding.id == "port.quantised_rates";
        return finding.severity != Severity::note || finding.id.starts_with("line.") ||
               (refused && explains);
    });
    return printed;
}

Decision refused(const ExaminedPlace& examined, std::string why) {
    std::vector<Finding> findings = findings_to_print(examined.findings, true);
    for (Finding& finding : findings) {
        finding.where.clear();
    }
    return {Refused(std::move(why)), std::move(findings)};
}

/// A name that nothing has: what an interface of that name would need says nothing.
Decision refused_unknown(std::string why) {
    return {Refused(std::move(why)), {}};
}

Attachment attachment_of(const ExaminedPlace& examined, const Protocol& protocol) {
    return {.protocol = &protocol,
            .medium = examined.medium,
            .name = examined.name,
            .node = examined.node};
}

}  // namespace

std::vector<const Protocol*> offered_protocols(SettingScope way) {
    std::vector<const Protocol*> offered;
    std::ranges::copy_if(protocols(), std::back_inserter(offered), [way](const Protocol* one) {
        // An output without channels needs to be told what it sends.
        const bool carries_channels = way == SettingScope::input || one->needs_pipeline == nullptr;
        return one->goes(way) && has_place(*one) && carries_channels &&
               required_keys(*one, way).empty();
    });
    return offered;
}

std::vector<const Protocol*> offered_protocols(SettingScope way, const Medium& medium) {
    std::vector<const Protocol*> offered = offered_protocols(way);
    std::erase_if(offered, [&medium](const Protocol* one) { return !carries(medium, *one); });
    return offered;
}

tl::expected<PlaceOption, std::string> parse_place_option(std::string_view text, SettingScope way) {
    const std::size_t equals = text.rfind('=');
    PlaceOption option{.place = std::string(text.substr(0, equals))};
    if (option.place.empty()) {
        return Refused(
            "there must be a serial device or a CAN interface, such as /dev/ttyUSB0 or can0, or "
            "with a protocol /dev/ttyUSB0=ibus");
    }
    if (equals == std::string_view::npos) {
        return option;
    }
    const std::string_view word = text.substr(equals + 1);
    const auto offered = offered_protocols(way);
    const auto found = std::ranges::find(offered, word, &Protocol::name);
    if (found == offered.end()) {
        return Refused(protocol_refusal(word, way));
    }
    option.protocol = *found;
    return option;
}

bool ExaminedPlace::usable() const {
    return known && other_end.empty() && doctor::may_be_used(findings);
}

std::string ExaminedPlace::refusal(const Protocol& protocol) const {
    if (medium != &kSerialMedium || protocol.shape != WireShape::bytes || !facts.exists) {
        return {};
    }
    return doctor::hardware_refusal(doctor::kind_of(facts), facts, protocol.line).value_or("");
}

const Protocol& usual_protocol(WireShape shape) {
    return shape == WireShape::bytes ? kSbusProtocol : kCanProtocol;
}

Decision decide_input(const ExaminedPlace& examined, const Protocol* named) {
    if (std::string refusal = unknown_place(examined, named); !refusal.empty()) {
        return refused_unknown(std::move(refusal));
    }
    const Protocol* protocol = named;
    if (protocol == nullptr && examined.medium != &kSerialMedium) {
        protocol = &usual_protocol(examined.medium->shape);
    } else if (protocol == nullptr && examined.story && has_channels(*examined.story)) {
        protocol = find_protocol(examined.story->protocol);
    }
    if (protocol == nullptr) {
        return refused(examined,
                       examined.other_end.empty() ? why_not_heard(examined) : examined.other_end);
    }
    if (std::string refusal = permanent_refusal(examined, *protocol); !refusal.empty()) {
        return refused(examined, std::move(refusal));
    }
    Decision decision{attachment_of(examined, *protocol),
                      findings_to_print(examined.findings, false)};
    if (examined.story) {
        take_story(*examined.story, *decision.attachment);
    }
    if (auto finding = contradiction(examined, *protocol)) {
        decision.findings.push_back(*std::move(finding));
    }
    return decision;
}

Decision decide_output(const ExaminedPlace& examined, const Protocol* named,
                       std::string_view trial) {
    const Protocol& protocol = named != nullptr ? *named : usual_protocol(examined.medium->shape);
    if (std::string refusal = unknown_place(examined, named); !refusal.empty()) {
        return refused_unknown(std::move(refusal));
    }
    std::string refusal = permanent_refusal(examined, protocol);
    if (refusal.empty()) {
        refusal = trial;
    }
    if (!refusal.empty()) {
        return refused(examined, std::move(refusal));
    }
    return {attachment_of(examined, protocol), findings_to_print(examined.findings, false)};
}

bool is_wrong_kind(const ExaminedPlace& examined, const Protocol* named) {
    return named != nullptr && examined.known && examined.other_end.empty() &&
           !carries(*examined.medium, *named);
}

std::string port_conflict(const std::vector<Attachment>& others, const Attachment& one) {
    for (const Attachment& other : others) {
        const bool same_device = other.node == one.node &&
                                 one.protocol->shape == WireShape::bytes &&
                                 other.protocol->shape == WireShape::bytes;
        if (other.node == one.node && one.medium->users == Users::one) {
            return fmt::format("{} carries one input or one output; use another port", one.node);
        }
        if (same_device && other.protocol->line != one.protocol->line) {
            return fmt::format(
                "a port has one rate and parity, and those of {} and {} differ; use another port",
                other.protocol->name, one.protocol->name);
        }
    }
    return {};
}

}  // namespace tribus::init
