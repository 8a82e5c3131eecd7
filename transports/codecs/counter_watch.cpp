#include "transports/codecs/counter_watch.h"

#include <algorithm>

namespace tribus {

CounterWatch::Verdict CounterWatch::doubtful(Verdict verdict) {
    doubt();
    return verdict;
}

CounterWatch::Verdict CounterWatch::take(std::uint64_t count, bool same_content, Instant received) {
    const auto previous = received - received_ > limits_.silence ? std::nullopt : count_;
    count_ = count < limits_.values ? std::optional(count) : std::nullopt;
    received_ = received;
    if (!count_) {
        return doubtful(Verdict::jump);
    }
    if (!previous) {
        return doubtful(Verdict::unconfirmed);
    }
    const std::uint64_t step = (count + limits_.values - *previous) % limits_.values;
    if (step == 0) {
        // The same frame may come twice after an error that only its sender saw.
        return same_content ? Verdict::repeated : doubtful(Verdict::conflict);
    }
    if (step > limits_.most_step) {
        return doubtful(Verdict::jump);
    }
    proof_ = std::min(proof_ + 1, kProof);
    return proof_ == kProof ? Verdict::good : Verdict::unconfirmed;
}

}  // namespace tribus
