#pragma once

#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/daemon/socket_server.h"
#include "app/web/server/site.h"
#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus::web {

/// Sockets that systemd listens on for this program (sd_listen_fds(3)); empty without it.
std::vector<UniqueFd> inherited_listeners();
/// Listens at 127.0.0.1:PORT, [::1]:PORT or another address if the network may reach it. The error
/// is a sentence.
tl::expected<UniqueFd, std::string> listen_at(const std::string& address, bool is_public);

/// Where a listening socket can be reached: `127.0.0.1:8480`.
std::string address_of_listener(const UniqueFd& listener);

/// The site on its listening sockets. Thread-bound.
class PageServer {
  public:
    /// The listeners must be non-blocking. The error is a sentence.
    static tl::expected<std::unique_ptr<PageServer>, std::string> make(
        std::vector<UniqueFd> listeners, SiteSettings settings);

    /// Readable when `serve` has something to do.
    std::vector<int> descriptors() const;
    /// When `serve` must be called at the latest.
    Instant due() const;
    void serve(Instant now);
    bool in_use() const;

  private:
    explicit PageServer(SiteSettings settings) : site_(std::move(settings)) {}

    Site site_;
    std::vector<SocketServer> servers_;
};

}  // namespace tribus::web
