#pragma once

#include <cstdint>
#include <iosfwd>
#include <memory>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "app/cli/protocol_use.h"
#include "app/wire/frames/frame_json.h"

/// Writes frames as they go on the wire, for `encode`.
namespace tribus {

/// `candump` is the only format of CAN protocols, and of no other.
enum class EncodeFormat : std::uint8_t { binary, hex, timed, vcd, candump };

/// Interface in a candump log, if none is given.
inline constexpr std::string_view kDefaultInterface = "can0";

/// Encodes frames and writes each one at once. Thread-bound.
class FrameWriter {
  public:
    FrameWriter() = default;
    FrameWriter(const FrameWriter&) = delete;
    FrameWriter& operator=(const FrameWriter&) = delete;
    virtual ~FrameWriter() = default;

    /// Writes a frame. A frame without a time follows the one before after the protocol's default
    /// period. The error says what is wrong with the frame's time; the frame is then skipped.
    virtual tl::expected<void, std::string> write(const WrittenFrame& written) = 0;
    /// Call it after the last frame. Reports frames that could not be written as requested.
    virtual void finish(std::ostream& messages) = 0;
    /// Whether the protocol can mark a frame as frame lost.
    virtual bool marks_frame_lost() const = 0;
};

/// `use` and `results` must outlive the writer. The protocol must have the `format`.
std::unique_ptr<FrameWriter> make_frame_writer(const ProtocolUse& use, EncodeFormat format,
                                               std::string_view interface, std::ostream& results);

}  // namespace tribus
