#include "tests/support/gpiod_stand_in.h"

#include <fcntl.h>
#include <gpiod.h>
#include <linux/gpio.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <map>
#include <utility>

#include "transports/links/unique_fd.h"

namespace tribus::test {

/// Not in a namespace without a name: the chip's state in the header has it.
struct GpioLineState {
    StandInLine facts;
    bool held = false;
    bool silent = false;
    int type = 0;   ///< of the request
    int flags = 0;  ///< of the request
    std::string holder{};
    UniqueFd events{};  ///< the program's end
    UniqueFd source{};

    bool active_low() const { return (flags & GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW) != 0; }
};

namespace {

constexpr std::size_t kMostEvents = 16;

std::string text_of_type(int type) {
    switch (type) {
        case GPIOD_LINE_REQUEST_DIRECTION_OUTPUT:
            return "output";
        case GPIOD_LINE_REQUEST_EVENT_RISING_EDGE:
            return "rising edges";
        case GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE:
            return "falling edges";
        case GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES:
            return "both edges";
        default:
            return "type " + std::to_string(type);
    }
}

std::string text_of_flags(int flags) {
    static const std::map<int, std::string> names{
        {GPIOD_LINE_REQUEST_FLAG_OPEN_DRAIN, "open drain"},
        {GPIOD_LINE_REQUEST_FLAG_OPEN_SOURCE, "open source"},
        {GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW, "active-low"},
        {GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE, "no resistor"},
        {GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN, "pull-down"},
        {GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP, "pull-up"},
    };
    std::string text;
    for (const auto& [flag, name] : names) {
        text += (flags & flag) != 0 ? ", " + name : "";
    }
    return text;
}

}  // namespace

struct GpioChipStandIn::State {
    std::vector<GpioLineState> lines{};
    int refusal = 0;
    bool unplugged = false;
    int open_count = 0;
};

namespace {

using Chip = std::shared_ptr<GpioChipStandIn::State>;

/// By their paths.
std::map<std::string, Chip>& chips() {
    static std::map<std::string, Chip> all;
    return all;
}

}  // namespace

GpioChipStandIn::GpioChipStandIn(const std::string& name, std::vector<StandInLine> lines)
    : state_(std::make_shared<State>()), device_(name) {
    for (StandInLine& line : lines) {
        state_->lines.push_back({.facts = std::move(line)});
    }
    chips()[device_.path()] = state_;
}

GpioChipStandIn::~GpioChipStandIn() {
    chips().erase(device_.path());
}

void GpioChipStandIn::refuse(int error) {
    state_->refusal = error;
}

void GpioChipStandIn::unplug() {
    state_->unplugged = true;
    device_.remove();
    chips().erase(device_.path());
    for (GpioLineState& line : state_->lines) {
        if (line.events.valid()) {
            // A folder cannot be read.
            const UniqueFd folder(::open("/", O_RDONLY | O_DIRECTORY | O_CLOEXEC));
            ::dup2(folder.get(), line.events.get());
        }
    }
}

bool GpioChipStandIn::is_high(unsigned line) const {
    return state_->lines.at(line).facts.high;
}

void GpioChipStandIn::drive(unsigned number, bool high, std::uint64_t nanoseconds) {
    GpioLineState& line = state_->lines.at(number);
    if (std::exchange(line.facts.high, high) == high || !line.source.valid()) {
        return;
    }
    const bool rising = high != line.active_low();
    const int kind =
        rising ? GPIOD_LINE_REQUEST_EVENT_RISING_EDGE : GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE;
    int waiting = 0;
    ::ioctl(line.events.get(), FIONREAD, &waiting);
    const bool is_room = static_cast<std::size_t>(waiting) < kMostEvents * sizeof(gpioevent_data);
    if (is_room && (line.type == GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES || line.type == kind)) {
        const gpioevent_data event{
            .timestamp = nanoseconds,
            .id = static_cast<std::uint32_t>(rising ? GPIOEVENT_EVENT_RISING_EDGE
                                                    : GPIOEVENT_EVENT_FALLING_EDGE)};
        [[maybe_unused]] const auto written = ::write(line.source.get(), &event, sizeof event);
    }
}

void GpioChipStandIn::end_events(unsigned line) {
    state_->lines.at(line).source = UniqueFd();
}

void GpioChipStandIn::silence(unsigned line) {
    state_->lines.at(line).silent = true;
}

std::string GpioChipStandIn::requested(unsigned number) const {
    const GpioLineState& line = state_->lines.at(number);
    return line.held ? line.holder + ": " + text_of_type(line.type) + text_of_flags(line.flags)
                     : "";
}

int GpioChipStandIn::open_count() const {
    return state_->open_count;
}

}  // namespace tribus::test

