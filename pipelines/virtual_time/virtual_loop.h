#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/time.h"
#include "pipelines/engine/engine.h"
#include "pipelines/values/value_engine.h"

namespace tribus {

/// Gets what the engine writes under virtual time.
class OutputObserver {
  public:
    virtual ~OutputObserver() = default;
    /// An output handed over `sent`.
    virtual void wrote(std::size_t output, Instant at, const Transmission& sent) = 0;
    /// A sensor bus wrote `bytes`.
    virtual void bus_wrote(std::size_t /*bus*/, Instant /*at*/,
                           std::span<const std::uint8_t> /*bytes*/) {}
    /// A DroneCAN node wrote `frames`.
    virtual void node_wrote(std::size_t /*node*/, Instant /*at*/,
                            std::span<const CanFrame> /*frames*/) {}
    /// The engine was polled, whether or not an output wrote.
    virtual void polled(Instant /*at*/) {}
};

/// Drives an engine under virtual time, without a clock, descriptors or waiting. Time only moves
/// forward. Pure. Thread-bound.
class VirtualLoop {
  public:
    /// `values` is null if no sensor bus or value is configured. It must outlive the loop.
    VirtualLoop(Engine& engine, OutputObserver& observer, Instant start,
                ValueEngine* values = nullptr);

    /// Runs every deadline before `until`, each exactly at its instant, and stops there.
    void run_until(Instant until);

    /// Bytes arrive at `at`, after all deadlines before it.
    template <class DamagedMarks>
    void receive(std::size_t input, std::span<const std::uint8_t> bytes,
                 const DamagedMarks& damaged, Instant at) {
        run_until(at);
        engine_->receive(input, bytes, damaged, at);
        poll(at);
    }

    /// See `Engine::forget_read_time`.
    void forget_read_time(std::size_t input) { engine_->forget_read_time(input); }

    /// A CAN frame arrives at an input.
    void receive(std::size_t input, const CanFrame& frame, Instant at) {
        run_until(at);
        engine_->receive(input, frame, at);
        poll(at);
    }
    /// The device of an input is gone.
    void device_lost(std::size_t input, Instant at) {
        run_until(at);
        engine_->device_lost(input);
        poll(at);
    }
    /// Bytes arrive on a sensor bus.
    template <class DamagedMarks>
    void receive_on_bus(std::size_t bus, std::span<const std::uint8_t> bytes,
                        const DamagedMarks& damaged, Instant at) {
        run_until(at);
        values_->receive(bus, bytes, damaged, at);
        poll(at);
    }
    /// A CAN frame arrives on the interface of a message with values.
    void receive_values(std::size_t message, const CanFrame& frame, Instant at) {
        run_until(at);
        values_->receive(message, frame, at);
        poll(at);
    }
    /// A CAN frame arrives on the interface of a node of DroneCAN.
    void receive_node(std::size_t node, const CanFrame& frame, Instant at) {
        run_until(at);
        engine_->receive_node(node, frame, at);
        poll(at);
    }
    /// A CAN frame of another node arrives on the interface of an output.
    void watch_for_foreign_sender(std::size_t output, const CanFrame& frame, Instant at) {
        run_until(at);
        engine_->watch_for_foreign_sender(output, frame, at);
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
    Instant poll_values(Instant at);

    Engine* engine_;
    OutputObserver& observer_;
    ValueEngine* values_;
    Instant now_;
    Instant next_ = kNever;
};

}  // namespace tribus
