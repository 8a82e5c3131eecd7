#include "transports/links/evdev/evdev_devices.h"

#include <linux/input-event-codes.h>

#include <algorithm>
#include <climits>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string_view>
#include <system_error>
#include <utility>

namespace tribus {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view kEventPrefix = "event";

std::string line_of(const fs::path& path) {
    std::ifstream file(path);
    std::string line;
    std::getline(file, line);
    return line;
}

/// The kernel writes a set as words of `unsigned long`, the highest first, zeros before it left
/// out.
std::vector<std::uint16_t> codes_of(const fs::path& path, std::size_t from, std::size_t end) {
    constexpr std::size_t kBits = CHAR_BIT * sizeof(unsigned long);
    std::istringstream text(line_of(path));
    std::vector<unsigned long> words;
    for (std::string word; text >> word;) {
        words.insert(words.begin(), std::strtoul(word.c_str(), nullptr, 16));
    }
    std::vector<std::uint16_t> codes;
    for (std::size_t code = from; code < std::min(end, words.size() * kBits); ++code) {
        if ((words[code / kBits] >> code % kBits & 1U) != 0) {
            codes.push_back(static_cast<std::uint16_t>(code));
        }
    }
    return codes;
}

/// The link in a folder that leads to the event device; empty if there is none. Other links lead to
/// jsN, the same device for old programs.
std::string link_to(const std::string& event, const std::string& folder, const fs::path& root) {
    std::vector<std::string> names;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(root / folder, error)) {
        std::error_code none;
        if (fs::read_symlink(entry.path(), none).filename() == event) {
            names.push_back(entry.path().filename().string());
        }
    }
    std::ranges::sort(names);
    return names.empty() ? std::string() : "/" + folder + "/" + names.front();
}

EvdevDeviceFacts facts_of_event(const std::string& event, const fs::path& root) {
    EvdevDeviceFacts facts{.event = event, .node = "/dev/input/" + event};
    const fs::path folder = root / "sys/class/input" / event / "device";
    facts.name = line_of(folder / "name");
    facts.unique = line_of(folder / "uniq");
    facts.axes = codes_of(folder / "capabilities/abs", 0, ABS_CNT);
    facts.buttons = codes_of(folder / "capabilities/key", BTN_MISC, KEY_CNT);
    for (const char* names : {"dev/input/by-id", "dev/input/by-path"}) {
        if (facts.device.empty()) {
            facts.device = link_to(event, names, root);
        }
    }
    facts.device = facts.device.empty() ? facts.node : facts.device;
    return facts;
}

bool is_event(std::string_view name) {
    return name.starts_with(kEventPrefix) && name.size() > kEventPrefix.size() &&
           name.find_first_not_of("0123456789", kEventPrefix.size()) == std::string_view::npos;
}

}  // namespace

bool EvdevDeviceFacts::is_gamepad() const {
    const auto any_from = [this](int first, int last) {
        return std::ranges::any_of(
            buttons, [=](std::uint16_t code) { return code >= first && code <= last; });
    };
    const bool has_stick = std::ranges::any_of(
        axes, [](std::uint16_t code) { return code <= ABS_BRAKE || code == ABS_HAT0X; });
    const bool has_pad_buttons =
        any_from(BTN_JOYSTICK, BTN_THUMBR) || any_from(BTN_TRIGGER_HAPPY, BTN_TRIGGER_HAPPY40);
    return has_stick && has_pad_buttons && !any_from(BTN_DIGI, BTN_TOOL_QUADTAP);
}

std::vector<EvdevDeviceFacts> find_evdev_devices(const fs::path& root) {
    std::vector<EvdevDeviceFacts> found;
    std::error_code error;
    for (const auto& entry : fs::directory_iterator(root / "sys/class/input", error)) {
        const std::string name = entry.path().filename();
        if (is_event(name)) {
            found.push_back(facts_of_event(name, root));
        }
    }
    // In the order of their numbers, which begin with no zero.
    std::ranges::sort(found, {}, [](const EvdevDeviceFacts& facts) {
        return std::pair(facts.event.size(), facts.event);
    });
    return found;
}

EvdevDeviceFacts look_at_evdev_device(const std::string& path, const fs::path& root) {
    std::error_code error;
    const fs::path node = fs::canonical(root / fs::path(path).relative_path(), error);
    const std::string event = node.filename();
    if (!is_event(event) || !fs::exists(root / "sys/class/input" / event, error)) {
        return {.event = {}, .node = path, .device = path};
    }
    EvdevDeviceFacts facts = facts_of_event(event, root);
    // A name that a person made by a rule of udev is as good as one below by-id.
    facts.device = fs::path(path).filename() == event ? facts.device : path;
    return facts;
}

}  // namespace tribus
