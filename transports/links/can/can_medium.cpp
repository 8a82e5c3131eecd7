#include "transports/links/can/can_medium.h"

#include "transports/links/can/can_socket.h"

namespace tribus {

const Medium kCanMedium{
    .name = "CAN",
    .shape = WireShape::can_frames,
    .place = kInterfaceSetting,
    .place_absent = "required on CAN",
    .users = Users::many,
    .is_missing = CanSocket::is_missing,
    .open = [](const std::string& interface,
               const LinkUse& use) { return as_link(CanSocket::open(interface, use)); },
};

}  // namespace tribus
