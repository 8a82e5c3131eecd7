#pragma once

#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <string>
#include <utility>

#include <gtest/gtest.h>

#include "app/client/control_socket.h"

namespace tribus::test {

/// A client of a local socket that reads only when told to.
class Guest {
  public:
    explicit Guest(const std::string& path) {
        auto socket = connect_local(path);
        EXPECT_TRUE(socket) << path;
        if (socket) {
            socket_ = std::move(*socket);
        }
    }
    void say(const std::string& text) {
        ::send(socket_.get(), text.data(), text.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
    }
    /// Returns all bytes that wait, with "(closed)" after the end of the stream.
    std::string read() {
        std::string all;
        std::array<char, 65536> bytes;
        for (;;) {
            const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
            if (count <= 0) {
                // The kernel says so if what it has said was not read.
                const bool closed = count == 0 || errno == ECONNRESET;
                return all + (closed ? "(closed)" : "");
            }
            all.append(bytes.data(), static_cast<std::size_t>(count));
        }
    }
    void say_no_more() { ::shutdown(socket_.get(), SHUT_WR); }
    void leave() { socket_.reset(); }

  private:
    UniqueFd socket_;
};

}  // namespace tribus::test
