#include "pipelines/engine/input.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "core/utf8.h"

namespace tribus {

Input::Input(InputSettings settings, std::uint8_t index)
    : name_(std::move(settings.name)),
      decoder_(std::move(settings.decoder)),
      index_(index),
      supervisor_(std::move(settings.supervision)),
      ongoing_{.pauses = LinePauses(settings.byte_time)} {
    supervisor_.ask(decoder());
    if (!settings.channels.empty()) {
        map_.emplace(settings.channels);
        has_slews_ = map_->has_slews();
    }
}

void Input::continue_from(Input& before, const InputCarry& carry, Instant now) {
    std::swap(decoder_, before.decoder_);
    if (carry.new_keys) {
        std::visit([&](auto& decoder) { decoder->use_keys_of(before.decoder()); }, decoder_);
    }
    ongoing_ = before.ongoing_;
    ongoing_.latest.source = index_;
    mapped_ = before.control();
    supervisor_.continue_from(before.supervisor_, now);
    supervisor_.ask(decoder());
    looked_at_ = kNever;
    if (carry.same_channels) {
        std::swap(map_, before.map_);
    } else if (map_ && supervisor_.ever_good()) {
        map_->restart_from(mapped_, now);
        mapped_ = map_->apply(supervisor_.control(), now);
    }
}

[[gnu::flatten]] bool Input::decode(std::span<const std::uint8_t> bytes, Instant now) {
    bool any = false;
    while (byte_decoder().next(bytes, now, decoded_)) {
        take_decoded(now);
        any = true;
    }
    return any;
}

bool Input::pause(Instant now) {
    bool any = false;
    while (byte_decoder().silence(decoded_)) {
        take_decoded(now);
        any = true;
    }
    return any;
}

/// A frame that the decoder held back is as old as its last byte, not as the byte that released it.
void Input::take_decoded(Instant now) {
    ongoing_.pauses.frame_came(decoded_.first_byte, decoded_.length);
    const Instant arrival = ongoing_.read_times.of(decoded_.first_byte + decoded_.length - 1);
    decoded_.channels.received = arrival - byte_decoder().age();
    take(decoded_.channels, arrival, now);
}

void Input::device_lost() {
    ++ongoing_.counts.device_losses;
    start_anew();
}

/// Discards a frame received in part: the next bytes do not continue it.
void Input::start_anew() {
    if (!on_can()) {
        byte_decoder().reset();
    }
    forget_read_time();
}

bool Input::receive(const CanFrame& frame, Instant at) {
    if (std::ranges::none_of(wanted_ids(),
                             [&](const CanIdMatch& id) { return id.matches(frame); })) {
        return false;
    }
    count_bytes(frame.length, at);
    auto snapshot = can_decoder()->next(frame, at);
    if (snapshot) {
        take(*snapshot, at, at);
    }
    return snapshot.has_value();
}

std::span<const CanIdMatch> Input::wanted_ids() const {
    return on_can() ? can_decoder()->wanted() : std::span<const CanIdMatch>{};
}

std::span<const CanIdMatch> Input::answered_ids() const {
    return on_can() ? can_decoder()->answered() : std::span<const CanIdMatch>{};
}

Transmission Input::answer(Instant now) {
    return std::visit([now](auto& decoder) { return Transmission(decoder->answer(now)); },
                      decoder_);
}

const DecoderReport& Input::decoder() const {
    return std::visit([](const auto& decoder) -> const DecoderReport& { return *decoder; },
                      decoder_);
}

FaultText Input::fault() const {
    const bool by_decoder = ongoing_.state.cause == LinkCause::garbled ||
                            (ongoing_.state.cause == LinkCause::radio_lost &&
                             ongoing_.state.sign == RadioLossSign::failsafe_flag);
    FaultText fault;
    fault.length = by_decoder ? decoder().write_fault(fault.text) : 0;
    // A text that is cut may end within a character.
    while (fault.length == fault.text.size() && !is_utf8(fault.view())) {
        --fault.length;
    }
    return fault;
}

void Input::judge(Instant now) {
    looked_at_ = now;
    const LinkState fresh = supervisor_.state(now);
    if (fresh.cause != ongoing_.state.cause) {
        change_state(fresh, now);
    } else {
        ongoing_.state = fresh;
    }
}

[[gnu::cold]] void Input::change_state(const LinkState& fresh, Instant now) {
    ++ongoing_.counts.began[static_cast<std::size_t>(fresh.cause)];
    ongoing_.loss = fresh.cause == LinkCause::good ? ongoing_.loss : fresh;
    ongoing_.loss_at = now;
    ongoing_.state = fresh;
    if (watch_ != nullptr) {
        watch_->input_changed(index_, now);
    }
}

/// Between two frames of the input, slews go on towards what the latest one said.
void Input::move_slews(Instant now) {
    if (supervisor_.alive(now)) {
        mapped_ = map_->apply(supervisor_.control(), now);
    }
}

/// The time of a loss is no time for its slews to move.
void Input::supervise_and_map(ChannelFrame& frame, Instant arrival, Instant now) {
    if (!supervisor_.alive(arrival)) {
        map_->rest(now);
    }
    supervisor_.take(frame, arrival);
    mapped_ = map_->apply(supervisor_.control(), now);
}

void Input::take(ChannelFrame& frame, Instant arrival, Instant now) {
    frame.source = index_;
    frame.sequence = ongoing_.latest.sequence + 1;
    ++ongoing_.counts.frames;
    ongoing_.arrivals.arrived(arrival);
    if (map_) {
        supervise_and_map(frame, arrival, now);
    } else {
        supervisor_.take(frame, arrival);
    }
    ongoing_.latest = frame;
    ongoing_.counts.failsafe_frames += frame.failsafe ? 1U : 0U;
    ongoing_.counts.frame_lost_frames += frame.frame_lost && !frame.failsafe ? 1U : 0U;
    judge(now);
}

}  // namespace tribus
