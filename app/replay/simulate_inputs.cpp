#include "app/replay/simulate_inputs.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <optional>
#include <span>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/cli/streams.h"
#include "config/build/build.h"
#include "config/schema/value_catalog.h"
#include "core/quotes.h"
#include "transports/codecs/ibus_sensor/ibus_sensor.h"
#include "transports/recordings/burst_reader.h"
#include "transports/recordings/candump.h"
#include "transports/recordings/recording.h"
#include "transports/recordings/recording_source.h"
#include "transports/recordings/text.h"
#include "transports/recordings/time_steps.h"

namespace tribus {
namespace {

/// Name in messages.
std::string title_of(const SimulatedSource& source) {
    const std::string name = in_quotes(source.name);
    return source.station.kind == StationKind::input ? "input " + name
           : source.station.kind == StationKind::sensor_bus
               ? "sensor bus " + name
               : fmt::format("[values.{}]", source.name);
}

/// Says why a recording of this kind does not fit the source; nothing if it fits.
std::optional<std::string> misfit(const std::string& path, RecordingKind kind,
                                  const SimulatedSource& source) {
    const bool log = kind == RecordingKind::candump;
    const bool takes_log = source.port->medium->shape == WireShape::can_frames;
    if (log == takes_log) {
        return std::nullopt;
    }
    return log ? fmt::format(
                     "{}: this is a log of CAN frames, but {} has the protocol {}; it takes "
                     "recorded bytes: raw, hex, timed hex or the CSV of a Saleae serial decoder",
                     path, title_of(source), source.protocol)
               : fmt::format(
                     "{}: this is not a log of CAN frames, but {} has the protocol {}; it takes "
                     "lines such as (1436509052.249713) can0 123#1122, as candump -L writes them",
                     path, title_of(source), source.protocol);
}

/// For recordings of bytes without times.
constexpr Duration kUsualTelemetryPeriod = std::chrono::milliseconds(100);

std::string_view protocol_of(const ValueMessageConfig& source) {
    if (const auto* bytes = std::get_if<ByteValueSource>(&source.layout)) {
        return bytes->protocol;
    }
    return std::holds_alternative<DbcValueSource>(source.layout) ? "dbc" : "dronecan";
}

/// Whether there is nothing but comments, which fits every source.
bool is_empty(Pieces& content) {
    recording_text::Lines lines(content);
    recording_text::Line line;
    bool empty = true;
    while (empty && lines.next(line)) {
        empty = recording_text::trimmed(line.text).empty();
    }
    content.rewind();
    return empty;
}

}  // namespace

/// One recording, and its next arrival.
class Arrivals::Recorded {
  public:
    Recorded(std::unique_ptr<FilePieces> pieces, std::string path, RecordingKind kind,
             std::size_t index, const SimulatedSource& source)
        : pieces_(std::move(pieces)),
          path_(std::move(path)),
          kind_(kind),
          source_(source),
          next_{.at = {}, .source = index, .what = {}} {}

    /// Finds the first arrival.
    tl::expected<void, std::string> begin();
    /// Finds the next one.
    tl::expected<void, std::string> advance();

    bool ended() const { return ended_; }
    const Arrival& next() const { return next_; }

    /// Why the rest of the recording is not played; nothing if all of it is.
    const std::optional<std::string>& rest() const { return rest_; }

  private:
    tl::expected<void, std::string> judge();
    tl::expected<void, std::string> choose_interface(const std::vector<std::string>& names);
    tl::expected<void, std::string> advance_log();
    tl::expected<void, std::string> read_burst();
    tl::expected<void, std::string> ended_with(std::optional<std::string> failed);

