#include "app/daemon/watchdog.h"

namespace tribus {
namespace {

/// The data thread publishes several times a second even if it has nothing else to do. A longer gap
/// than this is no mere delay on a busy machine.
constexpr Duration kFigureLife = std::chrono::seconds(1);

}  // namespace

void Watchdog::restart() {
    published_.reset();
    outputs_.clear();
    punctuality_ = Punctuality::on_time;
}

Punctuality Watchdog::judge(Instant now, Instant published,
                            std::span<const OutputProgress> outputs) {
    if (now - published > kFigureLife) {
        return Punctuality::data_thread_stands;
    }
    if (published_ == published) {
        return punctuality_;
    }
    const bool comparable = published_ && outputs_.size() == outputs.size();
    const Duration window = comparable ? published - *published_ : Duration::zero();
    Punctuality judged = Punctuality::on_time;
    for (std::size_t i = 0; i < outputs.size() && judged == Punctuality::on_time; ++i) {
        const OutputProgress& output = outputs[i];
        // The data thread does all that is due before it publishes.
        const bool skipped = later(output.due, output.period) < published;
        const auto missed = comparable ? output.overruns - outputs_[i].overruns : 0;
        const bool misses_half = missed > 0 && static_cast<double>(missed) * 2.0 *
                                                       static_cast<double>(output.period.count()) >
                                                   static_cast<double>(window.count());
        if (skipped || misses_half) {
            judged = Punctuality::output_late;
            late_output_ = i;
        }
    }
    published_ = published;
    outputs_.assign(outputs.begin(), outputs.end());
    return judged;
}

bool Watchdog::look(Instant now, Instant published, std::span<const OutputProgress> outputs) {
    punctuality_ = judge(now, published, outputs);
    if (punctuality_ != Punctuality::on_time || now < next_notification_) {
        return false;
    }
    // sd_watchdog_enabled(3) recommends half of the time.
    next_notification_ = now + limit_ / 2;
    return true;
}

}  // namespace tribus
