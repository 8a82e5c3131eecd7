#include "app/learn/learn_pad.h"

#include <poll.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <tl/expected.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/main_wait.h"
#include "app/cli/streams.h"
#include "app/journal/print_error.h"
#include "app/learn/learn_step.h"
#include "app/learn/pad_lesson.h"
#include "core/quotes.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/evdev/evdev_devices.h"
#include "transports/links/evdev/evdev_link.h"

namespace tribus {
namespace {

using namespace std::chrono_literals;

constexpr Duration kLookEach = 20ms;
/// Without a terminal nobody can say that a control does not exist.
constexpr Duration kPatienceAlone = 15s;
constexpr Duration kPatienceAtTerminal = 2min;

/// Why nothing was learned.
struct PadFailure {
    std::string why;
    int status = kExitFailed;
};
using PadFailed = tl::unexpected<PadFailure>;

std::string two_sentences(std::string first, std::string_view second) {
    first += first.empty() || second.empty() ? "" : " ";
    return first += second;
}

/// A line of the person, or the end of what they write on.
enum class PadAnswer : std::uint8_t { none, line, end };

class PadWatch {
  public:
    PadWatch(MainWait wait, std::unique_ptr<EvdevLink> link, std::string device, LearnGuide guide)
        : wait_(std::move(wait)),
          link_(std::move(link)),
          device_(std::move(device)),
          guide_(guide) {}

    tl::expected<GamepadSettings, PadFailure> run() {
        say();
        while (lesson_.step() != PadStep::done) {
            const std::array watched{link_->descriptor(), link_->second_descriptor(),
                                     listens() ? STDIN_FILENO : -1};
            if (const auto signal = wait_.until(later(monotonic_now(), kLookEach), watched)) {
                return PadFailed({.why = device_ + ": interrupted; nothing was learned",
                                  .status = *signal == SIGINT ? kExitInterrupted : kExitFailed});
            }
            if (auto failure = look(monotonic_now())) {
                return PadFailed(std::move(*failure));
            }
        }
        if (lesson_.learned().axes.empty() && lesson_.learned().buttons.empty()) {
            return PadFailed({.why = device_ +
                                     ": no stick was moved and no button was pressed; nothing was "
                                     "learned. Is this the right device? `tribus doctor` lists "
                                     "gamepads"});
        }
        return lesson_.learned();
    }
    std::string last_remark() { return lesson_.take_remark(); }

  private:
    bool listens() const { return guide_ != LearnGuide::alone; }

    std::optional<PadFailure> look(Instant now) {
        if (!receive(now)) {
            return PadFailure{.why = device_ +
                                     ": it was unplugged, or its Bluetooth link ended; nothing was "
                                     "learned. Connect it and begin again"};
        }
        const PadAnswer answer = listens() ? hear() : PadAnswer::none;
        if (answer == PadAnswer::end) {
            return PadFailure{.why = device_ + ": the terminal is gone; nothing was learned"};
        }
        // A program that guides the person says when a step is done.
        const bool complete = guide_ != LearnGuide::json && lesson_.is_complete(now);
        if (complete || answer == PadAnswer::line) {
            go_on(now);
            return std::nullopt;
        }
        return look_at_patience(now);
    }

    std::optional<PadFailure> look_at_patience(Instant now) {
        const Duration quiet = now - (std::max)(since_, lesson_.moved_at());
        const bool rests = lesson_.step() == PadStep::rest;
        if (guide_ == LearnGuide::json) {
            return std::nullopt;
        }
        if (rests && now - since_ > kPatienceAlone) {
            return PadFailure{
                .why = fmt::format("{}: something is pressed or moves although nobody touches it; "
                                   "nothing was learned. `evtest {}` shows what",
                                   device_, device_)};
        }
        if (guide_ == LearnGuide::terminal && quiet > kPatienceAtTerminal) {
            return PadFailure{.why = device_ +
                                     ": nothing was moved for two minutes; nothing was learned. "
                                     "Begin again"};
        }
        if (guide_ == LearnGuide::alone && quiet > kPatienceAlone) {
            go_on(now);
        }
        return std::nullopt;
    }

    void go_on(Instant now) {
        lesson_.next(now);
        since_ = now;
        if (lesson_.step() != PadStep::done) {
            say();
        }
    }

    /// Returns false if the device is gone.
    bool receive(Instant now) {
        const ReadStatus status = link_->read(reception_);
        if (status != ReadStatus::received) {
            return status != ReadStatus::lost;
        }
        const auto sight = pad_sight_of(reception_.view());
        if (sight && !sight->gone) {
            lesson_.see(*sight, now);
        }
        if (guide_ != LearnGuide::json) {
            print_remark();
        }
        return !sight || !sight->gone;
    }

    static PadAnswer hear() {
        pollfd input{.fd = STDIN_FILENO, .events = POLLIN, .revents = 0};
        if (::poll(&input, 1, 0) <= 0) {
            return PadAnswer::none;
        }
        std::array<char, 256> line{};
        return ::read(STDIN_FILENO, line.data(), line.size()) > 0 ? PadAnswer::line
                                                                  : PadAnswer::end;
    }

