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

/// A client of a socket of this program. No function waits for it; what the client does not read is
/// its own loss. At most one answer is being sent at a time, and no further request is read before
/// that is done. Thread-bound.
class SocketClient {
  public:
    /// `most_received`: upper limit of a request in bytes. `who`: see `who`.
    SocketClient(UniqueFd descriptor, std::size_t most_received, Instant now, std::string who = {});

    int descriptor() const { return descriptor_.get(); }
    /// The other side, as `peer_name` says it.
    const std::string& who() const { return who_; }
    /// Reads what has arrived. Returns false if the connection is closed or broken.
    bool receive(Instant now);
    /// Bytes of requests that were not taken yet.
    std::string_view received() const { return received_; }
    /// True if there is no room for more of this request.
    bool request_too_long() const { return received_.size() >= most_received_; }
    /// When the first of these bytes arrived.
    Instant asking_since() const { return asking_since_; }
    /// Removes the first bytes of what was received.
    void take_received(std::size_t count) { received_.erase(0, count); }
    /// Removes the first complete line and returns it without its end.
    std::optional<std::string> take_line();
    /// True if the client will send no more.
    bool ended() const { return ended_; }

    /// Sends an answer; call it only while `ready`. Returns false if the client is gone.
    bool send(std::string text, Instant now);
    /// The next piece of something long; an empty one at its end, nothing if it breaks off.
    using Source = std::function<std::optional<std::string>()>;
    /// Behind the text that is sent next comes what `source` gives. Each piece is asked for when
    /// the client has taken the one before, so that no more than a piece is in memory. If the
    /// source breaks off, the client must be dropped: it sees that the answer is too short.
    void follow_with(Source source) { source_ = std::move(source); }
    /// Sends more of the present answer, at most one piece of a source. Returns false if the client
    /// is gone or the source broke off.
    bool flush(Instant now);
    /// True if the kernel has taken the whole answer.
    bool ready() const { return sent_ == under_way_.size() && !source_; }
    /// True if the client has also read all answers. Local sockets only.
    bool has_read_all() const;
    /// The connection ends after the present answer, or the one that it waits for.
    void close_when_sent() { closing_ = true; }
    /// The same for a request of which more may come. That is discarded for a while: the kernel
    /// would reset a connection with unread bytes, and the answer with it (RFC 9112, 9.6).
    void close_when_sent_and_discard() { closing_ = discards_ = true; }
    bool discards() const { return discards_; }
    /// Discards some of what has come behind the last answer. False if no more will.
    bool discard(Instant now);
    /// Until when `discard` is of use; `kNever` before its first call.
    Instant discard_end() const { return discard_end_; }
    /// The answer comes later, as soon as `answer` returns one. No further request is handled
    /// before.
    void wait_for(std::function<std::optional<std::string>()> answer) {
        answer_ = std::move(answer);
    }
    /// True while the client waits for a late answer.
    bool waits() const { return answer_ != nullptr; }
    /// The late answer, if it is there.
    std::optional<std::string> take_answer();

    /// True if the client gets no further answer.
    bool done() const { return closing_ && ready() && !waits(); }

    /// From `first` on, the client gets an answer each `period` without a request.
    void repeat(Duration period, Instant first) {
        period_ = period;
        next_ = first;
    }
    /// The same, with what is sent then. It returns false if the client must be dropped.
    using Next = std::function<bool(SocketClient&, Instant now)>;
    void repeat(Duration period, Instant first, Next next) {
        repeat(period, first);
        next_answer_ = std::move(next);
    }
    bool send_next(Instant now) { return next_answer_(*this, now); }
    bool repeats() const { return period_ > Duration::zero(); }
    /// When the next such answer is due; `kNever` without `repeat`.
    Instant due() const { return repeats() ? next_ : kNever; }
    /// Moves `due` to the next future instant on the grid of the period.
    void step(Instant now);

    /// When data last passed in either direction.
    Instant quiet_since() const { return quiet_since_; }
    void passed(Instant now) { quiet_since_ = now; }

  private:
    UniqueFd descriptor_;
    std::size_t most_received_;
    std::string received_;
    std::string under_way_;
    std::size_t sent_ = 0;
    Source source_;
    bool ended_ = false;
    bool closing_ = false;
    bool discards_ = false;
    Instant discard_end_ = kNever;
    std::function<std::optional<std::string>()> answer_;
    Duration period_{};
    Instant next_{};
    Next next_answer_;
    Instant quiet_since_;
    Instant asking_since_;
    std::string who_;
};

}  // namespace tribus
