#include "app/doctor/facts/kernel_files.h"

#include <algorithm>
#include <charconv>
#include <cstddef>
#include <fstream>
#include <sstream>
#include <system_error>

namespace tribus::doctor {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kLongestFile = 16384;
constexpr std::string_view kBlank{" \t\r\n\0", 5};

}  // namespace

bool KernelFiles::has(std::string_view path) const {
    std::error_code error;
    return fs::exists(at(path), error);
}

std::string KernelFiles::text(std::string_view path) const {
    std::ifstream file(at(path), std::ios::binary);
    std::string content(kLongestFile, '\0');
    file.read(content.data(), static_cast<std::streamsize>(content.size()));
    content.resize(static_cast<std::size_t>(std::max<std::streamsize>(file.gcount(), 0)));
    return content;
}

std::string KernelFiles::line(std::string_view path) const {
    const std::string content = text(path);
    const std::size_t first = content.find_first_not_of(kBlank);
    if (first == std::string::npos) {
        return {};
    }
    const std::size_t last = content.find_last_not_of(kBlank);
    std::string found = content.substr(first, last - first + 1);
    std::ranges::replace(found, '\0', ' ');
    return found;
}

std::optional<std::int64_t> KernelFiles::number(std::string_view path) const {
    const std::string word = line(path);
    const bool hexadecimal = word.starts_with("0x");
    const char* const begin = word.data() + (hexadecimal ? 2 : 0);
    const char* const end = word.data() + word.size();
    std::int64_t number = 0;
    const auto [stop, error] = std::from_chars(begin, end, number, hexadecimal ? 16 : 10);
    return error == std::errc{} && stop == end ? std::optional(number) : std::nullopt;
}

std::optional<std::string> KernelFiles::word_behind(std::string_view text, std::string_view name) {
    std::istringstream lines{std::string(text)};
    for (std::string line; std::getline(lines, line);) {
        if (line.starts_with(name)) {
            std::istringstream words(line.substr(name.size()));
            std::string word;
            words >> word;
            return word;
        }
    }
    return std::nullopt;
}

std::vector<std::string> KernelFiles::names_in(std::string_view folder) const {
    std::vector<std::string> names;
    std::error_code error;
    for (fs::directory_iterator entry(at(folder), error), end; !error && entry != end;
         entry.increment(error)) {
        names.push_back(entry->path().filename().string());
    }
    std::ranges::sort(names);
    return names;
}

std::optional<fs::path> KernelFiles::target(std::string_view path) const {
    std::error_code error;
    fs::path found = fs::canonical(at(path), error);
    return error ? std::nullopt : std::optional(std::move(found));
}

}  // namespace tribus::doctor
