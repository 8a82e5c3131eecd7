#include <gpiod.h>
#include <linux/gpio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <utility>

#include "transports/links/gpio/gpio_library.h"

namespace tribus {

namespace {

struct ChipCloser {
    void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using Chip = std::unique_ptr<gpiod_chip, ChipCloser>;

class HeldLine : public GpioHeldLine {
  public:
    HeldLine(Chip chip, gpiod_line* line) : chip_(std::move(chip)), line_(line) {}

    bool set(bool active) override {
        return gpiod_line_set_value(line_, static_cast<int>(active)) == 0;
    }
    std::optional<bool> get() const override {
        const int value = gpiod_line_get_value(line_);
        return value < 0 ? std::nullopt : std::optional(value != 0);
    }
    int descriptor() const override { return gpiod_line_event_get_fd(line_); }

    std::optional<std::size_t> read_edges(std::span<GpioEdge> edges) override {
        std::array<gpioevent_data, kEdgesPerRead> events{};
        const ssize_t bytes = ::read(descriptor(), events.data(), sizeof events);
        if (bytes < 0) {
            return errno == EAGAIN || errno == EINTR ? std::optional<std::size_t>(0) : std::nullopt;
        }
        const std::size_t count = static_cast<std::size_t>(bytes) / sizeof events[0];
        for (std::size_t edge = 0; edge < count; ++edge) {
            edges[edge] = {events[edge].timestamp, was_full_ && edge == 0};
        }
        // This version of the interface has no numbers: from a full queue an edge may be missing.
        was_full_ = count == events.size();
        return count;
    }

  private:
    Chip chip_;         ///< releases its lines when it is closed
    gpiod_line* line_;  ///< owned by the chip
    bool was_full_ = false;
};

int event_type(GpioEdges edges) {
    switch (edges) {
        case GpioEdges::rising:
            return GPIOD_LINE_REQUEST_EVENT_RISING_EDGE;
        case GpioEdges::falling:
            return GPIOD_LINE_REQUEST_EVENT_FALLING_EDGE;
        case GpioEdges::both:
            break;
    }
    return GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES;
}

int bias_flag(GpioBias bias) {
    switch (bias) {
        case GpioBias::pull_up:
            return GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
        case GpioBias::pull_down:
            return GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
        case GpioBias::none:
            return GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
        case GpioBias::as_is:
            break;
    }
    return 0;
}

std::string text_or_nothing(const char* text) {
    return text == nullptr ? "" : text;
}

}  // namespace

tl::expected<std::vector<GpioLineFacts>, int> read_gpio_lines(const std::string& chip_path) {
    const Chip chip(gpiod_chip_open(chip_path.c_str()));
    if (!chip) {
        return tl::unexpected(errno);
    }
    std::vector<GpioLineFacts> lines;
    for (unsigned offset = 0; offset < gpiod_chip_num_lines(chip.get()); ++offset) {
        gpiod_line* line = gpiod_chip_get_line(chip.get(), offset);
        if (line == nullptr) {
            return tl::unexpected(errno);
        }
        lines.push_back({text_or_nothing(gpiod_line_name(line)), gpiod_line_is_used(line),
                         text_or_nothing(gpiod_line_consumer(line))});
    }
    return lines;
}

tl::expected<std::unique_ptr<GpioHeldLine>, int> request_gpio_line(const std::string& chip_path,
                                                                   const GpioRequest& request) {
    Chip chip(gpiod_chip_open(chip_path.c_str()));
    if (!chip) {
        return tl::unexpected(errno);
    }
    gpiod_line* line = gpiod_chip_get_line(chip.get(), request.offset);
    if (line == nullptr) {
        return tl::unexpected(errno);
    }
    gpiod_line_request_config config{};
    config.consumer = kGpioConsumer;
    config.request_type = request.use == GpioUse::output ? GPIOD_LINE_REQUEST_DIRECTION_OUTPUT
                                                         : event_type(request.edges);
    config.flags = request.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
    if (request.use == GpioUse::input) {
        config.flags |= bias_flag(request.bias);
    }
    if (gpiod_line_request(line, &config, static_cast<int>(request.active_at_start)) != 0) {
        return tl::unexpected(errno);
    }
    return std::make_unique<HeldLine>(std::move(chip), line);
}

}  // namespace tribus
