#include "tests/loopback/browser.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>

namespace tribus::test {
namespace {

int connected(int port, const std::string& from = "127.0.0.1") {
    const int socket = ::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    ::inet_pton(AF_INET, from.c_str(), &address.sin_addr);
    ::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address);
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    if (::connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
        ::close(socket);
        return -1;
    }
    return socket;
}

/// Appends what comes. Returns false at the end, or when patience is over.
bool receive(int socket, std::string& received, std::chrono::milliseconds patience) {
    std::array<char, 16384> bytes;
    pollfd readable{.fd = socket, .events = POLLIN, .revents = 0};
    if (::poll(&readable, 1, static_cast<int>(patience.count())) <= 0) {
        return false;
    }
    const ssize_t count = ::recv(socket, bytes.data(), bytes.size(), 0);
    if (count > 0) {
        received.append(bytes.data(), static_cast<std::size_t>(count));
    }
    return count > 0;
}

}  // namespace

std::string BrowserAnswer::header(const std::string& name) const {
    const std::size_t at = head.find("\r\n" + name + ": ");
    if (at == std::string::npos) {
        return {};
    }
    const std::size_t begin = at + 2 + name.size() + 2;
    return head.substr(begin, head.find("\r\n", begin) - begin);
}

BrowserAnswer Browser::post(const std::string& path, const nlohmann::json& body,
                            const std::map<std::string, std::string>& more) const {
    return post_text(path, body.dump(), more);
}

BrowserAnswer Browser::post_text(const std::string& path, const std::string& body,
                                 const std::map<std::string, std::string>& more) const {
    std::map<std::string, std::string> headers{
        {"Content-Type", "application/json"}, {"X-Tribus", "1"}, {"Origin", "http://" + host()}};
    for (const auto& [name, value] : more) {
        headers[name] = value;
    }
    return ask("POST", path, body, headers);
}

BrowserAnswer Browser::ask(const std::string& method, const std::string& path,
                           const std::optional<std::string>& body,
                           const std::map<std::string, std::string>& headers) const {
    std::string text = method + " " + path + " HTTP/1.1\r\nConnection: close\r\n";
    if (!headers.contains("Host")) {
        text += "Host: " + host() + "\r\n";
    }
    if (!cookie_.empty()) {
        text += "Cookie: " + cookie_ + "\r\n";
    }
    for (const auto& [name, value] : headers) {
        text += name + ": " + value + "\r\n";
    }
    if (body) {
        text += "Content-Length: " + std::to_string(body->size()) + "\r\n";
    }
    const std::string received = raw(text + "\r\n" + body.value_or(""));
    const std::size_t end = received.find("\r\n\r\n");
    if (end == std::string::npos) {
        return {};
    }
    return {.status = std::stoi(received.substr(received.find(' ') + 1)),
            .head = received.substr(0, end + 2),
            .content = received.substr(end + 4)};
}

void Browser::post_and_leave(const std::string& path, const nlohmann::json& body) const {
    const std::string content = body.dump();
    const std::string text =
        "POST " + path + " HTTP/1.1\r\nHost: " + host() + "\r\nCookie: " + cookie_ +
        "\r\nOrigin: http://" + host() + "\r\nContent-Type: application/json\r\nX-Tribus: 1\r\n" +
        "Content-Length: " + std::to_string(content.size()) + "\r\n\r\n" + content;
    const int socket = connected(port_, from_);
    ::send(socket, text.data(), text.size(), MSG_NOSIGNAL);
    ::close(socket);
}

std::string Browser::raw(const std::string& bytes) const {
    const int socket = connected(port_, from_);
    std::string received;
    ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    while (receive(socket, received, patience_)) {
    }
    ::close(socket);
    return received;
}

std::string Browser::raw(const std::string& bytes, const std::string& more) const {
    const int socket = connected(port_, from_);
    std::string received;
    ::send(socket, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (receive(socket, received, patience_)) {
        ::send(socket, more.data(), more.size(), MSG_NOSIGNAL);
    }
    while (receive(socket, received, patience_)) {
    }
    ::close(socket);
    return received;
}

BrowserAnswer Browser::pair(const std::string& code) {
    BrowserAnswer answer = post("/pair", {{"code", code}, {"name", "browser"}});
    const std::string cookie = answer.header("Set-Cookie");
    cookie_ = cookie.substr(0, cookie.find(';'));
    return answer;
}

OpenConnection::OpenConnection(int port, const std::string& bytes) : socket_(connected(port)) {
    ::send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL);
}

OpenConnection::~OpenConnection() {
    ::close(socket_);
}

EventStream::EventStream(const Browser& browser, int port, const std::string& path)
    : socket_(connected(port)) {
    const std::string text = "GET " + path + " HTTP/1.1\r\nHost: " + browser.host() +
                             "\r\nCookie: " + browser.cookie() + "\r\n\r\n";
    ::send(socket_, text.data(), text.size(), MSG_NOSIGNAL);
}

EventStream::~EventStream() {
    ::close(socket_);
}

bool EventStream::read_more() {
    ended_ = ended_ || !receive(socket_, received_, kBrowserPatience);
    return !ended_;
}

std::optional<std::string> EventStream::next(const std::string& name) {
    const auto end = std::chrono::steady_clock::now() + kPatience;
    while (std::chrono::steady_clock::now() < end) {
        const std::string begin = "event: " + name + "\ndata: ";
        const std::size_t at = received_.find(begin);
        const std::size_t line_end =
            at == std::string::npos ? at : received_.find("\n\n", at + begin.size());
        if (line_end != std::string::npos) {
            std::string data = received_.substr(at + begin.size(), line_end - at - begin.size());
            received_.erase(0, line_end + 2);
            return data;
        }
        if (!read_more()) {
            return std::nullopt;
        }
    }
    return std::nullopt;
}

bool EventStream::ended() {
    while (read_more()) {
    }
    return ended_;
}

}  // namespace tribus::test
