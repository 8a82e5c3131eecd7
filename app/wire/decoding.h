#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <iosfwd>
#include <string>
#include <string_view>

#include "app/wire/frames/can_log.h"
#include "core/time.h"
#include "transports/recordings/recording.h"

/// The steps of `decode`. They are the same for every protocol, and for a whole recording and one
/// that arrives piece by piece.
namespace tribus {

/// Facts of a log of CAN frames besides the frames.
struct LogFacts {
    std::uint64_t error_frames = 0;
    Duration log_start{};
};

/// How much was decoded so far.
struct DecodedAmount {
    std::uint64_t frames = 0;  ///< of the protocol
    std::uint64_t given = 0;   ///< bytes, or CAN frames
};

/// Prints a recording for `decode`: heading, a line for each frame, exchange or transfer, summary.
class Decoding {
  public:
    Decoding() = default;
    Decoding(const Decoding&) = delete;
    Decoding& operator=(const Decoding&) = delete;
    virtual ~Decoding() = default;

    virtual void heading() = 0;
    /// In the order of the recording. `index`: number of the burst.
    virtual void feed_burst(std::size_t /*index*/, const Burst& /*burst*/) {}
    virtual void feed_frame(const RecordedCanFrame& /*frame*/) {}
    /// The recording ends here.
    virtual void finish(const LogFacts& facts) = 0;

    virtual DecodedAmount amount() const = 0;
    virtual std::string_view protocol() const = 0;
    /// Exit status for a recording in which the protocol found nothing.
    virtual int status_of_nothing() const;
};

/// Decodes a whole recording. If it finds nothing, `messages` names protocols that do. Returns the
/// exit status.
int decode_recording(const Recording& recording, Decoding& decoding, std::ostream& messages);

/// Decodes raw bytes as they arrive. `read` returns the next bytes, none at the end. Otherwise as
/// above.
int decode_stream(const std::function<std::string()>& read, Decoding& decoding,
                  std::ostream& results, std::ostream& messages);

/// Decodes a log while its lines arrive. Reports and skips lines that cannot be used. Returns the
/// exit status: 1 if there was such a line, or a second interface that was not asked for.
int decode_log(const CanLogSource& source, Decoding& decoding, std::ostream& results,
               std::ostream& messages);

}  // namespace tribus
