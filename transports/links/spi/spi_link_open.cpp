#include <utility>

#include "transports/links/spi/spi_link.h"
#include "transports/links/spi/spi_listener.h"
#include "transports/links/spi/spi_port.h"

namespace tribus {

tl::expected<std::unique_ptr<SpiLink>, std::string> SpiLink::open(const std::string& device,
                                                                  SpiSignal signal,
                                                                  const WorkerSettings& worker) {
    auto port = open_spi_port(device, SpiUse::draws, signal.byte_time, worker.now);
    if (!port) {
        return tl::unexpected(std::move(port.error()));
    }
    SpiPace pace(device, std::move(*port), signal.byte_time, worker);
    std::unique_ptr<SpiLink> link(new SpiLink(std::move(pace), std::move(signal)));
    if (auto problem = link->worker_.start(worker, [&link = *link] { return link.send_newest(); });
        !problem.empty()) {
        return tl::unexpected(device + ": " + problem);
    }
    return link;
}

tl::expected<std::unique_ptr<SpiListener>, std::string> SpiListener::open(
    const std::string& device, const LineSettings& line, const WorkerSettings& worker) {
    auto port = open_spi_port(device, SpiUse::listens, line.bits_time(1), worker.now);
    if (!port) {
        return tl::unexpected(std::move(port.error()));
    }
    std::unique_ptr<SpiListener> link(new SpiListener(
        SpiPace(device, std::move(*port), line.bits_time(1), worker), line, worker));
    if (const std::string problem = link->start(); !problem.empty()) {
        return tl::unexpected(device + ": " + problem);
    }
    return link;
}

}  // namespace tribus
