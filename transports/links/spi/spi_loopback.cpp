#include "transports/links/spi/spi_loopback.h"

#include <linux/spi/spidev.h>
#include <sys/ioctl.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <random>
#include <span>
#include <vector>

#include "transports/links/spi/spi_port.h"
#include "transports/links/spi/uart_sampler.h"
#include "transports/links/spi/uart_waveform.h"

namespace tribus {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// At rest in front of a frame and behind it, in bytes of the port: longer than a byte of the line.
constexpr std::size_t kRest = 20;

/// What comes in while `sent` goes out; empty if the port refuses.
Bytes exchanged(const UniqueFd& port, const Bytes& sent) {
    Bytes received(sent.size());
    spi_ioc_transfer transfer{};
    transfer.tx_buf = reinterpret_cast<std::uintptr_t>(sent.data());
    transfer.rx_buf = reinterpret_cast<std::uintptr_t>(received.data());
    transfer.len = static_cast<std::uint32_t>(sent.size());
    return ::ioctl(port.get(), SPI_IOC_MESSAGE(1), &transfer) < 0 ? Bytes() : received;
}

Bytes drawn(std::span<const std::uint8_t> frame, const LineSettings& line) {
    SpiWaveform waveform;
    draw_uart(frame, line, waveform);
    Bytes all(kRest);
    all.insert(all.end(), waveform.bits.begin(),
               waveform.bits.begin() + static_cast<std::ptrdiff_t>(waveform.bytes));
    all.resize(all.size() + kRest);
    return all;
}

bool is_right(const SampledBlock& heard, std::span<const std::uint8_t> sent) {
    return std::ranges::equal(heard.view(), sent, [](const SampledByte& byte, std::uint8_t value) {
        return !byte.damaged && byte.value == value;
    });
}

}  // namespace

tl::expected<SpiLoopback, std::string> try_spi_loopback(const std::string& device,
                                                        const LineSettings& line, int frames,
                                                        Instant (*now)()) {
    const auto port = open_spi_port(device, SpiUse::draws, line.bits_time(1), now);
    if (!port) {
        return tl::unexpected(port.error());
    }
    const SpiTransfer zeros = zeros_through(port->file, now);
    SpiLoopback found{.hz = port->hz};
    const auto before = measure_spi_byte(port->hz, zeros);
    if (exchanged(port->file, Bytes(kRest)).empty()) {
        return tl::unexpected(device + ": it sends but does not receive: " + std::strerror(errno));
    }
    std::minstd_rand random(1);
    SampledBlock heard;
    for (; found.sent < frames; ++found.sent) {
        std::array<std::uint8_t, 25> frame{};
        std::ranges::generate(frame, [&] { return static_cast<std::uint8_t>(random() >> 8U); });
        sample_uart(exchanged(port->file, drawn(frame, line)), line, heard);
        found.silent += heard.count == 0 ? 1 : 0;
        found.right += is_right(heard, frame) ? 1 : 0;
    }
    const auto after = measure_spi_byte(port->hz, zeros);
    if (!before || !after) {
        return tl::unexpected(device + ": it refuses transfers of zeros");
    }
    found.byte_before = *before;
    found.byte_after = *after;
    return found;
}

}  // namespace tribus
