#pragma once

#include <sys/socket.h>
#include <sys/un.h>

#include <array>
#include <cstddef>
#include <cstdlib>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "transports/links/unique_fd.h"

namespace tribus::test {

/// A variable of this program's environment, as long as this object is there.
class Variable {
  public:
    /// Without `value` the variable is not there.
    Variable(std::string name, const std::optional<std::string>& value) : name_(std::move(name)) {
        if (const char* const before = std::getenv(name_.c_str())) {
            before_ = before;
        }
        set(value);
    }
    Variable(const Variable&) = delete;
    Variable& operator=(const Variable&) = delete;
    ~Variable() { set(before_); }

  private:
    void set(const std::optional<std::string>& value) const {
        if (value) {
            ::setenv(name_.c_str(), value->c_str(), 1);
        } else {
            ::unsetenv(name_.c_str());
        }
    }

    std::string name_;
    std::optional<std::string> before_;
};

/// The socket at which a service manager hears its services. It must be there before they start.
class ServiceManager {
  public:
    /// `name`: a path, or an abstract name that begins with `@`.
    explicit ServiceManager(const std::string& name)
        : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        name.copy(address.sun_path, sizeof address.sun_path - 1);
        if (name.front() == '@') {
            address.sun_path[0] = '\0';
        }
        const auto size = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + name.size());
        EXPECT_EQ(::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), size), 0);
    }

    /// Returns the datagrams since the last call.
    std::vector<std::string> told() {
        std::vector<std::string> all;
        std::array<char, 4096> bytes{};
        for (;;) {
            const ssize_t count = ::recv(socket_.get(), bytes.data(), bytes.size(), MSG_DONTWAIT);
            if (count < 0) {
                return all;
            }
            all.emplace_back(bytes.data(), static_cast<std::size_t>(count));
        }
    }

    /// The same, without how long something lasts, which is longer on a busy machine.
    std::vector<std::string> told_without_times() {
        static const std::regex kTime(" for more than [^;]*");
        std::vector<std::string> all = told();
        for (std::string& line : all) {
            line = std::regex_replace(line, kTime, "");
        }
        return all;
    }

  private:
    UniqueFd socket_;
};

}  // namespace tribus::test
