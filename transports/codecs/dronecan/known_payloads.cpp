#include "transports/codecs/dronecan/known_payloads.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "transports/codecs/dronecan/payload.h"
#include "transports/codecs/dronecan/types.h"

namespace tribus::dronecan {
namespace {

template <class T>
bool visit_payload(std::span<const std::uint8_t> payload, bool fd, const ShowValue& show) {
    const std::optional<T> value = read<T>(payload, fd);
    if (value) {
        visit_values(*value, show);
    }
    return value.has_value();
}

}  // namespace

std::span<const KnownPayload> known_payloads() {
    static const std::vector<KnownPayload> all = [] {
        std::vector<KnownPayload> found;
        for_each_payload_type([&]<class T>() {
            found.push_back({data_type_of<T>(), kMostBytes<T>, visit_payload<T>});
        });
        return found;
    }();
    return all;
}

const KnownPayload* find_known_payload(TransferKind kind, std::uint16_t data_type_id) {
    const auto all = known_payloads();
    const auto found = std::find_if(all.begin(), all.end(), [&](const KnownPayload& one) {
        return one.type.kind == kind && one.type.id == data_type_id;
    });
    return found == all.end() ? nullptr : &*found;
}

}  // namespace tribus::dronecan
