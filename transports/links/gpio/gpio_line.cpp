#include "transports/links/gpio/gpio_line.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstring>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "transports/links/gpio/gpio_library.h"
#include "transports/links/gpio/gpio_search.h"

namespace tribus {

namespace {

namespace fs = std::filesystem;

/// Paths of all GPIO chips, in the order of their numbers; or a value of errno.
tl::expected<std::vector<std::string>, int> gpio_chip_paths() {
    std::vector<std::string> paths;
    std::error_code error;
    for (fs::directory_iterator entry("/dev", error); !error && entry != fs::directory_iterator();
         entry.increment(error)) {
        std::error_code unknown;
        // Some systems have a symbolic link with a chip's former name. It is not another chip.
        if (entry->path().filename().string().starts_with("gpiochip") &&
            entry->symlink_status(unknown).type() == fs::file_type::character) {
            paths.push_back(entry->path().string());
        }
    }
    if (error) {
        return tl::unexpected(error.value());
    }
    std::ranges::sort(paths, {}, [](const std::string& path) {
        return std::pair(path.size(), std::string_view(path));
    });
    return paths;
}

/// Requests the line. `request` needs no offset.
tl::expected<std::unique_ptr<GpioHeldLine>, std::string> hold(const GpioPlace& place,
                                                              GpioRequest request) {
    const auto failed = [&place](const std::string& why) {
        return tl::unexpected(to_text(place) + ": " + why);
    };
    const auto chips = find_gpio_chips();
    if (!chips) {
        return failed(std::string("/dev: ") + std::strerror(chips.error()));
    }
    const auto found = find_gpio_line(place, followed_chip_path(place), *chips);
    if (!found) {
        return failed(found.error());
    }
    request.offset = found->offset;
    auto line = request_gpio_line(found->chip.path, request);
    if (!line) {
        const GpioLineFacts& facts = found->chip.lines[found->offset];
        return failed(gpio_refusal(line.error(), facts, request.use, request.bias));
    }
    return std::move(*line);
}

/// The library leaves it blocking: a read without an edge would wait for one.
void make_nonblocking(int descriptor) {
    ::fcntl(descriptor, F_SETFL, O_NONBLOCK);
}

}  // namespace

tl::expected<std::vector<GpioChip>, int> find_gpio_chips() {
    const auto paths = gpio_chip_paths();
    if (!paths) {
        return tl::unexpected(paths.error());
    }
    std::vector<GpioChip> chips;
    for (const std::string& path : *paths) {
        GpioChip chip{path, 0, {}};
        if (auto lines = read_gpio_lines(path)) {
            chip.lines = std::move(*lines);
        } else {
            chip.error = lines.error();
        }
        chips.push_back(std::move(chip));
    }
    return chips;
}

std::string followed_chip_path(const GpioPlace& place) {
    if (place.chip.empty()) {
        return "";
    }
    std::error_code error;
    const fs::path path = fs::canonical(chip_path(place), error);
    return error ? chip_path(place) : path.string();
}

bool is_gpio_line_absent(const GpioPlace& place) {
    const auto chips = find_gpio_chips();
    if (!chips) {
        return false;
    }
    const std::string path = followed_chip_path(place);
    if (!path.empty()) {
        return std::ranges::count(*chips, path, &GpioChip::path) == 0;
    }
    return std::ranges::all_of(*chips, [](const GpioChip& chip) { return chip.error == 0; }) &&
           !find_gpio_line(place, path, *chips);
}

tl::expected<std::unique_ptr<GpioHeldLine>, std::string> hold_for_edges(const GpioPlace& place,
                                                                        GpioEdges edges,
                                                                        GpioBias bias) {
    auto line = hold(place, {.use = GpioUse::input, .bias = bias, .edges = edges});
    if (line) {
        make_nonblocking((*line)->descriptor());
    }
    return line;
}

GpioOutput::GpioOutput(std::unique_ptr<GpioHeldLine> line) : line_(std::move(line)) {}
GpioOutput::~GpioOutput() = default;

tl::expected<std::unique_ptr<GpioOutput>, std::string> GpioOutput::open(const GpioPlace& place,
                                                                        bool active_low,
                                                                        bool active_at_start) {
    auto line = hold(
        place,
        {.use = GpioUse::output, .active_low = active_low, .active_at_start = active_at_start});
    if (!line) {
        return tl::unexpected(line.error());
    }
    return std::unique_ptr<GpioOutput>(new GpioOutput(std::move(*line)));
}

bool GpioOutput::set(bool active) {
    return line_->set(active);
}

GpioInput::GpioInput(std::unique_ptr<GpioHeldLine> line) : line_(std::move(line)) {}
GpioInput::~GpioInput() = default;

tl::expected<std::unique_ptr<GpioInput>, std::string> GpioInput::open(const GpioPlace& place,
                                                                      bool active_low,
                                                                      GpioBias bias) {
    auto line = hold(place, {.use = GpioUse::input, .active_low = active_low, .bias = bias});
    if (!line) {
        return tl::unexpected(line.error());
    }
    std::unique_ptr<GpioInput> input(new GpioInput(std::move(*line)));
    make_nonblocking(input->descriptor());
    return input;
}

int GpioInput::descriptor() const {
    return line_->descriptor();
}

std::optional<bool> GpioInput::read() {
    // Reads edges before the level: an edge in between is then still there for the next wake-up.
    // The kernel keeps as many for a line as one read takes.
    std::array<GpioEdge, kEdgesPerRead> edges{};
    const auto count = line_->read_edges(edges);
    latest_edge_.reset();
    if (!count) {
        return std::nullopt;
    }
    if (*count == edges.size()) {
        latest_edge_ = Duration::max();
    } else if (*count > 0) {
        latest_edge_ = Duration(static_cast<Duration::rep>(edges[*count - 1].nanoseconds));
    }
    return line_->get();
}

}  // namespace tribus
