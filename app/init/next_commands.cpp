#include "app/init/next_commands.h"

#include <algorithm>
#include <filesystem>

#include <fmt/format.h>

namespace tribus::init {
namespace {

constexpr std::string_view kServiceFolder = "/etc/tribus";

bool is_letter_or_digit(char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
}

/// Instance name of a unit: systemd.unit(5) allows these characters without escapes.
bool is_instance_name(std::string_view text) {
    return !text.empty() && std::ranges::all_of(text, [](char c) {
        return is_letter_or_digit(c) || std::string_view(":-_.").find(c) != std::string_view::npos;
    });
}

}  // namespace

std::string shell_word(std::string_view text) {
    const bool plain = !text.empty() && std::ranges::all_of(text, [](char c) {
        return is_letter_or_digit(c) ||
               std::string_view("/._-+:,@%=").find(c) != std::string_view::npos;
    });
    if (plain) {
        return std::string(text);
    }
    std::string word = "'";
    for (const char c : text) {
        word += c == '\'' ? std::string("'\\''") : std::string(1, c);
    }
    return word + "'";
}

std::string printable_or(std::string_view text, std::string_view fallback) {
    const bool printable = std::ranges::all_of(text, [](char c) { return c >= ' ' && c <= '~'; });
    return std::string(printable ? text : fallback);
}

std::string name_in_comments(std::string_view file) {
    return file.empty() || file == "-" ? "FILE" : shell_word(printable_or(file, "FILE"));
}

std::vector<std::string> next_commands(std::string_view file, std::string_view input) {
    const std::string word = shell_word(file);
    return {fmt::format("tribus check {}", word), fmt::format("tribus learn {}:{}", word, input),
            fmt::format("tribus run {}", word)};
}

std::vector<std::string> service_commands(std::string_view file) {
    const std::filesystem::path path(file);
    const std::string stem = path.stem().string();
    const bool right_name = path.extension() == ".toml" && is_instance_name(stem);
    const std::string name = is_instance_name(stem) ? stem : "rc";
    const std::string start = fmt::format("sudo systemctl enable --now tribus@{}", name);
    if (right_name && path.parent_path() == kServiceFolder) {
        return {start};
    }
    const std::string target = right_name ? fmt::format("{}/", kServiceFolder)
                                          : fmt::format("{}/{}.toml", kServiceFolder, name);
    return {fmt::format("sudo cp {} {} && {}", shell_word(file), target, start)};
}

}  // namespace tribus::init
