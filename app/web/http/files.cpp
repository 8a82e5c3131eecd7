#include "app/web/http/files.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <fstream>
#include <sstream>
#include <system_error>
#include <tuple>
#include <utility>

#include <fmt/chrono.h>
#include <fmt/format.h>

#include "app/cli/replace_file.h"
#include "pipelines/realtime/clock.h"
#include "transports/links/unique_fd.h"

namespace tribus::web {
namespace {

namespace fs = std::filesystem;

constexpr std::array<std::pair<std::string_view, std::string_view>, 5> kTypes{
    {{".html", "text/html; charset=utf-8"},
     {".js", "text/javascript; charset=utf-8"},
     {".css", "text/css; charset=utf-8"},
     {".svg", "image/svg+xml"},
     {".woff2", "font/woff2"}}};

constexpr mode_t kUsualPermissions = 0644;

std::string content_of(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    std::ostringstream content;
    content << file.rdbuf();
    return std::move(content).str();
}

/// Empty for a kind of file that the page does not have.
std::string_view type_of(const fs::path& path) {
    const auto known = std::ranges::find(kTypes, path.extension().string(),
                                         [](const auto& type) { return type.first; });
    return known == kTypes.end() ? std::string_view() : known->second;
}

}  // namespace

PageFiles PageFiles::read(const fs::path& folder) {
    PageFiles files;
    std::error_code error;
    for (fs::recursive_directory_iterator at(folder, error), end; !error && at != end;
         at.increment(error)) {
        const std::string_view type = type_of(at->path());
        if (type.empty() || !at->is_regular_file(error)) {
            continue;
        }
        PageFile file{.type = type, .content = content_of(at->path()), .gzip = {}};
        file.gzip = content_of(at->path().string() + ".gz");
        const std::string name = "/" + at->path().lexically_relative(folder).generic_string();
        files.files_.emplace(name == "/index.html" ? "/" : name, std::move(file));
    }
    return files;
}

const PageFile* PageFiles::find(std::string_view path) const {
    const auto file = files_.find(path);
    return file == files_.end() ? nullptr : &file->second;
}

tl::expected<void, std::string> write_next_configuration(const fs::path& file,
                                                         std::string_view text,
                                                         const fs::path& history) {
    std::error_code error;
    fs::create_directories(history, error);
    const std::string before = content_of(file);
    const auto kept = kept_files(history);
    if (!before.empty() &&
        (kept.empty() || content_of(history / (kept.front().id + ".toml")) != before)) {
        const std::string id = fmt::format(
            "{:%Y-%m-%dT%H-%M-%SZ}.toml",
            fmt::gmtime(static_cast<std::time_t>(
                std::chrono::duration_cast<std::chrono::seconds>(wall_time_now()).count())));
        if (auto stored = replace_file(history / id, before, kUsualPermissions); !stored) {
            return stored;
        }
        const auto all = kept_files(history);
        for (std::size_t i = kMostKept; i < all.size(); ++i) {
            fs::remove(history / (all[i].id + ".toml"), error);
        }
    }
    return write_successor(linked_file(file), text, kUsualPermissions);
}

tl::expected<void, std::string> keep_configuration(const fs::path& file, std::string_view text,
                                                   const fs::path& history) {
    return write_next_configuration(file, text, history).and_then([&] {
        return put_successor_in_place(linked_file(file));
    });
}

std::vector<KeptFile> kept_files(const fs::path& history) {
    std::vector<KeptFile> files;
    std::error_code error;
    for (fs::directory_iterator at(history, error), end; !error && at != end; at.increment(error)) {
        if (at->path().extension() == ".toml" && at->is_regular_file(error)) {
            files.push_back({at->path().stem().string(), fs::file_size(at->path(), error)});
        }
    }
    std::ranges::sort(files, std::greater<>(), &KeptFile::id);
    return files;
}

}  // namespace tribus::web
