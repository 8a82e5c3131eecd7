#include "tests/bench/ppm.h"

#include <poll.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <span>
#include <utility>
#include <vector>

#include "core/edge_records.h"
#include "pipelines/realtime/clock.h"
#include "tests/bench/tester.h"
#include "transports/codecs/ppm/ppm.h"
#include "transports/links/pulse_line/pulse_line_medium.h"

namespace tribus::bench {
namespace {

constexpr int kPollMilliseconds = 100;
constexpr std::size_t kLeastPpmFrames = 10;

/// The same distances of all frames, by two clocks.
struct ChannelTimes {
    std::vector<Duration> stamped;
    std::vector<Duration> bare;
};

/// Collects the channels of whole frames, and when a reader saw their edges.
class PpmCollector {
  public:
    void take(std::span<const std::uint8_t> bytes, Instant seen) {
        while (bytes.size() >= edge_records::kRecordBytes) {
            std::span<const std::uint8_t> record = bytes.first(edge_records::kRecordBytes);
            bytes = bytes.subspan(edge_records::kRecordBytes);
            const auto read = edge_records::record_of(record);
            const bool pause = read && read->eighths >= edge_records::kFrameGapEighths;
            DecodedFrame frame;
            if (decoder_.next(record, seen, frame)) {
                keep(frame.channels);
            }
            if (pause) {
                edges_.clear();
            }
            if (read && read->kind != edge_records::EdgeKind::quiet) {
                edges_.push_back(seen);
            }
        }
    }
    std::size_t frames() const { return channels_[0].stamped.size(); }
    PpmResult result() const {
        PpmResult result;
        result.frames = frames();
        for (const NamedCount& cause : decoder_.rejected()) {
            result.refused += cause.count;
        }
        std::vector<Duration> stamped;
        std::vector<Duration> bare;
        for (const ChannelTimes& channel : channels_) {
            result.channels += channel.stamped.empty() ? 0U : 1U;
            add_deviations(channel.stamped, stamped);
            add_deviations(channel.bare, bare);
        }
        result.stamped = Distribution(std::move(stamped));
        result.bare = Distribution(std::move(bare));
        return result;
    }

  private:
    void keep(const ChannelFrame& frame) {
        for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
            if (!frame.has(channel)) {
                break;
            }
            channels_[channel].stamped.emplace_back(frame.channel(channel)->eighths() * 125);
            if (channel + 1 < edges_.size()) {
                channels_[channel].bare.push_back(edges_[channel + 1] - edges_[channel]);
            }
        }
    }
    static void add_deviations(std::vector<Duration> times, std::vector<Duration>& deviations) {
        if (times.empty()) {
            return;
        }
        const auto middle = times.begin() + static_cast<std::ptrdiff_t>(times.size() / 2);
        std::nth_element(times.begin(), middle, times.end());
        const Duration median = *middle;
        for (const Duration time : times) {
            deviations.push_back(std::chrono::abs(time - median));
        }
    }

    PpmDecoder decoder_{1};
    std::vector<Instant> edges_;
    std::array<ChannelTimes, kChannelCount> channels_;
};

}  // namespace

tl::expected<PpmResult, std::string> measure_ppm(const std::string& line, Duration length) {
    auto opened = kPulseLineMedium.open(line, {.way = SettingScope::input});
    if (!opened) {
        return tl::unexpected(std::move(opened.error()));
    }
    ByteLink& link = *(*opened)->as_bytes();
    PpmCollector collector;
    const TesterPriority priority;
    const Instant end = monotonic_now() + length;
    while (monotonic_now() < end && !interrupted()) {
        std::array<pollfd, 2> both{
            {{link.descriptor(), POLLIN, 0}, {link.second_descriptor(), POLLIN, 0}}};
        ::poll(both.data(), both.size(), kPollMilliseconds);
        const Instant seen = monotonic_now();
        Reception reception;
        const ReadStatus status = link.read(reception);
        if (status == ReadStatus::lost) {
            return tl::unexpected(line + ": its chip is gone");
        }
        if (status == ReadStatus::received) {
            collector.take(reception.view(), seen);
        }
    }
    if (collector.frames() < kLeastPpmFrames && !interrupted()) {
        return tl::unexpected(line +
                              ": no PPM came; is a receiver or a trainer port connected, and "
                              "its transmitter on?");
    }
    return collector.result();
}

}  // namespace tribus::bench
