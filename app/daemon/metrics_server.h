#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "app/client/control_socket.h"
#include "app/daemon/socket_server.h"
#include "core/time.h"

namespace tribus {

/// Who can reach the metrics.
enum class MetricsReach : std::uint8_t {
    local,    ///< this machine only
    network,  ///< everybody who can reach the address; the server does not authenticate
};

/// GET /metrics over HTTP/1.1, for Prometheus. Thread-bound to the main thread, which waits for
/// `descriptor` and `due` and then calls `serve`.
class MetricsServer {
  public:
    /// `address` is "127.0.0.1:9464", "[::1]:9464", or the path of a local socket. The error is a
    /// sentence.
    static tl::expected<std::unique_ptr<MetricsServer>, std::string> open(
        const std::string& address, MetricsReach reach, std::function<std::string()> metrics);
    MetricsServer(const MetricsServer&) = delete;
    MetricsServer& operator=(const MetricsServer&) = delete;

    int descriptor() const { return server_->descriptor(); }
    Instant due() const { return server_->due(); }
    void serve(Instant now) { server_->serve(now); }
    std::size_t client_count() const { return server_->client_count(); }

  private:
    MetricsServer() = default;

    /// Only if `address` is a path.
    std::optional<LocalListener> listener_;
    std::optional<SocketServer> server_;
};

/// Which host names a request may use. A page from elsewhere whose host name resolves to 127.0.0.1
/// could otherwise read the metrics through a browser on this machine.
enum class HostNames : std::uint8_t {
    own,  ///< IP addresses and localhost
    any,
};

/// The whole response to a request whose head is complete. Pure.
std::string http_response(std::string_view head, HostNames allowed,
                          const std::function<std::string()>& metrics);

}  // namespace tribus
