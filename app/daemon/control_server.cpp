#include "app/daemon/control_server.h"

#include <set>
#include <sstream>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/cli/object_text.h"
#include "core/quantity.h"
#include "core/quotes.h"

namespace tribus {
namespace {

/// The data thread publishes ten times a second.
constexpr Duration kLeastPeriod = std::chrono::milliseconds(50);
constexpr Duration kMostPeriod = std::chrono::minutes(1);
constexpr Duration kDefaultPeriod = std::chrono::milliseconds(200);
/// Upper limit, in bytes, of how much of an invalid request is shown.
constexpr std::size_t kShown = 40;

std::vector<std::string> words_of(const std::string& line) {
    std::istringstream stream(line);
    std::vector<std::string> words;
    for (std::string word; stream >> word;) {
        words.push_back(word);
    }
    return words;
}

}  // namespace

tl::expected<std::unique_ptr<ControlServer>, std::string> ControlServer::open(
    const std::string& path) {
    auto listener = LocalListener::open(path);
    if (!listener) {
        return tl::unexpected(listener.error());
    }
    std::unique_ptr<ControlServer> control(new ControlServer(std::move(*listener)));
    const SocketLimits limits{.refusal = error_object("too many clients; try again later") + "\n"};
    const auto repeat = [self = control.get()](SocketClient& client, Instant now) {
        return client.send(self->commands_["status"]({}) + "\n", now);
    };
    const auto request = [self = control.get()](SocketClient& client, Instant now) {
        return self->answer(client, now);
    };
    auto server = SocketServer::make(std::move(control->listener_.descriptor()), limits,
                                     {.request = request, .repeat = repeat});
    if (!server) {
        return tl::unexpected(server.error());
    }
    control->server_.emplace(std::move(*server));
    return control;
}

void ControlServer::add(std::string name, Command command) {
    commands_.insert_or_assign(std::move(name), std::move(command));
}

void ControlServer::add_late(std::string name, LateCommand command) {
    late_commands_.insert_or_assign(std::move(name), std::move(command));
}

bool ControlServer::answer(SocketClient& client, Instant now) {
    // One request at a time: the next one waits until this answer is sent.
    while (client.ready()) {
        if (client.waits()) {
            const auto late = client.take_answer();
            if (!late) {
                return true;
            }
            if (!client.send(*late + "\n", now)) {
                return false;
            }
            continue;
        }
        const auto line = client.take_line();
        if (!line) {
            break;
        }
        const std::string text = answer_line(client, *line, now);
        if (!text.empty() && !client.send(text + "\n", now)) {
            return false;
        }
    }
    if (client.ready() && client.request_too_long()) {
        client.close_when_sent_and_discard();
        return client.send(error_object("a request must have at most 255 bytes") + "\n", now);
    }
    return true;
}

std::string ControlServer::answer_line(SocketClient& client, const std::string& line, Instant now) {
    const std::vector<std::string> words = words_of(line);
    if (words.empty()) {
        return "";
    }
    if (words.front() == "watch") {
        return watch(client, std::span(words).subspan(1), now);
    }
    if (const auto late = late_commands_.find(words.front()); late != late_commands_.end()) {
        client.wait_for(late->second(std::span(words).subspan(1)));
        return "";
    }
    const auto command = commands_.find(words.front());
    if (command == commands_.end()) {
        return error_object(why_not(words.front()));
    }
    return command->second(std::span(words).subspan(1));
}

std::string ControlServer::why_not(const std::string& request) const {
    const std::string shown = in_quotes(request, kShown);
    return control_.empty()
               ? fmt::format("{} is not a request; allowed: {}", shown, allowed())
               : fmt::format(
                     "{} is refused: this socket only tells, and what changes something goes "
                     "to {}; allowed here: {}",
                     shown, control_, allowed());
}

std::string ControlServer::allowed() const {
    std::set<std::string> names;
    for (const auto& [name, ignored] : commands_) {
        names.insert(name);
    }
    for (const auto& [name, ignored] : late_commands_) {
        names.insert(name);
    }
    std::string allowed = "\"watch [PERIOD]\"";
    for (const std::string& name : names) {
        allowed += ", " + in_quotes(name);
    }
    return allowed;
}

std::string ControlServer::watch(SocketClient& client, std::span<const std::string> words,
                                 Instant now) {
    const auto period = words.empty() ? kDefaultPeriod : parse_duration(words.front());
    if (words.size() > 1 || !period || *period < kLeastPeriod || *period > kMostPeriod) {
        return error_object("\"watch\" takes a period from \"50ms\" to \"60s\", or none");
    }
    client.repeat(*period, later(now, *period));
    return commands_["status"]({});
}

}  // namespace tribus
