#pragma once

#include <optional>
#include <string>
#include <string_view>

#include <tl/expected.hpp>

#include "transports/links/unique_fd.h"

namespace tribus::web {

/// A program that answers in lines, over a socket. Nothing here waits. Thread-bound.
class LineTalk {
  public:
    /// `who`: the subject of a sentence, as "the daemon". `socket`: why there is none, or one.
    LineTalk(std::string_view who, tl::expected<UniqueFd, std::string> socket);

    int descriptor() const { return socket_.get(); }
    /// Sends a line, without its end.
    void say(std::string_view line);
    /// Reads what is there. Returns the next line without its end, once it is whole.
    std::optional<std::string> hear();
    const std::string& who() const { return who_; }
    /// Why no further line comes, as a sentence; empty while one may come.
    const std::string& failed() const { return failed_; }

  private:
    std::string who_;
    UniqueFd socket_;
    std::string received_;
    std::string failed_;
};

/// Starts the helper for ports behind one end of a socket: by connecting to `path`, on which a
/// service manager listens for it, or with an empty path as a child of this program, which has then
/// its rights. The error is a sentence.
tl::expected<UniqueFd, std::string> start_ports_helper(const std::string& path,
                                                       const std::string& configurations);

}  // namespace tribus::web
