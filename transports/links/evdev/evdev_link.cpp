#include "transports/links/evdev/evdev_link.h"

#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/timerfd.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <climits>
#include <cstring>
#include <span>

namespace tribus {
namespace {

constexpr long kReportPeriodNanoseconds = 20'000'000;
constexpr int kMostEventReads = 16;

/// A set of codes as the kernel gives it.
template <std::size_t count>
struct CodeSet {
    static constexpr std::size_t kBits = CHAR_BIT * sizeof(unsigned long);
    std::array<unsigned long, (count + kBits - 1) / kBits> words{};
    bool has(std::size_t code) const { return (words[code / kBits] >> code % kBits & 1U) != 0; }
};

std::string evdev_problem(int error) {
    switch (error) {
        case EACCES:
        case EPERM:
            return "this user may not read it; join the group input: sudo usermod -aG input $USER; "
                   "for a service see /usr/share/doc/tribus/docs/service.md, \"Joysticks in the "
                   "service\"";
        case ENOENT:
        case ENODEV:
        case ENXIO:
            return "there is no such device";
        case EBUSY:
            return "another program has taken it for itself; stop it, or set grab = false";
        case ENOTTY:
        case EINVAL:
            return "this is no input device; `ls /dev/input/by-id` lists those that have a name";
        default:
            return std::strerror(error);
    }
}

UniqueFd report_timer() {
    UniqueFd timer(::timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC));
    const timespec period{.tv_sec = 0, .tv_nsec = kReportPeriodNanoseconds};
    const itimerspec ticks{.it_interval = period, .it_value = period};
    if (timer.valid()) {
        ::timerfd_settime(timer.get(), 0, &ticks, nullptr);  // refuses only other arguments
    }
    return timer;
}

}  // namespace

tl::expected<std::unique_ptr<EvdevLink>, std::string> EvdevLink::open(const std::string& device,
                                                                      bool grab) {
    const auto failed = [&device] { return tl::unexpected(device + ": " + evdev_problem(errno)); };
    UniqueFd fd(::open(device.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC));
    input_id id{};
    if (!fd.valid() || ::ioctl(fd.get(), EVIOCGID, &id) < 0) {
        return failed();
    }
    if (grab && ::ioctl(fd.get(), EVIOCGRAB, 1) != 0) {
        return failed();
    }
    UniqueFd timer = report_timer();
    if (!timer.valid()) {
        return failed();
    }
    std::unique_ptr<EvdevLink> link(new EvdevLink(std::move(fd), std::move(timer)));
    link->find_axes();
    link->read_whole_state();
    return link;
}

void EvdevLink::find_axes() {
    CodeSet<ABS_CNT> axes;
    ::ioctl(fd_.get(), EVIOCGBIT(EV_ABS, sizeof axes.words), axes.words.data());
    for (std::uint16_t code = 0; code < ABS_MT_SLOT; ++code) {
        input_absinfo range{};
        if (axes.has(code) && ::ioctl(fd_.get(), EVIOCGABS(code), &range) >= 0) {
            state_.add_axis(code, range);
        }
    }
}

void EvdevLink::read_whole_state() {
    for (const std::uint16_t code : state_.axis_codes()) {
        input_absinfo range{};
        if (::ioctl(fd_.get(), EVIOCGABS(code), &range) != -1) {
            state_.set_axis(code, range.value);
        }
    }
    CodeSet<KEY_CNT> pressed;
    if (::ioctl(fd_.get(), EVIOCGKEY(sizeof pressed.words), pressed.words.data()) != -1) {
        for (std::uint16_t code = BTN_MISC; code < KEY_CNT; ++code) {
            state_.set_button(code, pressed.has(code));
        }
    }
}

/// Takes all events that wait.
EvdevLink::Taken EvdevLink::take_events() {
    Taken taken;
    std::array<input_event, 64> events{};
    for (int reads = 0; reads < kMostEventReads; ++reads) {
        const ssize_t bytes = ::read(fd_.get(), events.data(), sizeof events);
        if (bytes == -1) {
            taken.gone = errno != EAGAIN && errno != EINTR;
            return taken;
        }
        taken.any = true;
        const std::size_t count = static_cast<std::size_t>(bytes) / sizeof events[0];
        for (const input_event& event : std::span(events).first(count)) {
            if (state_.take(event) == EvdevState::Outcome::dropped) {
                read_whole_state();
            }
        }
        if (count < events.size()) {
            break;
        }
    }
    return taken;
}

ReadStatus EvdevLink::read(Reception& reception) {
    reception.damaged.reset();
    reception.count = 0;
    reception.full = false;
    reception.goes_on = false;
    if (gone_) {
        return ReadStatus::lost;
    }
    std::uint64_t ticks = 0;
    const bool ticked = ::read(timer_.get(), &ticks, sizeof ticks) == sizeof ticks;
    const Taken taken = take_events();
    gone_ = taken.gone;
    if (!ticked && !taken.any && !gone_) {
        return ReadStatus::nothing;
    }
    reception.full = gone_;
    reception.count =
        state_.write(std::span(reception.bytes).first<gamepad_report::kMostBytes>(), gone_);
    return ReadStatus::received;
}

WriteStatus EvdevLink::write(std::span<const std::uint8_t> /*frame*/) {
    return WriteStatus::unavailable;
}

/// The next report has the state of now, whatever waits.
void EvdevLink::discard_unread() {
    take_events();
}

}  // namespace tribus
