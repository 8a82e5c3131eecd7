#include "app/daemon/watchdog.h"

#include <algorithm>

#include "app/status/status_line.h"

namespace tribus {
namespace {

/// Two and a half times the usual distance of two looks. In a longer pause this thread did not run,
/// and perhaps no other.
constexpr Duration kLongestPause = std::chrono::milliseconds(500);

}  // namespace

void Watchdog::restart() {
    looked_at_.reset();
    watched_.reset();
    judged_.reset();
    standing_ = {};
    punctuality_ = Punctuality::on_time;
}

void Watchdog::watch(Instant now, Instant published, const Standing& standing) {
    const Duration pause = looked_at_ ? now - *looked_at_ : Duration::zero();
    compares_from_ = pause > kLongestPause ? now : compares_from_;
    const Duration elapsed = std::min(pause, kLongestPause);
    watched_for_ = watched_ == published ? watched_for_ + elapsed : Duration::zero();
    watched_ = published;
    stands_for_ = standing_ == standing ? stands_for_ + elapsed : Duration::zero();
    standing_ = standing;
    looked_at_ = now;
}

Punctuality Watchdog::judge(Instant published, std::span<const OutputProgress> outputs) {
    if (watched_for_ > kFigureLife) {
        return Punctuality::data_thread_stands;
    }
    if (standing_.part != Standing::Part::none && stands_for_ > kFigureLife) {
        return Punctuality::part_stands;
    }
    if (judged_ == published) {
        return punctuality_;
    }
    const bool comparable =
        judged_ && *judged_ >= compares_from_ && outputs_.size() == outputs.size();
    const Duration window = comparable ? published - *judged_ : Duration::zero();
    outputs_.resize(outputs.size());
    Punctuality judged = Punctuality::on_time;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        const OutputProgress& output = outputs[i];
        // The data thread does all that is due before it publishes.
        const bool skipped = later(output.due, output.period) < published;
        const auto missed = comparable ? output.overruns - outputs_[i].progress.overruns : 0;
        const bool misses_half =
            static_cast<double>(missed) * 2.0 * static_cast<double>(output.period.count()) >
            static_cast<double>(window.count());
        // A stop of the whole program makes an output miss its turns once, not twice in a row.
        const bool late = skipped || (misses_half && outputs_[i].missed_half);
        if (late && judged == Punctuality::on_time) {
            judged = Punctuality::output_late;
            late_output_ = i;
        }
        outputs_[i] = {output, misses_half};
    }
    judged_ = published;
    return judged;
}

bool Watchdog::look(Instant now, Instant published, std::span<const OutputProgress> outputs,
                    const Standing& standing) {
    watch(now, published, standing);
    punctuality_ = judge(published, outputs);
    const bool is_fresh = now - published <= kFigureLife;
    if (punctuality_ != Punctuality::on_time || !is_fresh || now < next_notification_) {
        return false;
    }
    // sd_watchdog_enabled(3) recommends half of the time.
    next_notification_ = now + limit_ / 2;
    return true;
}

}  // namespace tribus
