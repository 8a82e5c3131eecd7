#include "transports/links/can/can_wire.h"

#include <linux/can/error.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <utility>

namespace tribus {

const can_err_mask_t kWantedErrors =
    CAN_ERR_TX_TIMEOUT | CAN_ERR_CRTL | CAN_ERR_ACK | CAN_ERR_BUSOFF | CAN_ERR_RESTARTED;

namespace {

using Word = std::array<std::uint8_t, sizeof(std::uint64_t)>;

/// Masks of the first bytes of a word in memory, by their number.
constexpr std::array<Word, kMostClassicBytes + 1> kFirstBytes{{
    {},
    {0xFF},
    {0xFF, 0xFF},
    {0xFF, 0xFF, 0xFF},
    {0xFF, 0xFF, 0xFF, 0xFF},
    {0xFF, 0xFF, 0xFF, 0xFF, 0xFF},
    {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF},
    {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF},
    {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF},
}};

std::uint64_t classic_data(const std::uint8_t* data, std::size_t length) {
    std::uint64_t word = 0;
    std::memcpy(&word, data, sizeof word);
    return word & std::bit_cast<std::uint64_t>(kFirstBytes[length]);
}

/// Copies data of up to eight bytes as one word, which takes no call and no loop.
void copy_data(const std::uint8_t* from, std::size_t length, std::uint8_t* to) {
    if (length <= kMostClassicBytes) {
        const std::uint64_t word = classic_data(from, length);
        std::memcpy(to, &word, sizeof word);
    } else {
        std::copy_n(from, length, to);
    }
}

can_filter kernel_filter(const CanIdMatch& match) {
    const canid_t id_bits = match.extended ? CAN_EFF_MASK : CAN_SFF_MASK;
    const canid_t mask = match.mask & id_bits;
    can_filter filter{};
    filter.can_id = (match.id & mask) | (match.extended ? CAN_EFF_FLAG : 0U);
    filter.can_mask = mask | CAN_EFF_FLAG | (mask == 0 ? 0U : CAN_RTR_FLAG);
    return filter;
}

}  // namespace

std::size_t to_wire(const CanFrame& frame, canfd_frame& wire) {
    const std::size_t size = frame.fd ? CANFD_MTU : CAN_MTU;
    std::memset(&wire, 0, size);
    wire.can_id = frame.id | (frame.extended ? CAN_EFF_FLAG : 0U) |
                  (frame.remote && !frame.fd ? CAN_RTR_FLAG : 0U);
    const std::size_t room = frame.fd ? kMostFdBytes : kMostClassicBytes;
    wire.len = static_cast<__u8>(std::min<std::size_t>(frame.length, room));
    if (frame.fd) {
        wire.flags = static_cast<__u8>((frame.bit_rate_switch ? CANFD_BRS : 0) |
                                       (frame.error_state_indicator ? CANFD_ESI : 0));
    }
    if (!frame.remote) {
        copy_data(frame.data.data(), wire.len, wire.data);
    }
    return size;
}

std::optional<CanFrame> from_wire(const canfd_frame& wire, std::size_t size) {
    if ((size != CAN_MTU && size != CANFD_MTU) || (wire.can_id & CAN_ERR_FLAG) != 0) {
        return std::nullopt;
    }
    std::optional<CanFrame> result(std::in_place);
    CanFrame& frame = *result;
    frame.extended = (wire.can_id & CAN_EFF_FLAG) != 0;
    frame.id = wire.can_id & (frame.extended ? CAN_EFF_MASK : CAN_SFF_MASK);
    frame.fd = size == CANFD_MTU;
    // In a classic frame this byte has another meaning.
    frame.bit_rate_switch = frame.fd && (wire.flags & CANFD_BRS) != 0;
    frame.error_state_indicator = frame.fd && (wire.flags & CANFD_ESI) != 0;
    frame.remote = !frame.fd && (wire.can_id & CAN_RTR_FLAG) != 0;
    const std::size_t room = frame.fd ? kMostFdBytes : kMostClassicBytes;
    frame.length = static_cast<std::uint8_t>(std::min<std::size_t>(wire.len, room));
    if (!frame.remote) {
        copy_data(wire.data, frame.length, frame.data.data());
    }
    return result;
}

bool same_message(const CanFrame& a, const CanFrame& b) {
    if (a.id != b.id || a.extended != b.extended || a.remote != b.remote || a.fd != b.fd ||
        a.length != b.length) {
        return false;
    }
    return a.length <= kMostClassicBytes
               ? classic_data(a.data.data(), a.length) == classic_data(b.data.data(), b.length)
               : std::ranges::equal(a.bytes(), b.bytes());
}

std::optional<CanErrorReport> error_report(const canfd_frame& wire) {
    if ((wire.can_id & CAN_ERR_FLAG) == 0) {
        return std::nullopt;
    }
    CanErrorReport report;
    report.transmit_timeout = (wire.can_id & CAN_ERR_TX_TIMEOUT) != 0;
    report.no_acknowledge = (wire.can_id & CAN_ERR_ACK) != 0;
    report.bus_off = (wire.can_id & CAN_ERR_BUSOFF) != 0;
    report.restarted = (wire.can_id & CAN_ERR_RESTARTED) != 0;
    if ((wire.can_id & CAN_ERR_CRTL) != 0) {
        const unsigned controller = wire.data[1];
        report.active = (controller & CAN_ERR_CRTL_ACTIVE) != 0;
        report.warning = (controller & (CAN_ERR_CRTL_RX_WARNING | CAN_ERR_CRTL_TX_WARNING)) != 0;
        report.passive = (controller & (CAN_ERR_CRTL_RX_PASSIVE | CAN_ERR_CRTL_TX_PASSIVE)) != 0;
        report.receive_overflow = (controller & CAN_ERR_CRTL_RX_OVERFLOW) != 0;
        report.transmit_overflow = (controller & CAN_ERR_CRTL_TX_OVERFLOW) != 0;
    }
    return report;
}

std::vector<can_filter> kernel_filters(std::span<const CanIdMatch> wanted) {
    std::vector<can_filter> filters;
    for (const CanIdMatch& match : wanted) {
        const can_filter filter = kernel_filter(match);
        const auto same = [&filter](const can_filter& other) {
            return other.can_id == filter.can_id && other.can_mask == filter.can_mask;
        };
        if (std::ranges::none_of(filters, same)) {
            filters.push_back(filter);
        }
    }
    return filters;
}

Arrival plausible_arrival(std::optional<Duration> stamp, Duration wall_time, Instant now,
                          Instant oldest) {
    if (!stamp) {
        return {.at = oldest, .plausible = true};
    }
    const Duration age = wall_time - *stamp;
    if (age < -kMostPlausibleAge || age > std::max(kMostPlausibleAge, now - oldest)) {
        return {.at = oldest, .plausible = false};
    }
    return {.at = now - std::max(age, Duration::zero()), .plausible = true};
}

}  // namespace tribus
