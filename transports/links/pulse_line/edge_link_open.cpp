#include <sys/timerfd.h>

#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

#include "transports/links/gpio/gpio_line.h"
#include "transports/links/pulse_line/edge_link.h"

namespace tribus {

tl::expected<std::unique_ptr<EdgeLink>, std::string> EdgeLink::open(const std::string& line,
                                                                    GpioEdges edges,
                                                                    GpioBias bias) {
    const auto place = parse_gpio_place(line);
    if (!place) {
        return tl::unexpected(line + ": " + place.error());
    }
    auto held = hold_for_edges(*place, edges, bias);
    if (!held) {
        return tl::unexpected(std::move(held.error()));
    }
    return on(std::move(*held)).map_error([&line](int error) {
        return line + ": " + std::strerror(error);
    });
}

tl::expected<std::unique_ptr<EdgeLink>, int> EdgeLink::on(std::unique_ptr<GpioHeldLine> line) {
    UniqueFd timer(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC));
    if (!timer.valid()) {
        return tl::unexpected(errno);
    }
    return std::unique_ptr<EdgeLink>(new EdgeLink(std::move(line), std::move(timer)));
}

}  // namespace tribus
