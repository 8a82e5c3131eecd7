#include <fcntl.h>
#include <linux/spi/spidev.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "transports/links/pulse_line/spi_link.h"

namespace tribus {
namespace {

constexpr std::uint32_t kBitsASecond = 1'000'000;

std::string spi_problem(int error) {
    switch (error) {
        case EACCES:
        case EPERM:
            return "this user may not use it; join its group, which `ls -l` shows (gpio by the "
                   "package's udev rule, spi on Raspberry Pi OS), and for a service see "
                   "/usr/share/doc/tribus/docs/service.md, \"SPI in the service\"";
        case ENOENT:
        case ENODEV:
        case ENXIO:
            return "there is no such device; on a Raspberry Pi dtparam=spi=on in config.txt makes "
                   "/dev/spidev0.0";
        case ENOTTY:
        case EINVAL:
            return "this is no SPI port that sends 8 bits at 1 MHz; give one such as "
                   "/dev/spidev0.0";
        default:
            return std::strerror(error);
    }
}

bool set_up(int port) {
    std::uint8_t mode = SPI_MODE_0;
    std::uint8_t bits = 8;
    std::uint32_t speed = kBitsASecond;
    return ::ioctl(port, SPI_IOC_WR_MODE, &mode) >= 0 &&
           ::ioctl(port, SPI_IOC_WR_BITS_PER_WORD, &bits) >= 0 &&
           ::ioctl(port, SPI_IOC_WR_MAX_SPEED_HZ, &speed) >= 0;
}

}  // namespace

tl::expected<std::unique_ptr<SpiLink>, std::string> SpiLink::open(const std::string& device,
                                                                  double calibration,
                                                                  const WorkerSettings& worker) {
    const auto failed = [&device](int error) {
        return tl::unexpected(device + ": " + spi_problem(error));
    };
    UniqueFd port(::open(device.c_str(), O_RDWR | O_CLOEXEC));
    if (!port.valid() || !set_up(port.get())) {
        return failed(errno);
    }
    std::unique_ptr<SpiLink> link(new SpiLink(std::move(port), calibration));
    if (auto problem = link->worker_.start(worker, [&link = *link] { return link.send_newest(); });
        !problem.empty()) {
        return tl::unexpected(device + ": " + problem);
    }
    return link;
}

}  // namespace tribus