    std::unique_ptr<FilePieces> pieces_;
    std::string path_;
    RecordingKind kind_;
    const SimulatedSource& source_;
    std::optional<CandumpFrames> log_;
    /// Frames of other interfaces are left out. Empty: none is.
    std::string interface_;
    std::optional<BurstReader> bursts_;
    Burst burst_;
    /// Position in the burst, and of the burst's first byte where it goes on from the one before.
    std::size_t byte_ = 0;
    std::size_t first_byte_ = 0;
    /// When the burst begins.
    Duration start_{};
    Arrival next_;
    bool ended_ = false;
    std::optional<std::string> rest_;
};

tl::expected<void, std::string> Arrivals::Recorded::begin() {
    if (kind_ != RecordingKind::raw) {
        if (auto judged = judge(); !judged) {
            return judged;
        }
    }
    if (kind_ == RecordingKind::candump) {
        log_.emplace(*pieces_, path_);
    } else {
        bursts_.emplace(*pieces_, path_, kind_);
    }
    return advance();
}

tl::expected<void, std::string> Arrivals::Recorded::ended_with(std::optional<std::string> failed) {
    ended_ = true;
    failed = failed ? failed : pieces_->failed();
    return failed ? tl::expected<void, std::string>(tl::unexpect, *failed)
                  : tl::expected<void, std::string>{};
}

/// Finds what is wrong with the recording before any of it is played. Bytes are played up to the
/// first mistake.
tl::expected<void, std::string> Arrivals::Recorded::judge() {
    RecordingInPieces recording(*pieces_, path_, kind_);
    const auto judged = recording.judge();
    if (!judged && kind_ == RecordingKind::candump) {
        return ended_with(judged.error());
    }
    if (recording.gap()) {
        return ended_with(gap_text(path_, *recording.gap()));
    }
    if (recording.late_start()) {
        return ended_with(late_start_text(path_, *recording.late_start()));
    }
    rest_ = recording.rest();
    if (kind_ == RecordingKind::candump) {
        if (auto chosen = choose_interface(recording.interfaces()); !chosen) {
            return chosen;
        }
    }
    pieces_->rewind();
    return {};
}

tl::expected<void, std::string> Arrivals::Recorded::choose_interface(
    const std::vector<std::string>& names) {
    const std::string& own = source_.port->device;
    const bool has_own = std::ranges::find(names, own) != names.end();
    if (!has_own && names.size() > 1) {
        const std::vector<std::string_view> views(names.begin(), names.end());
        return ended_with(fmt::format(
            "{}: has frames of {}, but none of {}, the interface of {}; set one of them there",
            path_, in_quotes_all(views), in_quotes(own), title_of(source_)));
    }
    interface_ = has_own ? own : std::string();
    return {};
}

tl::expected<void, std::string> Arrivals::Recorded::advance_log() {
    auto frame = log_->next();
    while (frame && *frame && !interface_.empty() && (*frame)->interface != interface_) {
        frame = log_->next();
    }
    if (!frame || !*frame) {
        return ended_with(frame ? std::nullopt : std::optional(frame.error()));
    }
    next_.at = Instant((*frame)->at);
    next_.what = (*frame)->frame;
    return {};
}

/// Bursts without times are played at the protocol's usual period. Raw bytes are one burst, which
/// comes in pieces.
tl::expected<void, std::string> Arrivals::Recorded::read_burst() {
    const std::size_t before = std::exchange(byte_, 0);
    auto burst = bursts_->next();
    if (!burst || !*burst) {
        return ended_with(burst ? std::nullopt : std::optional(burst.error()));
    }
    burst_ = std::move(**burst);
    if (kind_ == RecordingKind::raw) {
        first_byte_ += before;
    } else if (burst_.start) {
        start_ = *burst_.start;
    } else if (before > 0) {
        start_ += std::max(source_.usual_period, source_.port->line.bytes_time(before + 1));
    }
    return {};
}

tl::expected<void, std::string> Arrivals::Recorded::advance() {
    if (log_) {
        return advance_log();
    }
    if (byte_ == burst_.bytes.size()) {
        if (auto read = read_burst(); !read || ended_) {
            return read;
        }
    }
    const Instant at(start_ + source_.port->line.bytes_time(first_byte_ + byte_ + 1));
    // Bursts closer together than their bytes follow each other.
    next_.at = std::max(next_.at, at);
    next_.what = ArrivedByte{burst_.bytes[byte_], burst_.damaged[byte_], !burst_.start};
    ++byte_;
    return {};
}

Arrivals::Arrivals() = default;
Arrivals::Arrivals(Arrivals&&) noexcept = default;
Arrivals& Arrivals::operator=(Arrivals&&) noexcept = default;
Arrivals::~Arrivals() = default;

tl::expected<Arrivals, std::string> Arrivals::open(const std::map<std::size_t, std::string>& files,
                                                   std::span<const SimulatedSource> sources) {
    Arrivals arrivals;
    for (const auto& [index, path] : files) {
        const SimulatedSource& source = sources[index];
        auto pieces = FilePieces::open_path(path);
        if (!pieces) {
            return tl::unexpected(pieces.error());
        }
        const auto kind = detect_recording_kind(**pieces, path);
        if (const auto& failed = (*pieces)->failed()) {
            return tl::unexpected(*failed);
        }
        if (!kind) {
            return tl::unexpected(kind.error());
        }
        if (*kind != RecordingKind::raw && is_empty(**pieces)) {
            continue;
        }
        if (auto wrong = misfit(path, *kind, source)) {
            return tl::unexpected(std::move(*wrong));
        }
        auto& recorded = arrivals.recordings_.emplace_back(
            std::make_unique<Recorded>(std::move(*pieces), path, *kind, index, source));
        if (auto begun = recorded->begin(); !begun) {
            return tl::unexpected(begun.error());
        }
        if (recorded->rest()) {
            arrivals.rests_.push_back(*recorded->rest());
        }
    }
    return arrivals;
}

tl::expected<const Arrival*, std::string> Arrivals::next() {
    if (latest_ != nullptr) {
        if (auto advanced = latest_->advance(); !advanced) {
            return tl::unexpected(advanced.error());
        }
    }
    latest_ = nullptr;
    for (const auto& recorded : recordings_) {
        if (!recorded->ended() &&
            (latest_ == nullptr || recorded->next().at < latest_->next().at)) {
            latest_ = recorded.get();
        }
    }
    return latest_ != nullptr ? &latest_->next() : nullptr;
}

void arrive(VirtualLoop& loop, const SimulatedSource& source, const Arrival& arrival) {
    if (const auto* frame = std::get_if<CanFrame>(&arrival.what)) {
        loop.receive(source.station, *frame, arrival.at);
    } else if (const auto* byte = std::get_if<ArrivedByte>(&arrival.what)) {
        const std::span bytes(&byte->value, 1);
        const std::array damaged{byte->damaged};
        if (byte->untimed && source.station.kind == StationKind::input) {
            loop.forget_read_time(source.station.index);
        }
        loop.receive(source.station, bytes, damaged, arrival.at);
        for (const Station station : source.replies) {
            loop.receive(station, bytes, damaged, arrival.at);
        }
    }
}

namespace {

void add_replies(const Configuration& configuration, std::vector<SimulatedSource>& sources) {
    for (const PortPlan& plan : plan_ports(configuration)) {
        const auto& stations = plan.wiring.stations;
        for (SimulatedSource& source : sources) {
            if (plan.config.medium->shape == WireShape::bytes &&
                std::ranges::find(stations, source.station) != stations.end()) {
                std::ranges::copy_if(
                    stations, std::back_inserter(source.replies),
                    [](Station other) { return other.kind == StationKind::replies; });
            }
        }
    }
}

}  // namespace

std::vector<SimulatedSource> simulated_sources(const Configuration& configuration) {
    std::vector<SimulatedSource> sources;
    for (std::size_t i = 0; i < configuration.inputs.size(); ++i) {
        const InputConfig& input = configuration.inputs[i];
        sources.push_back({.station = {.kind = StationKind::input, .index = i},
                           .name = input.name,
                           .protocol = input.protocol->name,
                           .port = &input.port,
                           .usual_period = input.protocol->default_period});
    }
    if (!needs_values(configuration)) {
        add_replies(configuration, sources);
        return sources;
    }
    for (std::size_t i = 0; i < configuration.sensor_buses.size(); ++i) {
        const SensorBusConfig& bus = configuration.sensor_buses[i];
        sources.push_back({.station = {.kind = StationKind::sensor_bus, .index = i},
                           .name = bus.name,
                           .protocol = kSensorBusName,
                           .port = &bus.port,
                           .usual_period = kUsualSlot});
    }
    std::size_t message = 0;
    for (const ValuesConfig& values : configuration.values) {
        if (const auto* source = std::get_if<ValueMessageConfig>(&values.source)) {
            sources.push_back({.station = {.kind = StationKind::value_message, .index = message++},
                               .name = values.name,
                               .protocol = protocol_of(*source),
                               .port = &source->port,
                               .usual_period = kUsualTelemetryPeriod});
        }
    }
    add_replies(configuration, sources);
    return sources;
}

}  // namespace tribus
