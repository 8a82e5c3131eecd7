#include "pipelines/realtime/line_exchange.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace tribus {

tl::expected<void, std::string> LineExchange::prepare() {
    for (UniqueFd* event : {&data_event_, &lines_event_}) {
        *event = UniqueFd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
        if (!event->valid()) {
            return tl::unexpected(std::string("eventfd failed: ") + std::strerror(errno));
        }
    }
    return {};
}

Instant LineExchange::fresh_at(std::span<const std::size_t> outputs) const {
    Instant oldest = kNever;
    for (const std::size_t output : outputs) {
        const Duration since_start{fresh_ns_[output].load(std::memory_order_acquire)};
        oldest = std::min(oldest, Instant(since_start));
    }
    return oldest == kNever ? Instant{} : oldest;
}

void LineExchange::set_event(const UniqueFd& event) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(event.get(), &one, sizeof one);
}

void LineExchange::clear_event(const UniqueFd& event) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto taken = ::read(event.get(), &count, sizeof count);
}

}  // namespace tribus
