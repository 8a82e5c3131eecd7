#include "app/web/server/daemons.h"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/cli/object_text.h"
#include "app/client/control_socket.h"

namespace tribus::web {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kMostConfigurations = 64;
constexpr std::size_t kLongestAnswer = std::size_t{8} << 20U;
constexpr Duration kLookPeriod = std::chrono::milliseconds(250);

bool is_configuration(const fs::directory_entry& entry) {
    std::error_code error;
    return entry.path().extension() == ".toml" && entry.is_regular_file(error) &&
           !entry.path().filename().string().starts_with('.');
}

}  // namespace

std::vector<KnownDaemon> known_daemons(const fs::path& folder) {
    std::map<std::string, KnownDaemon> known;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end;
         !error && at != end && known.size() < kMostConfigurations; at.increment(error)) {
        if (is_configuration(*at)) {
            const std::string name = at->path().stem().string();
            known[name] = {.name = name, .socket = {}, .file = at->path()};
        }
    }
    for (const FoundSocket& found : find_sockets(SocketDirectories::of_this_process())) {
        KnownDaemon& one = known[found.name];
        one.name = found.name;
        one.socket = found.path;
    }
    std::vector<KnownDaemon> daemons;
    daemons.reserve(known.size());
    for (auto& [name, one] : known) {
        daemons.push_back(std::move(one));
    }
    return daemons;
}

std::optional<KnownDaemon> find_known(const fs::path& folder, std::string_view name) {
    auto all = known_daemons(folder);
    const auto found = std::ranges::find(all, name, &KnownDaemon::name);
    return found == all.end() ? std::nullopt : std::optional(std::move(*found));
}

DaemonRequest::DaemonRequest(const std::string& socket, std::string_view line, Instant end)
    : end_(end) {
    auto connected = connect_local(socket);
    if (!connected) {
        failed_ = fmt::format("no daemon answers: {}", std::strerror(connected.error()));
        return;
    }
    socket_ = std::move(*connected);
    const std::string text = std::string(line) + "\n";
    if (::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT) !=
        static_cast<ssize_t>(text.size())) {
        failed_ = "the daemon takes no request";
    }
}

std::optional<std::string> DaemonRequest::poll(Instant now) {
    constexpr std::size_t kBytesAtOnce = 16384;
    std::array<char, kBytesAtOnce> bytes;
    while (failed_.empty()) {
        const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
        if (count > 0) {
            received_.append(bytes.data(), static_cast<std::size_t>(count));
            if (received_.size() > kLongestAnswer) {
                failed_ = "what answers is no tribus";
            }
            continue;
        }
        if (count == 0 || (errno != EAGAIN && errno != EINTR)) {
            failed_ = "the daemon ended before it answered";
        }
        break;
    }
    if (const auto line_end = received_.find('\n'); line_end != std::string::npos) {
        return received_.substr(0, line_end);
    }
    if (failed_.empty() && now >= end_) {
        failed_ = "the daemon does not answer";
    }
    return failed_.empty() ? std::nullopt : std::optional(error_object(failed_));
}

DaemonWatch::DaemonWatch(const std::string& socket) : link_(socket, kPeriod) {}

void DaemonWatch::look(Instant now) {
    link_.reconnect(now);
    auto lines = link_.read();
    if (!lines.empty()) {
        newest_ = std::move(lines.back());
        ++number_;
        received_ = now;
    }
    due_ = later(now, kLookPeriod);
}

std::string DaemonWatch::problem(Instant now) const {
    if (!link_.connected()) {
        return link_.problem();
    }
    return now - received_ >= kHangs ? "the daemon does not answer" : "";
}

}  // namespace tribus::web
