#include "app/simulate_inputs.h"

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/streams.h"
#include "core/quotes.h"
#include "transports/links/recording.h"
#include "transports/links/recording_candump.h"

namespace tribus {
namespace {

bool is_empty(const Recording& recording) {
    return recording.bursts.empty() && recording.can_frames.empty();
}

/// The recording, if it is of the input's kind of link. An empty one is of both.
tl::expected<Recording, std::string> load_recording(const std::string& path,
                                                    const InputConfig& input) {
    auto file = InputFile::open_path(path);
    if (!file) {
        return tl::unexpected(std::move(file.error()));
    }
    const auto content = file->read_all();
    if (!content) {
        return tl::unexpected(content.error());
    }
    const auto kind = tell_recording_kind(*content, path);
    const bool log = kind == RecordingKind::candump;
    auto recording = parse_recording(*content, path);
    const bool empty = recording && is_empty(*recording);
    if (input.protocol->link == LinkKind::can && !log && !empty) {
        return tl::unexpected(fmt::format(
            "{}: this is no log of CAN frames, but input {} has the protocol {}; it takes lines "
            "such as (1436509052.249713) can0 123#1122, as candump -L writes them",
            path, in_quotes(input.name), input.protocol->name));
    }
    if (input.protocol->link == LinkKind::serial && log) {
        return tl::unexpected(fmt::format(
            "{}: this is a log of CAN frames, but input {} has the protocol {}; it takes recorded "
            "bytes: raw, hex, timed hex or the CSV of a Saleae serial decoder",
            path, in_quotes(input.name), input.protocol->name));
    }
    return recording;
}

/// A recording without times is played with its bursts the protocol's usual period apart.
void add_bytes(Arrivals& arrivals, const Recording& recording, std::size_t index,
               const InputConfig& input) {
    Duration untimed{};
    for (const Burst& burst : recording.bursts) {
        const Duration start = burst.start.value_or(untimed);
        for (std::size_t i = 0; i < burst.bytes.size(); ++i) {
            arrivals.in_order.push_back({Instant(start + input.port.line.bytes_time(i + 1)), index,
                                         ArrivedByte{burst.bytes[i], burst.damaged[i]}});
        }
        untimed += std::max(input.protocol->default_period,
                            input.port.line.bytes_time(burst.bytes.size() + 1));
    }
}

tl::expected<void, std::string> add_can_frames(Arrivals& arrivals, const Recording& recording,
                                               std::size_t index, const InputConfig& input,
                                               std::string_view path) {
    const std::vector<std::string> names = interfaces_in(recording);
    const std::string& own = input.port.device;
    const bool has_own = std::find(names.begin(), names.end(), own) != names.end();
    if (!has_own && names.size() > 1) {
        const std::vector<std::string_view> views(names.begin(), names.end());
        return tl::unexpected(
            fmt::format("{}: has frames of {}, but none of {}, the interface of input {}; name one "
                        "of them there",
                        path, in_quotes_all(views), in_quotes(own), in_quotes(input.name)));
    }
    for (const RecordedCanFrame& recorded : recording.can_frames) {
        if (!has_own || recorded.interface == own) {
            arrivals.in_order.push_back(
                {Instant(recorded.at), index, ArrivedCanFrame{arrivals.can_frames.size()}});
            arrivals.can_frames.push_back(recorded.frame);
        }
    }
    return {};
}

}  // namespace

tl::expected<Arrivals, std::string> load_arrivals(const std::map<std::size_t, std::string>& files,
                                                  const Configuration& configuration) {
    Arrivals arrivals;
    for (const auto& [index, path] : files) {
        const InputConfig& input = configuration.inputs[index];
        const auto recording = load_recording(path, input);
        if (!recording) {
            return tl::unexpected(recording.error());
        }
        add_bytes(arrivals, *recording, index, input);
        const auto added = add_can_frames(arrivals, *recording, index, input, path);
        if (!added) {
            return tl::unexpected(added.error());
        }
    }
    std::stable_sort(arrivals.in_order.begin(), arrivals.in_order.end(),
                     [](const Arrival& a, const Arrival& b) { return a.at < b.at; });
    return arrivals;
}

}  // namespace tribus
