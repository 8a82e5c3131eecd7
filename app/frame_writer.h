#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "app/frame_json.h"
#include "app/protocol_use.h"

/// Frames to what goes on the wire, for `encode`.
namespace tribus {

/// The last one is that of CAN protocols, and of no other.
enum class EncodeFormat : std::uint8_t { binary, hex, timed, vcd, candump };

/// The interface that a log names where nobody has said another.
inline constexpr std::string_view kDefaultInterface = "can0";

/// Encodes frames and writes each out at once. Thread-bound.
class FrameWriter {
  public:
    FrameWriter() = default;
    FrameWriter(const FrameWriter&) = delete;
    FrameWriter& operator=(const FrameWriter&) = delete;
    virtual ~FrameWriter() = default;

    /// A frame without a time follows the one ahead after the protocol's default period. The error
    /// is what is wrong with the frame's time; the frame is left out then.
    virtual tl::expected<void, std::string> write(const WrittenFrame& written) = 0;
    /// No frame follows; says what went differently from what was asked.
    virtual void finish(std::ostream& talk) = 0;
};

/// `use` and `results` must outlive it. `format` is one that the protocol has.
std::unique_ptr<FrameWriter> make_frame_writer(const ProtocolUse& use, EncodeFormat format,
                                               std::string_view interface, std::ostream& results);

}  // namespace tribus
