#pragma once

#include <cstdint>
#include <string>

#include <tl/expected.hpp>

#include "core/line_settings.h"
#include "core/time.h"

namespace tribus {

/// What a port makes of frames that a wire leads from its data line out (MOSI) to that in (MISO).
struct SpiLoopback {
    std::uint32_t hz = 0;  ///< the rate that it was asked for
    /// How long a byte takes, before the frames and after them.
    Duration byte_before{};
    Duration byte_after{};
    int sent = 0;
    int right = 0;
    int silent = 0;  ///< of which nothing came back
};

/// Sends so many random frames of 25 bytes, as an inverted line with these settings carries them.
/// Blocks for as long as they last. The error is as that of `open_spi_port`.
tl::expected<SpiLoopback, std::string> try_spi_loopback(const std::string& device,
                                                        const LineSettings& line, int frames,
                                                        Instant (*now)());

}  // namespace tribus
