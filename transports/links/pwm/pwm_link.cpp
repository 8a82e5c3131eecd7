#include "transports/links/pwm/pwm_link.h"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "core/pwm_pulses.h"

namespace tribus {

tl::expected<std::unique_ptr<PwmLink>, std::string> PwmLink::open(
    const std::string& chip, Duration period, const WorkerSettings& worker,
    const std::filesystem::path& root) {
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
    std::unique_ptr<PwmLink> link(new PwmLink(std::move(*found), period));
    if (auto problem = link->worker_.start(worker, [&link = *link] { return link.hand_on(); });
        !problem.empty()) {
        return tl::unexpected(chip + ": " + problem);
    }
    return link;
}

PwmLink::PwmLink(PwmChipFacts chip, Duration period)
    : chip_(chip), outputs_(std::move(chip), period) {
    for (auto& pulse : wanted_) {
        pulse.store(kNothing, std::memory_order_relaxed);
    }
}

ReadStatus PwmLink::read(Reception& reception) {
    reception.count = 0;
    reception.full = false;
    return ReadStatus::nothing;
}

WriteStatus PwmLink::write_asked(std::span<const std::uint8_t> frame, FrameLife life) {
    for (std::size_t at = 0; at + pwm_pulses::kRecordBytes <= frame.size();
         at += pwm_pulses::kRecordBytes) {
        const auto record = frame.subspan(at, pwm_pulses::kRecordBytes);
        if (record[0] >= std::min(chip_.outputs, wanted_.size())) {
            return WriteStatus::unavailable;
        }
        wanted_[record[0]].store(pwm_pulses::nanoseconds_of(record));
    }
    return worker_.wake(life);
}

/// A pulse of 0 switches the output off, which is never too late.
WriteStatus PwmLink::hand_on(std::size_t output, Instant valid_until) {
    const std::uint32_t pulse = wanted_[output].load();
    if (pulse == kNothing) {
        return WriteStatus::written;
    }
    if (pulse != 0 && worker_.is_over(valid_until)) {
        return WriteStatus::busy;
    }
    WriteStatus outcome = WriteStatus::written;
    if (!outputs_.set(output, pulse).empty()) {
        outcome = outputs_.gone() ? WriteStatus::lost : WriteStatus::unavailable;
    }
    worker_.part_done(outcome);
    return outcome;
}

/// The worker hands the newest pulses to the kernel.
WriteStatus PwmLink::hand_on() {
    WriteStatus worst = WriteStatus::written;
    for (std::size_t output = 0; output < wanted_.size(); ++output) {
        // A newer frame may come at any time, so its life is read before its pulses.
        worst = std::max(worst, hand_on(output, worker_.valid_until()));
    }
    return worst;
}

}  // namespace tribus
