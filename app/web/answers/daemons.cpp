#include "app/web/answers/daemons.h"

#include <algorithm>
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
            known[name] = {.name = name, .tells = {}, .control = {}, .file = at->path()};
        }
    }
    const SocketDirectories directories = SocketDirectories::of_this_process();
    for (const FoundSocket& found : find_telling_sockets(directories)) {
        KnownDaemon& one = known[found.name];
        one.name = found.name;
        one.tells = found.path;
    }
    for (const FoundSocket& found : find_sockets(directories)) {
        if (const auto one = known.find(found.name); one != known.end()) {
            one->second.control = found.path;
        }
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

LineTalk daemon_at(const std::string& socket) {
    return {"the daemon", connect_local(socket).map_error([](int error) {
                return fmt::format("no daemon answers: {}", std::strerror(error));
            })};
}

LineRequest::LineRequest(LineTalk talk, std::string_view line, Instant end)
    : talk_(std::move(talk)), end_(end) {
    talk_.say(line);
}

std::optional<std::string> LineRequest::poll(Instant now) {
    auto line = talk_.hear();
    if (line || (talk_.failed().empty() && now < end_)) {
        return line;
    }
    const std::string why =
        talk_.failed().empty() ? talk_.who() + " does not answer" : talk_.failed();
    return json_text({{"type", "error"}, {"error", why}, {"unanswered", true}});
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
