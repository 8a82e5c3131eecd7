#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

#include "core/can_frame.h"
#include "core/line_settings.h"
#include "core/setting.h"
#include "core/time.h"
#include "core/wire_shape.h"
#include "transports/links/link.h"
#include "transports/links/link_worker.h"

namespace tribus {

/// Needs of the users of one place. A medium reads the members that concern it.
struct LinkUse {
    LineSettings line = {};
    std::vector<CanIdMatch> wanted = {};  ///< ids that inputs read
    /// Ids that outputs send. Needed to receive confirmations and to notice other senders of these
    /// ids.
    std::vector<CanIdMatch> sent = {};
    bool fd = false;              ///< an input or output uses FD frames
    SettingValues settings = {};  ///< values of the medium's own keys
    /// On a medium with one user a place: input or output. Else both.
    SettingScope way = SettingScope::both;
    /// On a medium with a period: that of the output.
    Duration period{};
    /// For a link with a thread of its own.
    WorkerSettings worker = {};

    bool operator==(const LinkUse&) const = default;
};

/// Whether messages of a link are proved by a key.
enum class KeyUse : std::uint8_t {
    impossible,  ///< its protocol has no keys
    possible,    ///< its protocol has keys, the link has none
    given,       ///< nobody else can make its messages
};

/// Who may use one place of a medium at the same time.
enum class Users : std::uint8_t {
    one,           ///< one input or one output
    one_each_way,  ///< one input and one output, by the same link
    many,          ///< any number, and a link may be opened while another one is open
};

/// Where a person looks if an input does not come to life. Sentences that go on with what to do,
/// without the last full stop; empty on a medium that has no inputs.
struct SilenceAdvice {
    /// Nothing has come: "no byte yet; check wire, ground and power of the receiver".
    std::string_view nothing = {};
    /// What has come is no frame of the protocol; behind the count of what `counts` names.
    std::string_view no_frame = {};
    /// Noun for the units of what has come, if people can count them: "byte".
    std::string_view counts = {};
    /// Frames come, but the link does not count as good.
    std::string_view not_good = "is the transmitter on?";
    /// What `tribus doctor PLACE` does about it: "listens there". Empty: it does not know such
    /// places.
    std::string_view doctor = {};
};

/// A way to carry protocols, such as serial ports. Each medium is a line of the table in
/// transports/registry/media.inc. No function may be called on the data path.
struct Medium {
    /// A noun for the manual: "`device` on NAME".
    std::string_view name;
    /// It carries protocols of this shape.
    WireShape shape = WireShape::bytes;
    /// Of these only the protocols that name it (Protocol::only_on).
    bool only_own_protocols = false;
    /// It inverts the wire itself. It carries only protocols with such a wire
    /// (LineSettings::inverted_wire) that have inputs and outputs.
    bool inverts = false;
    /// The key of an input or output that names the place: a device, an interface.
    Setting place;
    /// The default of that key in the manual: "required on CAN".
    std::string_view place_absent;
    /// Whether places are paths of device files.
    bool place_is_path = false;
    /// Further keys of an input or output on this medium.
    std::span<const Setting> settings = {};
    /// Which of them names the GPIO line of an output's freshness wave. Empty: none.
    std::string_view enable_key = {};
    /// Errors in the place and in valid settings. Null: none possible.
    std::vector<SettingMistake> (*check)(const std::string& place, const SettingValues& settings,
                                         SettingScope way, KeyUse key) = nullptr;
    /// Whether its bytes have a rate, a parity and stop bits (LinkUse::line), and so a duration.
    bool has_line = false;
    /// Whether each read is a datagram: no frame goes on beyond it.
    bool has_datagrams = false;
    /// Whether the hardware itself repeats what it was given each period (LinkUse::period).
    bool has_period = false;
    Users users = Users::one;
    /// Of a medium with one user: why an input and an output cannot share it, as the end of a
    /// sentence, if that is not plain.
    std::string_view why_one_way = {};
    SilenceAdvice silence = {};
    /// Whether nothing has that name now: it may be plugged in later. Never null.
    bool (*is_missing)(const std::string& place) = nullptr;
    /// Whether what an output sends to one place comes to an input at the other, although their
    /// names differ. Null: never.
    bool (*reaches)(const std::string& sent_to, const std::string& heard_at) = nullptr;
    /// The same text for all names of one place. Null: each place has one name.
    std::string (*identity)(const std::string& place) = nullptr;
    std::string identity_of(const std::string& device) const {
        return identity != nullptr ? identity(device) : device;
    }
    /// Why the place can never be used, if that is known: "this is a folder; give ...". Else empty.
    /// Null: never known.
    std::string (*refusal)(const std::string& place) = nullptr;
    /// The error begins with the place and says what to do. May block.
    tl::expected<std::unique_ptr<Link>, std::string> (*open)(const std::string& place,
                                                             const LinkUse& use) = nullptr;
};

/// The same as a link of its own type, for `Medium::open`.
template <class Opened>
tl::expected<std::unique_ptr<Link>, std::string> as_link(
    tl::expected<std::unique_ptr<Opened>, std::string> opened) {
    if (!opened) {
        return tl::unexpected(std::move(opened.error()));
    }
    return std::unique_ptr<Link>(std::move(*opened));
}

}  // namespace tribus
