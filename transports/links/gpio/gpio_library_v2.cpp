#include <gpiod.h>
#include <linux/gpio.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <utility>

#include "transports/links/gpio/gpio_library.h"

namespace tribus {

namespace {

template <auto kFree>
struct Freer {
    template <class Object>
    void operator()(Object* object) const {
        kFree(object);
    }
};
using Chip = std::unique_ptr<gpiod_chip, Freer<gpiod_chip_close>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Freer<gpiod_chip_info_free>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Freer<gpiod_line_info_free>>;
using LineSettings = std::unique_ptr<gpiod_line_settings, Freer<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Freer<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Freer<gpiod_request_config_free>>;
using LineRequest = std::unique_ptr<gpiod_line_request, Freer<gpiod_line_request_release>>;

class HeldLine : public GpioHeldLine {
  public:
    HeldLine(LineRequest request, unsigned offset)
        : request_(std::move(request)), offset_(offset) {}

    bool set(bool active) override {
        const auto value = active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
        return gpiod_line_request_set_value(request_.get(), offset_, value) == 0;
    }
    std::optional<bool> get() const override {
        const auto value = gpiod_line_request_get_value(request_.get(), offset_);
        return value == GPIOD_LINE_VALUE_ERROR ? std::nullopt
                                               : std::optional(value == GPIOD_LINE_VALUE_ACTIVE);
    }
    int descriptor() const override { return gpiod_line_request_get_fd(request_.get()); }

    std::optional<std::size_t> read_edges(std::span<GpioEdge> edges) override {
        std::array<gpio_v2_line_event, kEdgesPerRead> events{};
        const ssize_t bytes = ::read(descriptor(), events.data(), sizeof events);
        if (bytes < 0) {
            return errno == EAGAIN || errno == EINTR ? std::optional<std::size_t>(0) : std::nullopt;
        }
        const std::size_t count = static_cast<std::size_t>(bytes) / sizeof events[0];
        for (std::size_t edge = 0; edge < count; ++edge) {
            edges[edge] = {events[edge].timestamp_ns, events[edge].line_seqno != next_number_};
            next_number_ = events[edge].line_seqno + 1;
        }
        return count;
    }

  private:
    LineRequest request_;
    unsigned offset_;
    std::uint32_t next_number_ = 1;  ///< of the line's next edge
};

gpiod_line_edge library_edges(GpioEdges edges) {
    switch (edges) {
        case GpioEdges::rising:
            return GPIOD_LINE_EDGE_RISING;
        case GpioEdges::falling:
            return GPIOD_LINE_EDGE_FALLING;
        case GpioEdges::both:
            break;
    }
    return GPIOD_LINE_EDGE_BOTH;
}

/// The kernel's queue where single edges count: more than two frames of PPM.
constexpr std::size_t kQueuedEdges = 64;

gpiod_line_bias library_bias(GpioBias bias) {
    switch (bias) {
        case GpioBias::pull_up:
            return GPIOD_LINE_BIAS_PULL_UP;
        case GpioBias::pull_down:
            return GPIOD_LINE_BIAS_PULL_DOWN;
        case GpioBias::none:
            return GPIOD_LINE_BIAS_DISABLED;
        case GpioBias::as_is:
            break;
    }
    return GPIOD_LINE_BIAS_AS_IS;
}

std::string text_or_nothing(const char* text) {
    return text == nullptr ? "" : text;
}

/// The setters only refuse values outside their enum, so their results are ignored.
void apply(const GpioRequest& request, gpiod_line_settings* settings) {
    gpiod_line_settings_set_active_low(settings, request.active_low);
    if (request.use == GpioUse::output) {
        gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_OUTPUT);
        gpiod_line_settings_set_output_value(settings, request.active_at_start
                                                           ? GPIOD_LINE_VALUE_ACTIVE
                                                           : GPIOD_LINE_VALUE_INACTIVE);
    } else {
        gpiod_line_settings_set_direction(settings, GPIOD_LINE_DIRECTION_INPUT);
        gpiod_line_settings_set_edge_detection(settings, library_edges(request.edges));
        gpiod_line_settings_set_bias(settings, library_bias(request.bias));
    }
}

}  // namespace

tl::expected<std::vector<GpioLineFacts>, int> read_gpio_lines(const std::string& chip_path) {
    const Chip chip(gpiod_chip_open(chip_path.c_str()));
    if (!chip) {
        return tl::unexpected(errno);
    }
    const ChipInfo info(gpiod_chip_get_info(chip.get()));
    if (!info) {
        return tl::unexpected(errno);
    }
    std::vector<GpioLineFacts> lines;
    const std::size_t count = gpiod_chip_info_get_num_lines(info.get());
    for (unsigned offset = 0; offset < count; ++offset) {
        const LineInfo line(gpiod_chip_get_line_info(chip.get(), offset));
        if (!line) {
            return tl::unexpected(errno);
        }
        lines.push_back({text_or_nothing(gpiod_line_info_get_name(line.get())),
                         gpiod_line_info_is_used(line.get()),
                         text_or_nothing(gpiod_line_info_get_consumer(line.get()))});
    }
    return lines;
}

tl::expected<std::unique_ptr<GpioHeldLine>, int> request_gpio_line(const std::string& chip_path,
                                                                   const GpioRequest& request) {
    const Chip chip(gpiod_chip_open(chip_path.c_str()));
    if (!chip) {
        return tl::unexpected(errno);
    }
    const LineSettings settings(gpiod_line_settings_new());
    const LineConfig lines(gpiod_line_config_new());
    const RequestConfig config(gpiod_request_config_new());
    if (!settings || !lines || !config) {
        return tl::unexpected(errno);
    }
    apply(request, settings.get());
    gpiod_request_config_set_consumer(config.get(), kGpioConsumer);
    if (request.edges != GpioEdges::both) {
        gpiod_request_config_set_event_buffer_size(config.get(), kQueuedEdges);
    }
    if (gpiod_line_config_add_line_settings(lines.get(), &request.offset, 1, settings.get()) != 0) {
        return tl::unexpected(errno);
    }
    LineRequest held(gpiod_chip_request_lines(chip.get(), config.get(), lines.get()));
    if (!held) {
        return tl::unexpected(errno);
    }
    return std::make_unique<HeldLine>(std::move(held), request.offset);
}

}  // namespace tribus
