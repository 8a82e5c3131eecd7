#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

/// The plain form of F.Port and F.Port 2: each step written out. Tests compare the decoders with
/// it. Sources: docs/protocols/fport.md.
namespace tribus::reference {

/// A frame with a right checksum, where it is in the stream.
struct PlainFportFrame {
    std::size_t at = 0;
    std::size_t length = 0;
    bool has_channels = false;
    std::vector<std::uint16_t> raw{};
    std::uint8_t flags = 0;
    std::uint8_t rssi = 0;
};

/// Adds each carry again.
inline std::uint8_t plain_fport_sum(std::span<const std::uint8_t> bytes) {
    unsigned sum = 0;
    for (const std::uint8_t byte : bytes) {
        sum += byte;
        if (sum > 0xFF) {
            sum = (sum & 0xFF) + 1;
        }
    }
    return static_cast<std::uint8_t>(sum);
}

inline std::vector<std::uint16_t> plain_fport_unpacked(std::span<const std::uint8_t> bytes) {
    std::vector<std::uint16_t> raw(bytes.size() * 8 / 11);
    for (std::size_t bit = 0; bit < 11 * raw.size(); ++bit) {
        const unsigned set = bytes[bit / 8] >> bit % 8 & 1U;
        raw[bit / 11] = static_cast<std::uint16_t>(raw[bit / 11] | set << bit % 11);
    }
    return raw;
}

inline std::vector<std::uint8_t> plain_fport_packed(const std::vector<std::uint16_t>& raw) {
    std::vector<std::uint8_t> bytes(raw.size() * 11 / 8);
    for (std::size_t bit = 0; bit < 11 * raw.size(); ++bit) {
        const unsigned set = raw[bit / 11] >> bit % 11 & 1U;
        bytes[bit / 8] = static_cast<std::uint8_t>(bytes[bit / 8] | set << bit % 8);
    }
    return bytes;
}

inline void plain_fport_content(std::span<const std::uint8_t> content, PlainFportFrame& frame) {
    frame.has_channels = true;
    frame.raw = plain_fport_unpacked(content.first(content.size() - 2));
    frame.flags = content[content.size() - 2];
    frame.rssi = content[content.size() - 1];
}

/// The F.Port 2 frame that begins at `at`.
inline std::optional<PlainFportFrame> plain_fport2_frame(std::span<const std::uint8_t> stream,
                                                         std::size_t at) {
    const auto bytes = stream.subspan(at);
    const std::uint8_t first = bytes[0];
    std::size_t length = 0;
    if (first == 8) {
        length = 10;
    } else if (bytes.size() >= 2) {
        const std::uint8_t type = bytes[1];
        const bool channels = (first == 13 || first == 24 || first == 35) && type == 0xFF;
        const bool update =
            (first == 24 && (type == 0xF0 || type == 0xF2)) || (first == 32 && type == 0xF1);
        length = channels || update ? first + 3U : 0;
    }
    if (length == 0 || bytes.size() < length ||
        plain_fport_sum(bytes.subspan(1, length - 1)) != 0xFF) {
        return std::nullopt;
    }
    PlainFportFrame frame{.at = at, .length = length};
    if (first != 8 && bytes[1] == 0xFF) {
        plain_fport_content(bytes.subspan(2, first), frame);
    }
    return frame;
}

/// The F.Port frame that begins at `at`.
inline std::optional<PlainFportFrame> plain_fport1_frame(std::span<const std::uint8_t> stream,
                                                         std::size_t at) {
    const bool marked = stream[at] == 0x7E;
    std::vector<std::uint8_t> body;
    std::size_t next = marked ? at + 1 : at;
    const auto whole = [&] { return !body.empty() && body.size() == body[0] + 2U; };
    while (!whole()) {
        if (next == stream.size() || stream[next] == 0x7E || body.size() > 40) {
            return std::nullopt;
        }
        std::uint8_t byte = stream[next++];
        if (byte == 0x7D) {
            if (next == stream.size() || stream[next] == 0x7E) {
                return std::nullopt;
            }
            byte = stream[next++] ^ 0x20U;
        }
        body.push_back(byte);
    }
    const bool channels = marked && body[0] == 0x19 && body[1] == 0x00;
    const bool telemetry = body[0] == 0x08 && (body[1] == 0x81 || (marked && body[1] == 0x01));
    if ((!channels && !telemetry) || plain_fport_sum(body) != 0xFF) {
        return std::nullopt;
    }
    if (marked && (next == stream.size() || stream[next++] != 0x7E)) {
        return std::nullopt;
    }
    PlainFportFrame frame{.at = at, .length = next - at};
    if (channels) {
        plain_fport_content(std::span(body).subspan(2, 24), frame);
    }
    return frame;
}

/// All frames of a whole stream. After a false beginning the search goes on at the next byte.
template <class FrameAt>
std::vector<PlainFportFrame> plain_fport_frames(std::span<const std::uint8_t> stream,
                                                FrameAt frame_at) {
    std::vector<PlainFportFrame> frames;
    for (std::size_t at = 0; at < stream.size();) {
        if (const auto frame = frame_at(stream, at)) {
            at += frame->length;
            frames.push_back(*frame);
        } else {
            ++at;
        }
    }
    return frames;
}

/// Adds the checksum of all bytes from `from` on.
inline std::vector<std::uint8_t> plain_fport_summed(std::vector<std::uint8_t> bytes,
                                                    std::size_t from) {
    bytes.push_back(
        static_cast<std::uint8_t>(0xFF - plain_fport_sum(std::span(bytes).subspan(from))));
    return bytes;
}

inline std::vector<std::uint8_t> plain_fport2(const std::vector<std::uint16_t>& raw,
                                              std::uint8_t flags, std::uint8_t rssi) {
    std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(raw.size() * 11 / 8 + 2), 0xFF};
    for (const std::uint8_t byte : plain_fport_packed(raw)) {
        bytes.push_back(byte);
    }
    bytes.push_back(flags);
    bytes.push_back(rssi);
    return plain_fport_summed(std::move(bytes), 1);
}

/// Adds markers and escapes to a body.
inline std::vector<std::uint8_t> plain_fport_marked(const std::vector<std::uint8_t>& body) {
    std::vector<std::uint8_t> bytes{0x7E};
    for (const std::uint8_t byte : body) {
        if (byte == 0x7D || byte == 0x7E) {
            bytes.push_back(0x7D);
            bytes.push_back(byte ^ 0x20U);
        } else {
            bytes.push_back(byte);
        }
    }
    bytes.push_back(0x7E);
    return bytes;
}

inline std::vector<std::uint8_t> plain_fport1(const std::vector<std::uint16_t>& raw,
                                              std::uint8_t flags, std::uint8_t rssi) {
    std::vector<std::uint8_t> body{0x19, 0x00};
    for (const std::uint8_t byte : plain_fport_packed(raw)) {
        body.push_back(byte);
    }
    body.push_back(flags);
    body.push_back(rssi);
    return plain_fport_marked(plain_fport_summed(std::move(body), 0));
}

}  // namespace tribus::reference