    std::string way_on() const {
        if (lesson_.step() == PadStep::rest) {
            return {};
        }
        return fmt::format("{}: {}.",
                           guide_ == LearnGuide::json       ? "Go on without it"
                           : guide_ == LearnGuide::terminal ? "Enter"
                                                            : "15 s without it",
                           lesson_.left_out());
    }

    void say() {
        const std::string order = two_sentences(lesson_.prompt(), way_on());
        if (guide_ == LearnGuide::json) {
            tell_learn_step("control", two_sentences(lesson_.take_remark(), order));
            return;
        }
        print_remark();
        tell_person(order, "- ");
    }

    void print_remark() {
        if (const std::string remark = lesson_.take_remark(); !remark.empty()) {
            tell_person(remark, "  ");
        }
    }

    MainWait wait_;
    std::unique_ptr<EvdevLink> link_;
    std::string device_;
    LearnGuide guide_;
    PadLesson lesson_;
    Instant since_ = monotonic_now();  ///< this step
    Reception reception_;
};

tl::expected<GamepadSettings, PadFailure> watch_pad(const PadToLearn& pad,
                                                    const EvdevDeviceFacts& facts, LearnGuide guide,
                                                    std::string& last_remark) {
    if (std::filesystem::path(facts.node).filename().string().starts_with("js")) {
        return PadFailed({.why = pad.device +
                                 ": this is the device for old programs; take the one for events: "
                                 "its name below /dev/input/by-id ends in -event-joystick"});
    }
    auto link = EvdevLink::open(pad.device, pad.grab);
    if (!link) {
        return PadFailed({.why = link.error()});
    }
    if (!facts.event.empty() && !facts.is_gamepad()) {
        return PadFailed({.why = fmt::format("{}: {} is no gamepad and no joystick: it has no "
                                             "sticks with buttons; `tribus doctor` lists those",
                                             pad.device, in_quotes(facts.name))});
    }
    auto wait = MainWait::for_signals({SIGINT, SIGTERM});
    if (!wait) {
        return PadFailed({.why = wait.error()});
    }
    PadWatch watch(std::move(*wait), std::move(*link), pad.device, guide);
    auto learned = watch.run();
    last_remark = watch.last_remark();
    return learned;
}

std::vector<std::string> advice_on(const PadToLearn& pad, const EvdevDeviceFacts& facts,
                                   const GamepadSettings& learned) {
    std::vector<std::string> advice;
    const std::string handy = dead_man_for(learned, facts.buttons);
    if (!learned.dead_man) {
        advice.push_back(fmt::format(
            "A machine that moves needs a button that must be held, because a gamepad that is laid "
            "down says nothing: dead_man = \"{}\"",
            handy.empty() ? "BTN_..." : handy));
    }
    if (pad.place.empty() && !facts.has_stable_name()) {
        advice.push_back(fmt::format(
            "{} may be another device after the next start. A rule of udev gives it a name that "
            "stays, here /dev/input/pad: SUBSYSTEM==\"input\", KERNEL==\"event*\", "
            "ATTRS{{{}}}=={}, SYMLINK+=\"input/pad\"",
            facts.device, facts.unique.empty() ? "name" : "uniq",
            in_quotes(facts.unique.empty() ? facts.name : facts.unique)));
    }
    return advice;
}

void print_learned(const PadToLearn& pad, const std::vector<std::string>& lines,
                   const std::vector<std::string>& advice) {
    for (const std::string& one : advice) {
        print_error("\n");
        tell_person(one);
    }
    print_error("\n");
    tell_person(
        pad.place.empty()
            ? std::string("For the configuration:")
            : fmt::format("Lines for {}, in place of its axes, buttons and dead_man:", pad.place));
    print_error("\n");
    for (const std::string& line : lines) {
        fmt::print("{}\n", line);
    }
}

}  // namespace

int learn_pad(const PadToLearn& pad, LearnGuide guide) {
    const EvdevDeviceFacts facts = look_at_evdev_device(pad.device);
    std::string last_remark;
    const auto learned = watch_pad(pad, facts, guide, last_remark);
    const bool json = guide == LearnGuide::json;
    if (!learned) {
        if (json) {
            tell_learn_step("broken", learned.error().why);
            return learned.error().status;
        }
        return complain(learned.error().why, learned.error().status);
    }
    std::vector<std::string> lines = pad_lines(*learned);
    if (pad.place.empty()) {
        lines.insert(lines.begin(), {"[input.pad]", "protocol = \"gamepad\"",
                                     "device   = " + in_quotes(facts.device)});
    }
    const std::vector<std::string> advice = advice_on(pad, facts, *learned);
    if (json) {
        for (const std::string& one : advice) {
            last_remark += fmt::format("{}{}.", last_remark.empty() ? "" : " ", one);
        }
        tell_learn_step("done", last_remark, lines);
    } else {
        if (!last_remark.empty()) {
            tell_person(last_remark, "  ");
        }
        print_learned(pad, lines, advice);
    }
    return kExitFine;
}

}  // namespace tribus
