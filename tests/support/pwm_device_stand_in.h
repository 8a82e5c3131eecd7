#pragma once

#include <cerrno>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/device_stand_in.h"

namespace tribus::test {

/// The character device of a PWM chip, as Linux 6.17 and later have it (include/uapi/linux/pwm.h).
/// It does what is asked of it and notes that; it knows neither outputs nor whose they are. Makes a
/// file at its path. Thread-safe.
class PwmDeviceStandIn final : public DeviceStandIn {
  public:
    explicit PwmDeviceStandIn(const std::filesystem::path& file) : DeviceStandIn(made(file)) {}

    /// The calls since the last question: "request 1", "set 1: 1500000 of 20000000 ns", "free 1".
    std::vector<std::string> take() {
        const std::lock_guard lock(mutex_);
        return std::exchange(done_, {});
    }
    /// From now on what begins so is refused with this errno.
    void refuse(const std::string& beginning, int error) {
        const std::lock_guard lock(mutex_);
        refusals_[beginning] = error;
    }
    /// From now on each period becomes this one.
    void make_period(std::uint64_t nanoseconds) {
        const std::lock_guard lock(mutex_);
        period_ = nanoseconds;
    }
    /// From now on what begins so waits until `go_on`.
    void keep(const std::string& beginning) {
        const std::lock_guard lock(mutex_);
        kept_ = beginning;
    }
    void go_on() {
        keep("");
        changed_.notify_all();
    }

    Answer control(unsigned long request, void* argument) override {
        const std::string number = std::to_string(reinterpret_cast<std::uintptr_t>(argument));
        auto* const wave = static_cast<Wave*>(argument);
        switch (request) {
            case 0x7501:
                return note("request " + number);
            case 0x7502:
                return note("free " + number);
            case 0x40207505:
                return note("set " + text_of(*wave));
            case 0xC0207503: {
                const Answer answer = note("round " + text_of(*wave));
                const std::lock_guard lock(mutex_);
                wave->period_ns = period_.value_or(wave->period_ns);
                return answer;
            }
            default:
                return -ENOTTY;
        }
    }

  private:
    struct Wave {
        std::uint32_t output;
        std::uint32_t zero;
        std::uint64_t period_ns;
        std::uint64_t pulse_ns;
        std::uint64_t pulse_begins_ns;
    };

    static std::string made(const std::filesystem::path& file) {
        std::filesystem::create_directories(file.parent_path());
        std::ofstream(file) << "";
        return file.string();
    }
    static std::string text_of(const Wave& wave) {
        return std::to_string(wave.output) + ": " + std::to_string(wave.pulse_ns) + " of " +
               std::to_string(wave.period_ns) + " ns" +
               (wave.zero != 0 || wave.pulse_begins_ns != 0 ? ", and more" : "");
    }
    long note(const std::string& asked_for) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return kept_.empty() || !asked_for.starts_with(kept_); });
        for (const auto& [beginning, error] : refusals_) {
            if (asked_for.starts_with(beginning)) {
                return -error;
            }
        }
        done_.push_back(asked_for);
        return 0;
    }

    std::mutex mutex_;
    std::condition_variable changed_;
    std::vector<std::string> done_;
    std::map<std::string, int> refusals_;
    std::string kept_;
    std::optional<std::uint64_t> period_;
};

}  // namespace tribus::test
