#include "transports/links/can/can_medium.h"

#include "transports/links/can/can_socket.h"

namespace tribus {

const Medium kCanMedium{
    .name = "CAN",
    .shape = WireShape::can_frames,
    .place = kInterfaceSetting,
    .place_absent = "required on CAN",
    .users = Users::many,
    .silence = {.nothing = "no frame with its ids yet; check the ids, the bit rate and whether the "
                           "sender is on (candump shows what is on the bus)",
                .no_frame = "with its ids rejected; sender and receiver must agree on format, id, "
                            "fd and checksum (tribus decode shows why)",
                .counts = "frame",
                .doctor = "looks at the interface"},
    .is_missing = CanSocket::is_missing,
    .open = [](const std::string& interface,
               const LinkUse& use) { return as_link(CanSocket::open(interface, use)); },
};

}  // namespace tribus
