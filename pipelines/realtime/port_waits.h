#pragma once

#include <sys/epoll.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <tl/expected.hpp>

#include "core/time.h"
#include "transports/links/link.h"
#include "transports/links/unique_fd.h"

namespace tribus {

/// What the data thread waits for: the links of ports, and events of other threads. The kernel
/// keeps a number of each watch, not an address: an event of a watch that has ended names no port.
/// The data thread calls all functions except where a comment says otherwise. Nothing here uses the
/// heap but `prepare` and `make_room`.
class PortWaits {
  public:
    /// Most ports that one wait names.
    static constexpr std::size_t kMostReady = 64;

    /// Names one watch, for ever.
    struct Watch {
        std::uint32_t place = 0;
        std::uint32_t generation = 0;
    };

    /// Creates the descriptors, with room for the links of `ports` ports. Main thread. The error is
    /// a sentence.
    tl::expected<void, std::string> prepare(std::size_t ports);
    /// Adds an event of another thread. Main thread, before the first `wait`.
    tl::expected<void, std::string> add_event(int descriptor);
    /// Makes room for the watches of a running `before` beside those of its own ports, and ends its
    /// own: `continue_from` takes the descriptors of `before`. Main thread.
    void make_room(const PortWaits& before);
    /// Takes the descriptors and the watches of `before` unchanged. To add a terminal anew may wait
    /// for the kernel's work on arriving bytes; where that is starved, all outputs would be late.
    void continue_from(PortWaits& before);

    /// Watches both descriptors of a link. Nothing: the kernel refused one, and none is watched.
    std::optional<Watch> watch(const Link& link, std::size_t port, bool arrivals);
    /// Whether arrivals are reported, or only hang-ups.
    void set_arrivals(const Watch& watch, const Link& link, bool arrivals);
    /// The link of this watch belongs to another port now.
    void set_port(const Watch& watch, std::size_t port);
    /// Ends the watch of both descriptors. Call it before the link is closed.
    void end(const Watch& watch, const Link& link);

    /// Sleeps until a link is ready, an event came, or `longest` is over. `ready` gets the ports
    /// whose links are ready. Returns how many.
    std::size_t wait(Duration longest, std::span<std::uint32_t, kMostReady> ready);
    /// Whether the latest wait told anything besides bytes and frames.
    bool has_news() const { return news_ != 0; }
    bool event_came() const { return (news_ & kEventCame) != 0; }
    /// At a port not only bytes came: a hang-up or an error.
    bool hung_up() const { return (news_ & kHungUp) != 0; }
    /// The thread was stopped, frozen or suspended.
    bool interrupted() const { return (news_ & kInterrupted) != 0; }
    /// The kernel refuses to wait; `failure` says why.
    bool failed() const { return (news_ & kFailed) != 0; }
    /// The event that ends a wait of this thread. Any thread may write to it.
    int wake_up() const { return wake_up_.get(); }
    /// Why a wait failed: a value of errno.
    int failure() const { return failure_; }

  private:
    /// Port of a place that is free.
    static constexpr std::uint32_t kNoPort = ~0U;
    struct Place {
        std::uint32_t generation = 0;  ///< another one for each watch and after its end
        std::uint32_t port = kNoPort;
    };

    bool control(int operation, int descriptor, const Watch& watch, std::uint32_t events) const;
    int wait_for(const Duration& longest, std::span<epoll_event> events);
    int wait_again(std::span<epoll_event> events);

    UniqueFd epoll_;
    UniqueFd wake_up_;
    bool has_epoll_pwait2_ = true;
    int failure_ = 0;
    enum News : unsigned { kEventCame = 1, kHungUp = 2, kInterrupted = 4, kFailed = 8 };
    unsigned news_ = 0;  ///< of the latest wait
    std::size_t ports_ = 0;
    std::vector<Place> places_;
};

}  // namespace tribus
