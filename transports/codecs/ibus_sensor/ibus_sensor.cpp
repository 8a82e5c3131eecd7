#include "transports/codecs/ibus_sensor/ibus_sensor.h"

#include <algorithm>

namespace tribus {
namespace {

constexpr std::size_t kDataAt = 2;
constexpr std::size_t kSensorChecksumBytes = 2;
constexpr std::size_t kFrameBytes = kDataAt + kSensorChecksumBytes;  // without data
constexpr std::size_t kTypeReplyBytes = kFrameBytes + 2;
constexpr std::uint8_t kServoLength = 0x20;
constexpr std::uint8_t kServoCommand = 0x40;
constexpr unsigned kCommandShift = 4;
constexpr std::uint8_t kAddressMask = 0x0F;

static_assert(kFrameBytes == kSensorRequestBytes);
static_assert(kFrameBytes + kMostSensorData == kLongestSensorFrame);

/// 0xFFFF less each byte (docs/protocols/ibus.md, "Servo frame").
std::uint16_t checksum(std::span<const std::uint8_t> bytes) {
    std::uint16_t sum = 0xFFFF;
    for (const std::uint8_t byte : bytes) {
        sum = static_cast<std::uint16_t>(sum - byte);
    }
    return sum;
}

bool holds(std::span<const std::uint8_t> frame) {
    const std::size_t end = frame.size() - kSensorChecksumBytes;
    const auto stated = static_cast<unsigned>(frame[end] | frame[end + 1] << 8U);
    return checksum(frame.first(end)) == stated;
}

bool is_servo(std::uint8_t length, std::uint8_t command) {
    return length == kServoLength && command == kServoCommand;
}

bool is_length(std::uint8_t length) {
    return length >= kFrameBytes && length <= kLongestSensorFrame;
}

/// Whether a frame can begin with these two bytes.
bool is_frame(std::uint8_t length, std::uint8_t head) {
    const bool addressed = (head & kAddressMask) != 0;
    switch (static_cast<SensorCommand>(head >> kCommandShift)) {
        case SensorCommand::discover:
            return addressed && length == kFrameBytes;
        case SensorCommand::type:
            return addressed && (length == kFrameBytes || length == kTypeReplyBytes);
        case SensorCommand::value:
            return addressed && is_length(length);
        case SensorCommand::power_up:
            return !addressed && length == kFrameBytes;
    }
    return false;
}

}  // namespace

std::size_t encode_sensor_frame(SensorCommand command, std::uint8_t address,
                                std::span<const std::uint8_t> data,
                                std::span<std::uint8_t, kLongestSensorFrame> wire) {
    const std::size_t size = std::min(data.size(), kMostSensorData);
    const std::size_t end = kDataAt + size;
    wire[0] = static_cast<std::uint8_t>(end + kSensorChecksumBytes);
    wire[1] = static_cast<std::uint8_t>(static_cast<unsigned>(command) << kCommandShift |
                                        (address & kAddressMask));
    std::copy_n(data.begin(), size, wire.begin() + kDataAt);
    const std::uint16_t sum = checksum(wire.first(end));
    wire[end] = static_cast<std::uint8_t>(sum);
    wire[end + 1] = static_cast<std::uint8_t>(sum >> 8U);
    return end + kSensorChecksumBytes;
}

std::optional<SensorFrame> SensorFrameParser::next(std::span<const std::uint8_t>& bytes,
                                                   Instant received) {
    // The last byte of the read may complete two frames: if it shows that the first bytes are no
    // frame, another one may be behind them.
    auto frame = judge();
    while (!frame && !bytes.empty()) {
        give_up_after_pause(received);
        kept_[size_] = bytes.front();
        ++size_;
        bytes = bytes.subspan(1);
        frame = judge();
    }
    return frame;
}

void SensorFrameParser::damaged_byte(Instant received) {
    give_up_after_pause(received);
    ++rejected_[kDamaged].count;
    skip(size_);
    ++skipped_bytes_;
    ++position_;
}

void SensorFrameParser::give_up_after_pause(Instant received) {
    if (received - last_ > kLongestSensorPause) {
        rejected_[kUnfinished].count += size_ > 0 ? 1 : 0;
        skip(size_);
        in_step_ = true;
    }
    last_ = received;
}

/// Removes the bytes that the last one decides. If it returns no frame, fewer bytes are left than a
/// frame has.
std::optional<SensorFrame> SensorFrameParser::judge() {
    while (size_ > 0) {
        const std::size_t length = wanted();
        const bool in_step = in_step_ || kept_[0] == kServoLength;
        if (length == 0) {
            const bool unknown = in_step_ && size_ > 1 && is_length(kept_[0]);
            rejected_[kUnknownCommand].count += unknown ? 1 : 0;
            skip(1);
        } else if (size_ < length) {
            if (in_step || !ends_with_request()) {
                return std::nullopt;
            }
            skip(size_ - kSensorRequestBytes);
            return take_frame(kSensorRequestBytes);
        } else if (!holds({kept_.data(), length})) {
            ++rejected_[kChecksum].count;
            damaged_end_ = in_step ? position_ + length : damaged_end_;
            skip(1);
        } else if (is_servo(kept_[0], kept_[1])) {
            ++servo_frames_;
            drop(length);
        } else if (position_ + length <= damaged_end_) {
            skip(1);
        } else {
            return take_frame(length);
        }
    }
    return std::nullopt;
}

/// Number of bytes that decide what the first byte belongs to; 0 if it belongs to nothing.
std::size_t SensorFrameParser::wanted() const {
    const std::uint8_t length = kept_[0];
    if (size_ == 1) {
        return is_length(length) || length == kServoLength ? 2 : 0;
    }
    return is_servo(length, kept_[1]) || is_frame(length, kept_[1]) ? length : 0;
}

bool SensorFrameParser::ends_with_request() const {
    if (size_ < kSensorRequestBytes || position_ + size_ <= damaged_end_) {
        return false;
    }
    const std::size_t start = size_ - kSensorRequestBytes;
    return kept_[start] == kSensorRequestBytes && is_frame(kept_[start], kept_[start + 1]) &&
           holds({kept_.data() + start, kSensorRequestBytes});
}

SensorFrame SensorFrameParser::take_frame(std::size_t length) {
    SensorFrame frame{.command = static_cast<SensorCommand>(kept_[1] >> kCommandShift),
                      .address = static_cast<std::uint8_t>(kept_[1] & kAddressMask),
                      .data_size = static_cast<std::uint8_t>(length - kFrameBytes),
                      .first_byte = position_};
    std::copy_n(kept_.begin() + kDataAt, frame.data_size, frame.data.begin());
    drop(length);
    return frame;
}

/// Removes bytes that belong to no frame. The bytes after them are out of step.
void SensorFrameParser::skip(std::size_t count) {
    skipped_bytes_ += count;
    drop(count);
    in_step_ = false;
}

/// Removes a frame. The bytes after it are in step.
void SensorFrameParser::drop(std::size_t count) {
    std::copy(kept_.begin() + static_cast<std::ptrdiff_t>(count),
              kept_.begin() + static_cast<std::ptrdiff_t>(size_), kept_.begin());
    size_ -= count;
    position_ += count;
    in_step_ = true;
}

}  // namespace tribus
