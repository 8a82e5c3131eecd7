#include "transports/links/spi/spi_port.h"

#include <fcntl.h>
#include <linux/spi/spidev.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

namespace tribus {
namespace {

/// Linux 6.5: the data line rests low (include/uapi/linux/spi/spi.h).
constexpr std::uint32_t kMosiIdleLow = 1U << 17U;
/// Drivers whose data line rests high unless they know that bit: a servo takes it for a start bit
/// that never ends (docs/boards/spi.md).
constexpr std::array<std::string_view, 3> kRestHigh{"sun4i-spi", "sun6i-spi", "spi_imx"};
constexpr std::size_t kMostZeros = 2000;

std::string spi_problem(int error) {
    switch (error) {
        case EACCES:
        case EPERM:
            return "this user may not use it; join its group, which `ls -l` shows (spi by the "
                   "package's udev rule), and log in again";
        case ENOENT:
        case ENODEV:
        case ENXIO:
            return "there is no such device; on a Raspberry Pi dtparam=spi=on in config.txt makes "
                   "/dev/spidev0.0";
        case ENOTTY:
        case EINVAL:
            return "this is no SPI port that sends bytes of 8 bits; give one such as "
                   "/dev/spidev0.0";
        default:
            return std::strerror(error);
    }
}

/// The driver of the controller; empty if the kernel does not say it.
std::string driver_of(const std::string& device) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::path port = fs::canonical(
        "/sys/class/spidev/" + fs::path(device).filename().string() + "/device", error);
    // A port is behind its bus, and that behind the controller.
    const fs::path driver = fs::canonical(port / "../../../driver", error);
    return error ? std::string() : driver.filename().string();
}

/// Empty, or why the port cannot be used.
std::string set_up(int port, const std::string& device, SpiUse use) {
    std::uint32_t resting_low = SPI_MODE_0 | kMosiIdleLow;
    std::uint8_t mode = SPI_MODE_0;
    std::uint8_t bits = 8;
    const bool rests_low = ::ioctl(port, SPI_IOC_WR_MODE32, &resting_low) >= 0;
    if ((!rests_low && ::ioctl(port, SPI_IOC_WR_MODE, &mode) < 0) ||
        ::ioctl(port, SPI_IOC_WR_BITS_PER_WORD, &bits) < 0) {
        return spi_problem(errno);
    }
    const std::string driver = driver_of(device);
    if (use == SpiUse::draws && !rests_low &&
        std::ranges::find(kRestHigh, driver) != kRestHigh.end()) {
        return fmt::format(
            "the data line of its controller ({}) rests high, and this kernel cannot set it low; a "
            "receiver takes that for a signal. See /usr/share/doc/tribus/docs/boards/spi.md",
            driver);
    }
    return "";
}

bool set_rate(int port, std::uint32_t hz) {
    return ::ioctl(port, SPI_IOC_WR_MAX_SPEED_HZ, &hz) >= 0;
}

/// The port with its settings; the error does not name it.
tl::expected<UniqueFd, std::string> opened(const std::string& device, SpiUse use) {
    UniqueFd port(::open(device.c_str(), O_RDWR | O_CLOEXEC));
    if (!port.valid()) {
        return tl::unexpected(spi_problem(errno));
    }
    if (std::string problem = set_up(port.get(), device, use); !problem.empty()) {
        return tl::unexpected(std::move(problem));
    }
    return port;
}

}  // namespace

std::string why_no_spi_port(const std::string& device, SpiUse use) {
    const auto port = opened(device, use);
    return port ? std::string() : port.error();
}

SpiTransfer zeros_through(const UniqueFd& file, Instant (*now)()) {
    return
        [port = file.get(), now](std::uint32_t hz, std::size_t bytes) -> std::optional<Duration> {
            static constexpr std::array<std::uint8_t, kMostZeros> kZeros{};
            const bool takes_rate = set_rate(port, hz);
            const Instant begun = now();
            const bool sent =
                takes_rate && ::write(port, kZeros.data(), bytes) == static_cast<ssize_t>(bytes);
            return sent ? std::optional(now() - begun) : std::nullopt;
        };
}

tl::expected<SpiPort, std::string> open_spi_port(const std::string& device, SpiUse use,
                                                 Duration byte_time, Instant (*now)()) {
    auto port = opened(device, use);
    if (!port) {
        return tl::unexpected(device + ": " + port.error());
    }
    const auto rate = find_spi_rate(byte_time, zeros_through(*port, now));
    if (!rate) {
        return tl::unexpected(device + ": " + rate.error());
    }
    return SpiPort{std::move(*port), *rate};
}

}  // namespace tribus
