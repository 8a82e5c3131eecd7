#pragma once

#include <memory>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "app/daemon/socket_server.h"
#include "app/web/http/listeners.h"
#include "app/web/server/site.h"
#include "core/time.h"

namespace tribus::web {

/// The site on its listening sockets. Thread-bound.
class PageServer {
  public:
    /// The error is a sentence.
    static tl::expected<std::unique_ptr<PageServer>, std::string> make(
        std::vector<Listener> listeners, SiteSettings settings);

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
    std::vector<LocalListener> files_;
};

}  // namespace tribus::web
