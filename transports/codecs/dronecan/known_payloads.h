#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "transports/codecs/dronecan/fields.h"
#include "transports/codecs/dronecan/transfer.h"
#include "transports/codecs/dronecan/visit.h"

/// The known data types for those who meet them by their ids. Reentrant; not for the data path.
namespace tribus::dronecan {

using ShowValue = std::function<void(const FieldValue&)>;

struct KnownPayload {
    DataType type;
    /// Without the zeros that an FD transfer may have behind its end.
    std::size_t most_bytes = 0;
    /// Calls `show` for every value in the order of the wire; false, and no call, where that cannot
    /// be the payload of such a transfer.
    bool (*visit)(std::span<const std::uint8_t> payload, bool fd, const ShowValue& show) = nullptr;
};

/// A message, or the request or the response of a service.
std::span<const KnownPayload> known_payloads();
/// Null where it is not known. Messages and services have ids of their own.
const KnownPayload* find_known_payload(TransferKind kind, std::uint16_t data_type_id);

}  // namespace tribus::dronecan
