#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "core/time.h"
#include "core/value_board.h"
#include "pipelines/sensor_bus/role.h"

/// A sensor bus under virtual time: one wire where everybody, the sender too, receives each byte.
namespace tribus::test {

using namespace std::chrono_literals;

/// Time of one byte with the gaps of genuine receivers (docs/protocols/ibus.md, "Line").
inline constexpr Duration kSensorByteTime = 95'580ns;

class SensorWire {
  public:
    /// A role on the wire, and its board.
    struct End {
        SensorBusRole* role = nullptr;
        ValueBoard* board = nullptr;
        /// The end does nothing before this time, because its machine is stalled.
        Instant stalled_until{};
    };
    using Bytes = std::vector<std::uint8_t>;
    /// Changes a frame on the wire. `from` is the index of its sender.
    using Trouble = std::function<void(std::size_t from, Bytes& bytes, Instant at)>;
    using Listener =
        std::function<void(std::size_t from, std::span<const std::uint8_t> bytes, Instant at)>;

    SensorWire(std::vector<End> ends, Instant start) : ends_(std::move(ends)), now_(start) {
        for (End& end : ends_) {
            end.role->start(start);
        }
    }

    void on_frame(Trouble trouble) { trouble_ = std::move(trouble); }
    /// Calls `listener` with each unchanged frame when its last byte has been sent.
    void listen(Listener listener) { listener_ = std::move(listener); }
    void stall(std::size_t end, Instant until) { ends_[end].stalled_until = until; }
    /// Puts bytes on the wire that no end sent.
    void speak(const Bytes& bytes, Instant at) { put(kNobody, bytes, at); }
    Instant now() const { return now_; }

    void run_until(Instant until) {
        for (Instant next = next_event(); next < until; next = next_event()) {
            now_ = std::max(now_, next);
            deliver();
            for (std::size_t end = 0; end < ends_.size(); ++end) {
                turn(end);
            }
        }
        now_ = until;
    }

    static constexpr std::size_t kNobody = SIZE_MAX;

  private:
    struct Heard {
        std::size_t from = kNobody;
        Bytes meant;
        Bytes bytes;
    };

    Instant next_event() const {
        Instant next = heard_.empty() ? kNever : heard_.begin()->first;
        for (const End& end : ends_) {
            next = std::min(next, std::max(end.role->due(), end.stalled_until));
            if (!end_backlog_.empty() && end.stalled_until > now_) {
                next = std::min(next, end.stalled_until);
            }
        }
        return std::max(next, now_);
    }

    void deliver() {
        while (!heard_.empty() && heard_.begin()->first <= now_) {
            const Heard heard = std::move(heard_.begin()->second);
            heard_.erase(heard_.begin());
            if (listener_) {
                listener_(heard.from, heard.meant, now_);
            }
            for (std::size_t end = 0; end < ends_.size(); ++end) {
                Bytes& waiting = end_backlog_[end];
                waiting.insert(waiting.end(), heard.bytes.begin(), heard.bytes.end());
            }
        }
        for (auto& [end, waiting] : end_backlog_) {
            if (ends_[end].stalled_until <= now_ && !waiting.empty()) {
                ends_[end].role->receive(waiting, now_, *ends_[end].board);
                waiting.clear();
            }
        }
    }

    void turn(std::size_t index) {
        End& end = ends_[index];
        if (end.stalled_until > now_ || end.role->due() > now_) {
            return;
        }
        const auto said = end.role->run(now_, *end.board);
        if (!said.empty()) {
            put(index, Bytes(said.begin(), said.end()), now_);
            end.role->written(now_, *end.board);
        }
    }

    void put(std::size_t from, const Bytes& bytes, Instant at) {
        Heard heard{.from = from, .meant = bytes, .bytes = bytes};
        if (trouble_) {
            trouble_(from, heard.bytes, at);
        }
        const auto length = static_cast<Duration::rep>(bytes.size());
        heard_.emplace(at + length * kSensorByteTime, std::move(heard));
    }

    std::vector<End> ends_;
    Instant now_;
    Trouble trouble_;
    Listener listener_;
    std::multimap<Instant, Heard> heard_;
    std::map<std::size_t, Bytes> end_backlog_;
};

}  // namespace tribus::test
