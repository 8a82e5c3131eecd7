#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "core/time.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// One who has connected to a socket of this program. Nothing here ever waits for it: what it does
/// not read stays its own loss. At most one answer is under way at any time, and a further request
/// is not even read before that has left. Thread-bound.
class SocketClient {
  public:
    /// `most_received` is the longest request in bytes, `user` whose it is.
    SocketClient(UniqueFd descriptor, std::size_t most_received, Instant now,
                 std::uint32_t user = 0);

    int descriptor() const { return descriptor_.get(); }
    std::uint32_t user() const { return user_; }
    /// When it connected.
    Instant begin() const { return begin_; }
    /// Reads what is there. False: it is gone, or its connection is broken.
    bool receive(Instant now);
    /// Bytes of requests that were not taken yet.
    std::string_view received() const { return received_; }
    /// There is no room for more of this request.
    bool request_too_long() const { return received_.size() >= most_received_; }
    /// A whole line off the front, without its end.
    std::optional<std::string> take_line();
    /// It will send no more.
    bool ended() const { return ended_; }

    /// Only while `ready`. False: it is gone.
    bool send(std::string text, Instant now);
    /// Sends on what is under way. False: it is gone.
    bool flush(Instant now);
    /// The answer before has been taken by the kernel.
    bool ready() const { return sent_ == under_way_.size(); }
    /// All answers before have been read by the other side as well. Local sockets only.
    bool has_read_all() const;
    void close_when_sent() { closing_ = true; }
    /// It gets its answer later: once `answer` gives one. Until then it is asked nothing else.
    void wait_for(std::function<std::optional<std::string>()> answer) {
        answer_ = std::move(answer);
    }
    bool waits() const { return answer_ != nullptr; }
    /// The answer that it waits for, once it is there.
    std::optional<std::string> take_answer();

    /// It has had its last answer, or can have none.
    bool done() const { return closing_ && ready(); }

    /// From `first` on it gets an answer each `period`, unasked.
    void repeat(Duration period, Instant first) {
        period_ = period;
        next_ = first;
    }
    bool repeats() const { return period_ > Duration::zero(); }
    /// When that is due; `kNever` where it gets none.
    Instant due() const { return repeats() ? next_ : kNever; }
    /// On the grid of its period, in the future.
    void step(Instant now);

    /// Since when nothing of it, and nothing to it, has passed.
    Instant quiet_since() const { return quiet_since_; }
    void passed(Instant now) { quiet_since_ = now; }

  private:
    UniqueFd descriptor_;
    std::size_t most_received_;
    std::string received_;
    std::string under_way_;
    std::size_t sent_ = 0;
    bool ended_ = false;
    bool closing_ = false;
    std::function<std::optional<std::string>()> answer_;
    Duration period_{};
    Instant next_{};
    Instant quiet_since_;
    Instant begin_;
    std::uint32_t user_;
};

}  // namespace tribus
