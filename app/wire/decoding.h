#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <ostream>
#include <string>
#include <string_view>

#include "app/wire/frames/can_log.h"
#include "app/wire/frames/frame_finder.h"
#include "transports/recordings/recording_source.h"

/// The steps of `decode`. They are the same for every protocol, and for a whole recording and one
/// that arrives piece by piece.
namespace tribus {

enum class DecodeFormat : std::uint8_t { text, json, csv };

/// The formats' names, in their order.
inline constexpr std::array<std::string_view, 3> kDecodeFormatNames{"text", "json", "csv"};

/// Returns the text that the function of this format appends for the arguments.
template <class Text, class Json, class Csv, class... Arguments>
std::string in_format(DecodeFormat format, Text text, Json json, Csv csv,
                      const Arguments&... arguments) {
    std::string line;
    switch (format) {
        case DecodeFormat::text:
            text(line, arguments...);
            break;
        case DecodeFormat::json:
            json(line, arguments...);
            break;
        case DecodeFormat::csv:
            csv(line, arguments...);
            break;
    }
    return line;
}

/// The streams that `decode` prints to. The summary of a CSV goes to `messages`, all other output
/// to `results`. Both must outlive it.
struct DecodeOutput {
    DecodeFormat format;
    RecordingKind input;
    std::ostream& results;
    std::ostream& messages;

    std::string_view input_name() const {
        return kRecordingKindNames.at(static_cast<std::size_t>(input));
    }
    template <class Text, class Csv>
    void heading(Text text, Csv csv) const {
        results << in_format(
            format, text, [](std::string&) {}, csv);
    }
    template <class Text, class Json>
    void summary(Text text, Json json) const {
        (format == DecodeFormat::csv ? messages : results) << in_format(format, text, json, text);
    }
};

/// How much was decoded so far.
struct DecodedAmount {
    std::uint64_t frames = 0;  ///< of the protocol
    std::uint64_t given = 0;   ///< bytes, or CAN frames
};
DecodedAmount amount_of(const Tally& tally);

/// Prints a recording for `decode`: heading, a line for each frame, exchange or transfer, summary.
class Decoding : public RecordingTaker {
  public:
    virtual void heading() = 0;
    /// The recording ends here.
    virtual void finish(const LogFacts& log) = 0;

    virtual DecodedAmount amount() const = 0;
    virtual std::string_view protocol() const = 0;
    /// Exit status for a recording in which the protocol found nothing.
    virtual int status_of_nothing() const;
};

/// Decodes a whole recording. If it finds nothing, `messages` names protocols that do. Returns the
/// exit status.
int decode_recording(RecordingSource& recording, Decoding& decoding, std::ostream& messages);

/// Decodes raw bytes as they arrive. `read` returns the next bytes, none at the end. Otherwise as
/// above.
int decode_stream(const std::function<std::string()>& read, Decoding& decoding,
                  std::ostream& results, std::ostream& messages);

/// Decodes a log while its lines arrive. Reports and skips lines that cannot be used. Returns the
/// exit status: 1 if there was such a line, or a second interface that was not asked for.
int decode_log(const CanLogSource& source, Decoding& decoding, std::ostream& results,
               std::ostream& messages);

}  // namespace tribus
