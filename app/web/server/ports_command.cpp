#include "app/web/server/ports_command.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <memory>
#include <system_error>

#include <fmt/format.h>

#include "app/cli/exit_status.h"
#include "app/cli/object_text.h"
#include "app/cli/plain_name.h"
#include "app/web/answers/answers.h"
#include "core/utf8.h"

namespace tribus::web {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestRequest = 4096;
constexpr std::int64_t kMostListeningSeconds = 30;

/// A file below /dev, or the name of a CAN interface.
bool is_device_or_interface(std::string_view device) {
    constexpr std::string_view kDevices = "/dev/";
    if (!device.starts_with(kDevices)) {
        return is_plain_name(device);
    }
    device.remove_prefix(kDevices.size());
    while (!device.empty()) {
        const std::size_t end = device.find('/');
        if (!is_plain_name(device.substr(0, end))) {
            return false;
        }
        device.remove_prefix(end == std::string_view::npos ? device.size() : end + 1);
    }
    return true;
}

/// A file in the folder of configurations. The colon ends its name in what `learn` takes.
bool is_configuration_name(std::string_view name) {
    constexpr std::size_t kLongest = 250;
    return !name.empty() && name.size() <= kLongest && name.front() != '.' && name.front() != '-' &&
           is_utf8(name) && std::ranges::none_of(name, [](unsigned char c) {
               return c == '/' || c == ':' || c < ' ' || c == 0x7F;
           });
}

/// Byte by byte: what follows the line is for the program.
std::string read_request() {
    std::string line;
    char byte = 0;
    while (line.size() < kLongestRequest && ::read(STDIN_FILENO, &byte, 1) == 1 && byte != '\n') {
        line.push_back(byte);
    }
    return line;
}

int refuse(std::string_view why) {
    fmt::print("{}\n", error_object(why));
    return kExitWrongUse;
}

int become(const std::string& configurations) {
    const std::string request = read_request();
    const auto program = program_for(request, configurations);
    if (!program) {
        return refuse(
            "the helper for ports opens a device below /dev or a CAN interface (doctor), and the "
            "port of an input (learn), nothing else");
    }
    std::error_code error;
    const fs::path self = fs::read_symlink("/proc/self/exe", error);
    std::vector<std::string> words{self.parent_path() / "tribus"};
    words.insert(words.end(), program->begin(), program->end());
    std::vector<char*> arguments;
    arguments.reserve(words.size() + 1);
    for (std::string& word : words) {
        arguments.push_back(word.data());
    }
    arguments.push_back(nullptr);
    ::execv(arguments.front(), arguments.data());
    return refuse(fmt::format("{}: {}", words.front(), std::strerror(errno)));
}

}  // namespace

std::optional<std::vector<std::string>> program_for(std::string_view request,
                                                    const fs::path& configurations) {
    const std::string text(request);
    const auto verb = text_in(text, "verb");
    if (verb == "doctor") {
        const auto device = text_in(text, "device");
        const std::int64_t seconds = std::clamp<std::int64_t>(
            number_in(text, "seconds").value_or(3), 1, kMostListeningSeconds);
        std::vector<std::string> words{"doctor", "--format", "json", "--for",
                                       fmt::format("{}s", seconds)};
        if (device && !is_device_or_interface(*device)) {
            return std::nullopt;
        }
        if (device) {
            words.push_back(*device);
        }
        return words;
    }
    const auto daemon = text_in(text, "daemon");
    const auto input = text_in(text, "input");
    if (verb == "learn" && daemon && input && is_configuration_name(*daemon) &&
        is_plain_name(*input)) {
        return std::vector<std::string>{
            "learn", "--format", "json",
            fmt::format("{}:{}", (configurations / (*daemon + ".toml")).string(), *input)};
    }
    return std::nullopt;
}

Command ports_command() {
    auto configurations = std::make_shared<std::string>("/etc/tribus");
    return {
        .name = "ports",
        .help = "Do what the page asks of ports, for the connection on standard input",
        .notes = "tribus-ports.socket starts it for each request.",
        .options = {{.name = "--configurations",
                     .value = configurations.get(),
                     .help = "Folder of the configurations",
                     .shows_value = true,
                     .value_name = "FOLDER"}},
        .examples = {{"echo '{}' | tribus-web ports",
                      "what the page asks is one line of JSON; a wrong one gets an error as JSON"}},
        .run = [configurations] { return become(*configurations); },
    };
}

}  // namespace tribus::web
