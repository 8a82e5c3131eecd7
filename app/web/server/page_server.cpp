#include "app/web/server/page_server.h"

#include <algorithm>
#include <utility>

namespace tribus::web {
namespace {

using Refused = tl::unexpected<std::string>;

constexpr std::size_t kMostClients = 16;
constexpr Duration kHeadPatience = std::chrono::seconds(5);
constexpr Duration kReadPatience = std::chrono::seconds(10);

}  // namespace

tl::expected<std::unique_ptr<PageServer>, std::string> PageServer::make(
    std::vector<Listener> listeners, SiteSettings settings) {
    std::unique_ptr<PageServer> page(new PageServer(std::move(settings)));
    const auto request = [site = &page->site_](SocketClient& client, Instant now) {
        return site->answer(client, now);
    };
    const auto repeat = [](SocketClient& client, Instant now) { return client.send_next(now); };
    for (Listener& listener : listeners) {
        auto server = SocketServer::make(std::move(listener.socket),
                                         {.clients = kMostClients,
                                          .request = kLongestHead + kLongestBody,
                                          .unread = kReadPatience,
                                          .idle = kHeadPatience,
                                          .asking = kReadPatience,
                                          .refusal = {}},
                                         {.request = request, .repeat = repeat});
        if (!server) {
            return Refused(server.error());
        }
        page->servers_.push_back(std::move(*server));
        if (listener.file) {
            page->files_.push_back(std::move(*listener.file));
        }
    }
    return page;
}

std::vector<int> PageServer::descriptors() const {
    std::vector<int> descriptors = site_.descriptors(servers_.size());
    for (const SocketServer& server : servers_) {
        descriptors.push_back(server.descriptor());
    }
    return descriptors;
}

Instant PageServer::due() const {
    Instant due = site_.due();
    for (const SocketServer& server : servers_) {
        due = std::min(due, server.due());
    }
    return due;
}

void PageServer::serve(Instant now) {
    site_.look(now);
    for (SocketServer& server : servers_) {
        server.serve(now);
    }
}

bool PageServer::in_use() const {
    return site_.in_use() || std::ranges::any_of(servers_, [](const SocketServer& server) {
               return server.client_count() != 0;
           });
}

}  // namespace tribus::web
