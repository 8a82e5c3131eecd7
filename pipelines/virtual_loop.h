#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.h"
#include "pipelines/engine.h"

namespace tribus {

/// Sees what outputs write under virtual time.
class OutputObserver {
  public:
    virtual ~OutputObserver() = default;
    virtual void wrote(std::size_t output, Instant at, const Transmission& sent) = 0;
};

/// Drives an engine under virtual time: the same engine, without a clock, descriptors or waiting.
/// Time only moves forward. Pure; thread-bound.
class VirtualLoop {
  public:
    VirtualLoop(Engine& engine, OutputObserver& observer, Instant start);

    /// Runs every deadline before `until`, each exactly at its instant, and stops there.
    void run_until(Instant until);

    /// Bytes arrive at `at`, after all deadlines before it.
    template <class DamagedMarks>
    void receive(std::size_t input, std::span<const std::uint8_t> bytes,
                 const DamagedMarks& damaged, Instant at) {
        run_until(at);
        engine_.receive(input, bytes, damaged, at);
        poll(at);
    }

    /// A CAN frame arrives at an input.
    void receive(std::size_t input, const CanFrame& frame, Instant at) {
        run_until(at);
        engine_.receive(input, frame, at);
        poll(at);
    }
    /// A CAN frame of another node arrives on the interface of an output.
    void watch_for_foreign_sender(std::size_t output, const CanFrame& frame, Instant at) {
        run_until(at);
        engine_.watch_for_foreign_sender(output, frame, at);
        poll(at);
    }

    /// As when the program is told to stop.
    void end(Instant at);

    Instant now() const { return now_; }

  private:
    void poll(Instant at);

    Engine& engine_;
    OutputObserver& observer_;
    Instant now_;
    Instant next_ = kNever;
};

}  // namespace tribus
