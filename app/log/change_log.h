#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <utility>

#include "app/changes/change_journal.h"
#include "app/changes/told_change.h"
#include "app/journal/log_limit.h"
#include "core/rate_limit.h"
#include "core/time.h"

namespace tribus {

/// Logs each change of a part, at most a few lines per time for each part. The next line then says
/// how many changes it stands for, and of an input how many losses, so that the counts add up.
/// Thread-bound to the main thread.
class ChangeLog {
  public:
    /// Logs the changes since the last call. Call it a few times a second.
    void look(const ChangeJournal& changes, Instant now);
    /// Logs at once what waits for its turn: the parts may have other names from now on, or there
    /// is no later.
    void flush();

  private:
    /// Changes that have no line yet.
    struct Held {
        std::uint64_t changes = 0;
        std::uint64_t losses = 0;
        Duration shortest = Duration::max();
        Duration longest{};
        Instant first{};
        ToldChange latest{};
    };
    struct Memory {
        RateLimit limit = log_limit();
        std::size_t text = 0;  ///< hash of the newest sentence; 0: there is none
        /// When the present loss of an input began; `kNever`: there is none.
        Instant lost_at = kNever;
        std::unique_ptr<Held> held{};
    };

    static void hold(const ToldChange& change, Memory& memory);
    static void log_held(Memory& memory);
    static std::string note_of(const Held& held);

    std::uint64_t number_ = 0;
    std::map<std::pair<std::string_view, std::string>, Memory> parts_;
};

}  // namespace tribus
