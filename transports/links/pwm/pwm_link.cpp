#include "transports/links/pwm/pwm_link.h"

#include <sched.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include "core/pwm_pulses.h"

namespace tribus {
namespace {

constexpr std::uint64_t kOnce = 1;

}  // namespace

tl::expected<std::unique_ptr<PwmLink>, std::string> PwmLink::open(
    const std::string& chip, Duration period, const std::filesystem::path& root) {
    auto found = find_pwm_chip(chip, root);
    if (!found) {
        return tl::unexpected(std::move(found.error()));
    }
    const std::filesystem::path needed =
        found->device.empty() ? found->folder / "export" : found->device;
    if (::access(needed.c_str(), W_OK) != 0) {
        return tl::unexpected(
            chip +
            ": this user may not use it; the package's udev rule gives it to the group "
            "gpio: join the group, and for a service see "
            "/usr/share/doc/tribus/docs/service.md, \"PWM in the service\"");
    }
    UniqueFd wake_up(::eventfd(0, EFD_CLOEXEC));
    if (!wake_up.valid()) {
        return tl::unexpected(chip + ": " + std::strerror(errno));
    }
    try {
        return std::unique_ptr<PwmLink>(new PwmLink(std::move(*found), period, std::move(wake_up)));
    } catch (const std::system_error& error) {
        return tl::unexpected(chip + ": cannot start a thread: " + error.what());
    }
}

PwmLink::PwmLink(PwmChipFacts chip, Duration period, UniqueFd wake_up)
    : chip_(chip), wake_up_(std::move(wake_up)), outputs_(std::move(chip), period) {
    for (auto& pulse : wanted_) {
        pulse.store(kNothing, std::memory_order_relaxed);
    }
    thread_ = std::thread([this] { work(); });
}

PwmLink::~PwmLink() {
    ends_.store(true);
    [[maybe_unused]] const auto woken = ::write(wake_up_.get(), &kOnce, sizeof kOnce);
    thread_.join();
}

ReadStatus PwmLink::read(Reception& reception) {
    reception.count = 0;
    reception.full = false;
    return ReadStatus::nothing;
}

WriteStatus PwmLink::write(std::span<const std::uint8_t> frame) {
    for (std::size_t at = 0; at + pwm_pulses::kRecordBytes <= frame.size();
         at += pwm_pulses::kRecordBytes) {
        const auto record = frame.subspan(at, pwm_pulses::kRecordBytes);
        if (record[0] >= std::min(chip_.outputs, wanted_.size())) {
            return WriteStatus::unavailable;
        }
        wanted_[record[0]].store(pwm_pulses::nanoseconds_of(record), std::memory_order_relaxed);
    }
    [[maybe_unused]] const auto woken = ::write(wake_up_.get(), &kOnce, sizeof kOnce);
    return refused_.load(std::memory_order_relaxed) ? WriteStatus::unavailable
                                                    : WriteStatus::written;
}

/// Hands the newest pulses to the kernel. Returns whether it took all of them.
bool PwmLink::pass_on() {
    bool taken = true;
    for (std::size_t output = 0; output < wanted_.size(); ++output) {
        const std::uint32_t pulse = wanted_[output].load(std::memory_order_relaxed);
        taken = (pulse == kNothing || outputs_.set(output, pulse).empty()) && taken;
    }
    return taken;
}

void PwmLink::work() {
    // Before everything that is not real time; refused without the right to it.
    const sched_param priority{.sched_priority = 1};
    ::sched_setscheduler(0, SCHED_FIFO, &priority);
    std::uint64_t count = 0;
    while (!ends_.load()) {
        if (::read(wake_up_.get(), &count, sizeof count) == sizeof count && !ends_.load()) {
            refused_.store(!pass_on(), std::memory_order_relaxed);
        }
    }
}

}  // namespace tribus
