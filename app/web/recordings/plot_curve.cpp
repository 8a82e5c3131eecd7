#include "app/web/recordings/plot_curve.h"

#include <algorithm>

namespace tribus::web {

/// Adds the present value to each column that [begin, end) touches.
void PlotCurve::cover(Duration begin, Duration end) {
    begin = std::max(begin, span_.from);
    end = std::min(end, span_.to);
    if (!value_ || begin >= end) {
        return;
    }
    const std::size_t last = span_.column(end - Duration(1));
    for (std::size_t column = span_.column(begin); column <= last; ++column) {
        columns_[column].least = std::min(columns_[column].least, *value_);
        columns_[column].greatest = std::max(columns_[column].greatest, *value_);
    }
}

void PlotCurve::set(Duration at, Pulse value) {
    end(at);
    value_ = value;
    since_ = at;
    // Another value of the same instant must not hide this one.
    cover(at, at + Duration(1));
}

void PlotCurve::end(Duration at) {
    cover(since_, at);
    value_.reset();
}

void PlotFrames::end_all(Duration at) {
    for (const auto& curve : curves_) {
        if (curve) {
            curve->end(at);
        }
    }
}

void PlotFrames::take(Duration at, const ChannelFrame& frame) {
    if (latest_ && at - *latest_ > gap_) {
        end_all(*latest_ + gap_);
    }
    latest_ = at;
    for (std::size_t channel = 0; channel < kChannelCount; ++channel) {
        auto& curve = curves_[channel];
        const auto pulse = frame.channel(channel);
        if (pulse && !curve) {
            curve = std::make_unique<PlotCurve>(span_);
        }
        if (pulse) {
            curve->set(at, *pulse);
        } else if (curve) {
            curve->end(at);
        }
    }
}

void PlotFrames::finish(Duration at) {
    if (latest_) {
        end_all(std::min(at, *latest_ + gap_));
    }
}

void PlotStates::set(Duration at, std::string_view word) {
    if (present_ && present_->word == word) {
        return;
    }
    finish(at);
    present_ = PlotState{.from = at, .to = {}, .word = word};
}

void PlotStates::finish(Duration at) {
    if (!present_) {
        return;
    }
    PlotState state = *present_;
    state.from = std::max(state.from, span_.from);
    state.to = std::min(at, span_.to);
    present_.reset();
    if (state.from >= state.to) {
        return;
    }
    if (states_.size() == kMost) {
        ++left_out_;
    } else {
        states_.push_back(state);
    }
}

}  // namespace tribus::web
