#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

#include "tests/loopback/program.h"

/// A plain client of HTTP, as far as tests of the page's server need one: one connection a request,
/// and streams that stay open.
namespace tribus::test {

inline constexpr auto kBrowserPatience =
    std::chrono::duration_cast<std::chrono::milliseconds>(kPatience);

struct BrowserAnswer {
    int status = 0;  ///< 0: the connection ended without an answer
    std::string head;
    std::string content;

    nlohmann::json json() const { return nlohmann::json::parse(content, nullptr, false); }
    /// The value of a header, or empty.
    std::string header(const std::string& name) const;
};

class Browser {
  public:
    /// `from`: the address from which it asks, one of 127.0.0.0/8.
    explicit Browser(int port, std::string from = "127.0.0.1")
        : port_(port), from_(std::move(from)) {}

    BrowserAnswer get(const std::string& path) const { return ask("GET", path, {}); }
    /// As the page itself sends it.
    BrowserAnswer post(const std::string& path, const nlohmann::json& body,
                       const std::map<std::string, std::string>& more = {}) const;
    /// The same with a body that may be no JSON.
    BrowserAnswer post_text(const std::string& path, const std::string& body,
                            const std::map<std::string, std::string>& more = {}) const;
    BrowserAnswer ask(const std::string& method, const std::string& path,
                      const std::optional<std::string>& body,
                      const std::map<std::string, std::string>& headers = {}) const;
    /// As `post`, but the browser is gone before the answer comes.
    void post_and_leave(const std::string& path, const nlohmann::json& body) const;
    /// Sends these bytes and returns all that comes back until the end.
    std::string raw(const std::string& bytes) const;
    /// The same, and sends `more` once the first answer has begun.
    std::string raw(const std::string& bytes, const std::string& more) const;
    /// Pairs with this code and keeps the cookie.
    BrowserAnswer pair(const std::string& code);

    /// It waits so long while nothing comes.
    void be_patient(std::chrono::milliseconds patience) { patience_ = patience; }

    std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
    const std::string& cookie() const { return cookie_; }

  private:
    int port_;
    std::string from_;
    std::string cookie_;
    std::chrono::milliseconds patience_ = kBrowserPatience;
};

/// A connection whose other side sent this and reads nothing.
class OpenConnection {
  public:
    OpenConnection(int port, const std::string& bytes);
    OpenConnection(const OpenConnection&) = delete;
    OpenConnection& operator=(const OpenConnection&) = delete;
    ~OpenConnection();

  private:
    int socket_ = -1;
};

/// A stream of events that stays open.
class EventStream {
  public:
    EventStream(const Browser& browser, int port, const std::string& path);
    EventStream(const EventStream&) = delete;
    EventStream& operator=(const EventStream&) = delete;
    ~EventStream();

    /// Reads until an event of that name comes and returns its data; nothing when patience is over
    /// or the stream has ended.
    std::optional<std::string> next(const std::string& name);
    /// Whether the server has ended it.
    bool ended();

  private:
    bool read_more();
    int socket_ = -1;
    std::string received_;
    bool ended_ = false;
};

}  // namespace tribus::test
