#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.h"
#include "pipelines/engine/engine.h"
#include "pipelines/stations/stations.h"
#include "pipelines/values/value_engine.h"

namespace tribus {

/// Hears of each transmission under virtual time.
class StationObserver {
  public:
    virtual ~StationObserver() = default;
    /// A station handed over `sent`.
    virtual void wrote(Station station, Instant at, const Transmission& sent) = 0;
    /// The engine was polled, whether or not an output wrote.
    virtual void polled(Instant /*at*/) {}
};

/// Drives an engine under virtual time, without a clock, descriptors or waiting. Time only moves
/// forward. Pure. Thread-bound.
class VirtualLoop {
  public:
    /// `values` is null if no sensor bus or value is configured. It must outlive the loop.
    VirtualLoop(Engine& engine, StationObserver& observer, Instant start,
                ValueEngine* values = nullptr);

    /// Runs every deadline before `until`, each exactly at its instant, and stops there.
    void run_until(Instant until);

    /// Undamaged bytes arrive at `at`, after all deadlines before it.
    void receive(Station station, std::span<const std::uint8_t> bytes, Instant at) {
        run_until(at);
        stations_.receive(station, bytes, at);
        poll(at);
    }
    /// The same for bytes with damage: see `Stations::receive`.
    template <class DamagedMarks>
    void receive(Station station, std::span<const std::uint8_t> bytes, const DamagedMarks& damaged,
                 Instant at) {
        run_until(at);
        stations_.receive(station, bytes, damaged, at);
        poll(at);
    }
    /// A CAN frame of another node arrives on the interface of a station.
    void receive(Station station, const CanFrame& frame, Instant at) {
        run_until(at);
        stations_.receive(station, frame, at);
        poll(at);
    }
    /// See `Engine::forget_read_time`.
    void forget_read_time(std::size_t input) { engine_->forget_read_time(input); }
    /// The device of a station is gone.
    void device_lost(Station station, Instant at) {
        run_until(at);
        stations_.device_lost(station);
        poll(at);
    }

    /// The thread did not run from `since`, which is now, until `until`: no deadline ran. Pass
    /// bytes that came meanwhile to the engine before this call, with the time `since`.
    void come_back(Instant since, Instant until);

    /// `next`, which has taken over from the present engine, runs from `at` on.
    void go_on_with(Engine& next, ValueEngine* values, Instant at);
    /// These parts send their last frames. Returns when they have.
    Instant retire(const Leaving& leaving, Instant at);

    /// Ends as the program does on request.
    void end(Instant at);

    Instant now() const { return now_; }

  private:
    void poll(Instant at);
    void send_ready(Instant at);

    Engine* engine_;
    Stations stations_;
    StationObserver& observer_;
    Instant now_;
    Instant next_ = kNever;
};

}  // namespace tribus
