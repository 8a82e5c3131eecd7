#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "app/doctor/facts/finding.h"
#include "app/doctor/facts/serial_facts.h"
#include "app/doctor/line_advice.h"
#include "app/doctor/listening/line_judge.h"
#include "core/setting.h"
#include "transports/codecs/protocol.h"
#include "transports/links/serial/serial_medium.h"

/// Facts of `tribus init` about places (serial devices, SPI ports and CAN interfaces), and its
/// decisions. Pure.
namespace tribus::init {

/// The value of `--in` or `--out`.
struct PlaceOption {
    std::string place;                   ///< a serial device, an SPI port or a CAN interface
    const Protocol* protocol = nullptr;  ///< null: not named
};

/// The protocols for which `init` can write an input or output: those without required keys, which
/// only the user knows. In the order of the registry.
std::vector<const Protocol*> offered_protocols(SettingScope way);
std::vector<const Protocol*> offered_protocols(SettingScope way, const Medium& medium);

/// Reads `PLACE` or `PLACE=PROTOCOL`. If the protocol is named, the place may contain "=" too. The
/// error does not name the option.
tl::expected<PlaceOption, std::string> parse_place_option(std::string_view text, SettingScope way);

/// What is known about a place.
struct ExaminedPlace {
    const Medium* medium = &kSerialMedium;
    std::string name;  ///< for the configuration; of a USB adapter the stable name
    std::string node;  ///< "/dev/ttyUSB0"; for an interface its name
    std::string kind;  ///< for people: "USB adapter FTDI FT232R"
    /// False: a name without a slash that no interface and no device has.
    bool known = true;
    /// Why `init` writes no lines for a gamepad, a PWM chip or /dev/uinput, and who does.
    std::string other_end{};
    doctor::SerialFacts facts{};  ///< serial devices only
    /// About the port, and about the line if `init` listened to it.
    std::vector<doctor::Finding> findings{};
    std::optional<doctor::LineStory> story{};

    /// Whether no finding prevents its use now.
    bool usable() const;
    /// Why its hardware cannot run the protocol; empty if no reason is known.
    std::string refusal(const Protocol& protocol) const;
};

/// An input or output of the configuration.
struct Attachment {
    const Protocol* protocol = nullptr;
    const Medium* medium = &kSerialMedium;
    std::string name;  ///< the device or interface, as written in the configuration
    std::string node;
    /// Keys whose defaults do not fit the line.
    std::vector<doctor::HeardKey> keys{};
    std::vector<std::string> remarks{};  ///< about the line, one paragraph each
    std::size_t channels = 0;            ///< number of channels heard; 0: unknown
};

/// Decision about a place: the attachment, or why it is refused, and findings for the user. Those
/// of a refusal do not name the place: the caller names it.
struct Decision {
    tl::expected<Attachment, std::string> attachment;
    std::vector<doctor::Finding> findings;
};

/// Protocol where none is named and none can be heard: SBUS, on an interface the native format.
const Protocol& usual_protocol(WireShape shape);

/// Decides about an input at this place. Without a named protocol, it has the protocol that was
/// heard; where `init` does not listen, the usual one. A fault that can be corrected without a
/// change of the configuration is a finding, any other a refusal: a sentence that does not name the
/// place.
Decision decide_input(const ExaminedPlace& examined, const Protocol* named);

/// Decides about an output at this place, with the usual protocol if none is named. `trial`: why
/// the port did not accept the settings of the protocol; empty if it did, or was not opened.
Decision decide_output(const ExaminedPlace& examined, const Protocol* named,
                       std::string_view trial);

/// Whether the named protocol can run on no place of this kind, such as SBUS on a CAN interface.
bool is_wrong_kind(const ExaminedPlace& examined, const Protocol* named);

/// Why this attachment and one of the others cannot share a device: rate or parity differ, or it is
/// an SPI port. Empty if there is no such conflict.
std::string port_conflict(const std::vector<Attachment>& others, const Attachment& one);

}  // namespace tribus::init
