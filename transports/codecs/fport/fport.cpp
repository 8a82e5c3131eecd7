#include "transports/codecs/fport/fport.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace tribus {
namespace {

constexpr std::uint8_t kFportMarker = 0x7E;
constexpr std::uint8_t kFportEscape = 0x7D;
constexpr std::uint8_t kEscapedDiffers = 0x20;

/// Bytes of a body, which is what lies between the markers, beside those that its length counts:
/// length and sum.
constexpr std::size_t kFportUncounted = 2;
constexpr std::size_t kFportContentAt = 2;
constexpr std::uint8_t kControlLength = 0x19;
constexpr std::uint8_t kFportTelemetryLength = 0x08;
constexpr std::uint8_t kFportControlType = 0x00;
constexpr std::uint8_t kRequestType = 0x01;
constexpr std::uint8_t kReplyType = 0x81;

constexpr std::size_t kControlBody = kControlLength + kFportUncounted;
static_assert(kControlBody == kFportContentAt + kFportUsualContent + 1);
constexpr std::size_t kUsualFportFrame = kControlBody + 2;

using FportBody = std::array<std::uint8_t, kControlBody>;

/// A body, byte by byte, without its escapes.
class BodyReader {
  public:
    enum class Step : std::uint8_t { none, byte, wrong };

    Step take(std::uint8_t wire) {
        if (wire == kFportMarker) {
            return Step::wrong;
        }
        if (!escaped_ && wire == kFportEscape) {
            escaped_ = true;
            return Step::none;
        }
        last_ = escaped_ ? static_cast<std::uint8_t>(wire ^ kEscapedDiffers) : wire;
        escaped_ = false;
        return Step::byte;
    }
    std::uint8_t last() const { return last_; }

  private:
    bool escaped_ = false;
    std::uint8_t last_ = 0;
};

/// Whether a body may begin with these two bytes. Only a reply comes without markers.
bool is_body(std::uint8_t length, std::uint8_t type, bool marked) {
    if (length == kFportTelemetryLength) {
        return type == kReplyType || (marked && type == kRequestType);
    }
    return marked && length == kControlLength && type == kFportControlType;
}

bool may_begin_body(std::uint8_t length) {
    return length == kControlLength || length == kFportTelemetryLength;
}

/// Removes markers and escapes of a whole frame.
std::span<const std::uint8_t> body_of(std::span<const std::uint8_t> frame, FportBody& body) {
    BodyReader reader;
    std::size_t size = 0;
    for (const std::uint8_t wire : frame) {
        if (reader.take(wire) == BodyReader::Step::byte) {
            body[size++] = reader.last();
        }
    }
    return std::span(body).first(size);
}

/// Whether there is a marker or an escape among the bytes of a body.
bool has_marks(std::span<const std::uint8_t, kControlBody> bytes) {
    using Sixteen [[gnu::vector_size(16)]] = std::uint8_t;
    using Halves [[gnu::vector_size(16)]] = std::uint64_t;
    static_assert(kControlBody >= sizeof(Sixteen) && kControlBody <= 2 * sizeof(Sixteen));
    Sixteen first;
    Sixteen last;
    std::memcpy(&first, bytes.data(), sizeof first);
    std::memcpy(&last, bytes.last<sizeof last>().data(), sizeof last);
    const auto marks = [](Sixteen some) {
        return reinterpret_cast<Halves>((some == kFportMarker) | (some == kFportEscape));
    };
    const Halves found = marks(first) | marks(last);
    return (found[0] | found[1]) != 0;
}

}  // namespace

FportDecoder::Taken FportDecoder::decode(std::span<const std::uint8_t> bytes, Instant received,
                                         DecodedFrame& frame) {
    // The usual case, channels without escapes in one read. The general way gives the same.
    if (buffer_.size() == 0 && bytes.size() >= kUsualFportFrame && bytes[0] == kFportMarker &&
        bytes[1] == kControlLength && bytes[2] == kFportControlType &&
        bytes[kUsualFportFrame - 1] == kFportMarker) {
        const auto body = bytes.subspan<1, kControlBody>();
        if (!has_marks(body) && fport_sum_holds(byte_sums::sum_of(body))) {
            frame.first_byte = buffer_.first_position();
            frame.length = kUsualFportFrame;
            frame.channels.received = received;
            channels_.read(body.subspan<kFportContentAt, kFportUsualContent>(), frame.channels);
            buffer_.pass(kUsualFportFrame);
            return {kUsualFportFrame, true};
        }
    }
    return FramedDecoder::decode(bytes, received, frame);
}

std::size_t FportDecoder::needed_bytes(std::span<const std::uint8_t> bytes) const {
    const bool marked = bytes[0] == kFportMarker;
    const std::size_t markers = marked ? 1 : 0;
    std::array<std::uint8_t, kFportContentAt> start{};
    std::size_t body = start.size();
    std::size_t size = 0;
    BodyReader reader;
    for (std::size_t at = markers; at < bytes.size(); ++at) {
        if (size == body) {
            return bytes[at] == kFportMarker ? at + 1 : 0;
        }
        const BodyReader::Step step = reader.take(bytes[at]);
        if (step == BodyReader::Step::none) {
            continue;
        }
        if (step == BodyReader::Step::wrong || (size == 0 && !may_begin_body(reader.last()))) {
            return 0;
        }
        if (size < start.size()) {
            start[size] = reader.last();
        }
        ++size;
        if (size == start.size()) {
            if (!is_body(start[0], start[1], marked)) {
                return 0;
            }
            body = start[0] + kFportUncounted;
        }
    }
    return bytes.size() + (body - size) + (size < start.size() ? 0 : markers);
}

bool FportDecoder::check_holds(std::span<const std::uint8_t> frame) const {
    FportBody body;
    return fport_sum_holds(byte_sums::sum_of(body_of(frame, body)));
}

bool FportDecoder::read(std::span<const std::uint8_t> frame, ChannelFrame& channels) {
    FportBody body;
    if (body_of(frame, body).size() != kControlBody) {
        return false;
    }
    channels_.read(std::span(body).subspan<kFportContentAt, kFportUsualContent>(), channels);
    return true;
}

}  // namespace tribus
