#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "transports/codecs/dronecan/fields.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/visit.h"

/// The known data types, found by their ids. Reentrant; not for the data path.
namespace tribus::dronecan {

using ShowValue = std::function<void(const FieldValue&)>;

struct KnownPayload {
    DataType type;
    /// Without the zeros after the end that an FD transfer may have.
    std::size_t most_bytes = 0;
    /// Calls `show` for every value in wire order. Returns false, without a call, if this cannot be
    /// the payload of such a transfer.
    bool (*visit)(std::span<const std::uint8_t> payload, bool fd, const ShowValue& show) = nullptr;
};

/// One entry for each message, request and response.
std::span<const KnownPayload> known_payloads();
/// The type with this id, or null. Messages and services have separate ids.
const KnownPayload* find_known_payload(TransferKind kind, std::uint16_t data_type_id);

}  // namespace tribus::dronecan
