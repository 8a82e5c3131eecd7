#include "app/mqtt/connect_pauses.h"

#include <algorithm>
#include <utility>

namespace tribus::mqtt {

Duration ConnectPauses::next() {
    const Duration limit = std::exchange(limit_, std::min(2 * limit_, kLastLimit));
    return Duration(
        std::uniform_int_distribution<Duration::rep>(limit.count() / 2, limit.count())(random_));
}

}  // namespace tribus::mqtt
