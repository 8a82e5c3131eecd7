#include "pipelines/realtime/line_exchange.h"

#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace tribus {

tl::expected<void, std::string> LineExchange::prepare() {
    for (UniqueFd* bell : {&data_bell_, &lines_bell_}) {
        *bell = UniqueFd(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK));
        if (!bell->valid()) {
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

void LineExchange::ring(const UniqueFd& bell) {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(bell.get(), &one, sizeof one);
}

void LineExchange::hush(const UniqueFd& bell) {
    std::uint64_t count = 0;
    [[maybe_unused]] const auto taken = ::read(bell.get(), &count, sizeof count);
}

}  // namespace tribus