using tribus::test::Chip;
using tribus::test::GpioLineState;

struct gpiod_line {
    gpiod_chip* chip;
    unsigned offset;

    GpioLineState& state() const;
    /// Sets errno where it does not.
    bool answers() const;
};

struct gpiod_chip {
    Chip chip;
    std::vector<gpiod_line> lines{};
    std::vector<bool> holds{};
};

GpioLineState& gpiod_line::state() const {
    return chip->chip->lines[offset];
}

bool gpiod_line::answers() const {
    errno = chip->chip->unplugged ? ENODEV : state().silent ? EIO : EPERM;
    return errno == EPERM && state().held;
}

extern "C" {

gpiod_chip* gpiod_chip_open(const char* path) {
    const auto found = tribus::test::chips().find(path);
    if (found == tribus::test::chips().end() || found->second->refusal != 0) {
        errno = found == tribus::test::chips().end() ? ENOENT : found->second->refusal;
        return nullptr;
    }
    auto* const opened = new gpiod_chip{.chip = found->second};
    const std::size_t count = opened->chip->lines.size();
    for (unsigned offset = 0; offset < count; ++offset) {
        opened->lines.push_back({opened, offset});
    }
    opened->holds.resize(count);
    ++opened->chip->open_count;
    return opened;
}

void gpiod_chip_close(gpiod_chip* chip) {
    for (const gpiod_line& line : chip->lines) {
        if (chip->holds[line.offset]) {
            line.state() = {.facts = line.state().facts};
        }
    }
    --chip->chip->open_count;
    delete chip;
}

unsigned gpiod_chip_num_lines(gpiod_chip* chip) {
    return static_cast<unsigned>(chip->lines.size());
}

gpiod_line* gpiod_chip_get_line(gpiod_chip* chip, unsigned offset) {
    if (offset >= chip->lines.size()) {
        errno = EINVAL;
        return nullptr;
    }
    gpiod_line* const line = &chip->lines[offset];
    errno = line->state().facts.undescribed;
    return errno == 0 ? line : nullptr;
}

const char* gpiod_line_name(gpiod_line* line) {
    const std::string& name = line->state().facts.name;
    return name.empty() ? nullptr : name.c_str();
}

const char* gpiod_line_consumer(gpiod_line* line) {
    const GpioLineState& state = line->state();
    const std::string& consumer = state.held ? state.holder : state.facts.consumer;
    return consumer.empty() ? nullptr : consumer.c_str();
}

bool gpiod_line_is_used(gpiod_line* line) {
    const GpioLineState& state = line->state();
    return state.held || state.facts.used || !state.facts.consumer.empty();
}

int gpiod_line_request(gpiod_line* line, const gpiod_line_request_config* config,
                       int default_value) {
    GpioLineState& state = line->state();
    if (gpiod_line_is_used(line) || state.facts.refusal != 0) {
        errno = state.facts.refusal != 0 ? state.facts.refusal : EBUSY;
        return -1;
    }
    state.held = true;
    state.holder = config->consumer == nullptr ? "?" : config->consumer;
    state.type = config->request_type;
    state.flags = config->flags;
    line->chip->holds[line->offset] = true;
    if (state.type == GPIOD_LINE_REQUEST_DIRECTION_OUTPUT) {
        state.facts.high = (default_value != 0) != state.active_low();
        return 0;
    }
    std::array<int, 2> ends{};
    if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
        return -1;
    }
    state.events = tribus::UniqueFd(ends[0]);
    state.source = tribus::UniqueFd(ends[1]);
    return 0;
}

int gpiod_line_set_value(gpiod_line* line, int value) {
    if (!line->answers()) {
        return -1;
    }
    line->state().facts.high = (value != 0) != line->state().active_low();
    return 0;
}

int gpiod_line_get_value(gpiod_line* line) {
    if (!line->answers()) {
        return -1;
    }
    return line->state().facts.high != line->state().active_low() ? 1 : 0;
}

int gpiod_line_event_get_fd(gpiod_line* line) {
    return line->state().events.get();
}
}
