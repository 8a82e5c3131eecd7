#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "config/build.h"
#include "config/schema.h"
#include "core/time.h"
#include "pipelines/engine.h"
#include "pipelines/realtime/data_thread.h"
#include "pipelines/realtime/loop.h"

namespace tribus {

/// A configuration at work: its engine, its open devices and its data thread. Thread-bound to the
/// main thread.
class Appliance {
  public:
    enum class MissingDevices : std::uint8_t {
        refuse,    ///< each is an error
        wait_for,  ///< as if they had vanished later; `tend` opens them
    };
    /// Opens every device and starts. The error is one line for each thing that is wrong, and
    /// nothing stays open then.
    static tl::expected<std::unique_ptr<Appliance>, std::vector<std::string>> start(
        Configuration configuration, MissingDevices missing = MissingDevices::refuse);

    Appliance(const Appliance&) = delete;
    Appliance& operator=(const Appliance&) = delete;

    /// A change of one device or interface: it is gone, or it is back.
    struct DeviceEvent {
        const PortConfig* port = nullptr;
        bool back = false;
    };
    /// Closes devices that vanished and opens those that are back. Call a few times a second.
    std::vector<DeviceEvent> tend();

    /// Every output says its last frames as its failsafe wants; returns when that is done.
    void end();

    const Configuration& configuration() const { return configuration_; }
    /// What real time could not be had, as sentences.
    const std::vector<std::string>& missing_realtime() const { return missing_realtime_; }
    InputStatus input_status(std::size_t input) const { return loop_->input_status(input); }
    OutputStatus output_status(std::size_t output) const { return loop_->output_status(output); }
    /// Devices and interfaces, each once.
    const std::vector<PortPlan>& ports() const { return plans_; }
    /// Of a port that is a CAN interface.
    CanLinkStatus can_status(std::size_t port) const { return loop_->can_status(port); }
    /// An input or output of that port has FD frames.
    bool uses_fd(const PortWiring& wiring) const;

  private:
    explicit Appliance(Configuration configuration);
    std::vector<std::string> open_devices(MissingDevices missing);

    Configuration configuration_;
    std::vector<PortPlan> plans_;
    std::vector<bool> missing_;
    std::unique_ptr<Engine> engine_;
    std::unique_ptr<Loop> loop_;
    std::unique_ptr<DataThread> thread_;
    std::vector<std::string> missing_realtime_;
};

}  // namespace tribus
