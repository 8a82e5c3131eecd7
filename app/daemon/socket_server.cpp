#include "app/daemon/socket_server.h"

#include <poll.h>
#include <sys/epoll.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <string_view>
#include <utility>

#include "app/client/peer_name.h"

namespace tribus {
namespace {

/// Used when this process has no file descriptor left: trying again at once would take a whole
/// processor.
constexpr Duration kAcceptPause = std::chrono::seconds(1);

bool hung_up(int descriptor) {
    pollfd state{.fd = descriptor, .events = 0, .revents = 0};
    return ::poll(&state, 1, 0) != 0;
}

}  // namespace

tl::expected<SocketServer, std::string> SocketServer::make(UniqueFd listener, SocketLimits limits,
                                                           Answers answers) {
    UniqueFd epoll(::epoll_create1(EPOLL_CLOEXEC));
    epoll_event event{};
    event.events = EPOLLIN;
    if (!epoll.valid() || ::epoll_ctl(epoll.get(), EPOLL_CTL_ADD, listener.get(), &event) != 0) {
        return tl::unexpected(std::string("epoll: ") + std::strerror(errno));
    }
    return SocketServer(std::move(listener), std::move(epoll), std::move(limits),
                        std::move(answers));
}

Instant SocketServer::due() const {
    Instant due = accepting_ ? kNever : accept_again_;
    for (const SocketClient& client : clients_) {
        due = std::min({due, client.due(), patience_end(client)});
    }
    return due;
}

void SocketServer::watch(const SocketClient& client) {
    epoll_event event{};
    const bool wants_more =
        client.ready() && !client.ended() && (client.discards() || !client.request_too_long());
    event.events = (wants_more ? EPOLLIN : 0U) | (client.ready() ? 0U : EPOLLOUT);
    if (::epoll_ctl(epoll_.get(), EPOLL_CTL_MOD, client.descriptor(), &event) != 0) {
        ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, client.descriptor(), &event);
    }
}

void SocketServer::refuse(UniqueFd client) const {
    if (!limits_.refusal.empty()) {
        ::send(client.get(), limits_.refusal.data(), limits_.refusal.size(),
               MSG_DONTWAIT | MSG_NOSIGNAL);
    }
}

void SocketServer::accept_all(Instant now) {
    // The limit keeps a storm of connections from blocking the main thread.
    for (std::size_t i = 0; i < limits_.clients; ++i) {
        UniqueFd client(::accept4(listener_.get(), nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK));
        if (!client.valid()) {
            const bool out_of_something =
                errno != EAGAIN && errno != EINTR && errno != ECONNABORTED;
            if (out_of_something) {
                accepting_ = false;
                accept_again_ = later(now, kAcceptPause);
                ::epoll_ctl(epoll_.get(), EPOLL_CTL_DEL, listener_.get(), nullptr);
            }
            return;
        }
        std::string who = peer_name(client.get());
        if (clients_.size() >= limits_.clients && !make_room_for(who)) {
            refuse(std::move(client));
            continue;
        }
        watch(clients_.emplace_back(std::move(client), limits_.request, now, std::move(who)));
    }
}

/// A client that watches gives way only to somebody who has fewer places.
bool SocketServer::make_room_for(const std::string& who) {
    std::map<std::string_view, std::size_t> places;
    for (const SocketClient& client : clients_) {
        ++places[client.who()];
    }
    const auto greediest =
        std::ranges::max_element(places, {}, [](const auto& one) { return one.second; });
    const bool has_more = greediest->second > places[who] + 1;
    auto victim = clients_.end();
    for (auto client = clients_.begin(); client != clients_.end(); ++client) {
        const bool idle = client->ready() && !client->waits() && !client->repeats();
        const bool may_go = client->who() == greediest->first && (idle || has_more);
        if (may_go &&
            (victim == clients_.end() || std::pair(client->repeats(), client->quiet_since()) <
                                             std::pair(victim->repeats(), victim->quiet_since()))) {
            victim = client;
        }
    }
    if (victim == clients_.end()) {
        return false;
    }
    clients_.erase(victim);
    ++dropped_;
    return true;
}

/// A client that waits for its answer is not idle: the answer has a limit of its own.
Instant SocketServer::patience_end(const SocketClient& client) const {
    if (client.waits()) {
        return kNever;
    }
    if (client.discard_end() != kNever) {
        return client.discard_end();
    }
    if (!client.ready() || client.repeats()) {
        return later(client.quiet_since(), limits_.unread);
    }
    const Instant idle_end = later(client.quiet_since(), limits_.idle);
    return client.received().empty()
               ? idle_end
               : std::min(idle_end, later(client.asking_since(), limits_.asking));
}

/// A client that has not read the previous answer gets none now, and the newest one later.
bool SocketServer::repeat(SocketClient& client, Instant now) {
    if (now < client.due()) {
        return true;
    }
    client.step(now);
    return !client.has_read_all() || answers_.repeat(client, now);
}

bool SocketServer::serve_client(SocketClient& client, Instant now) {
    if (!client.flush(now)) {
        return false;
    }
    if (client.ready() && !client.done() &&
        !(client.receive(now) && answers_.request(client, now))) {
        return false;
    }
    // epoll would report a client that hung up again and again.
    if ((client.ended() && hung_up(client.descriptor())) || !repeat(client, now)) {
        return false;
    }
    if (client.repeats() && client.has_read_all()) {
        client.passed(now);
    }
    if (client.done() && client.discards()) {
        return client.discard(now);
    }
    const bool has_all = client.ended() && client.ready() && !client.waits();
    return !client.done() && !(has_all && !client.repeats());
}

void SocketServer::serve(Instant now) {
    if (!accepting_ && now >= accept_again_) {
        accepting_ = true;
        epoll_event event{};
        event.events = EPOLLIN;
        ::epoll_ctl(epoll_.get(), EPOLL_CTL_ADD, listener_.get(), &event);
    }
    if (accepting_) {
        accept_all(now);
    }
    for (auto client = clients_.begin(); client != clients_.end();) {
        const bool late = now >= patience_end(*client);
        dropped_ += late ? 1 : 0;
        if (late || !serve_client(*client, now)) {
            client = clients_.erase(client);
        } else {
            watch(*client);
            ++client;
        }
    }
}

}  // namespace tribus
