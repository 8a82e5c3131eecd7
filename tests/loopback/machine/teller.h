#pragma once

#include <memory>
#include <utility>

#include "app/appliance/appliance.h"
#include "app/changes/change_journal.h"
#include "app/log/change_log.h"
#include "app/log/state_log.h"
#include "config/build/carry_over.h"
#include "core/time.h"

namespace tribus::test {

/// What the daemon does a few times a second with an appliance and its log, at times of the test's
/// choice.
class Teller {
  public:
    Teller(Appliance& appliance, Instant start)
        : log_(std::make_unique<StateLog>(appliance, start)) {
        changes_.begin(appliance, start, {});
    }
    void look(Appliance& appliance, Instant now) {
        const Appliance::DeviceNews news = appliance.look_after_devices(now);
        changes_.add(news.events, now, {});
        if (std::exchange(is_successor_, false)) {
            changes_.add(appliance.devices(), now, {});
        }
        changes_.look(appliance, now, {});
        change_log_.look(changes_, now);
        log_->look(appliance, news, now);
    }
    void go_on_with(const Appliance& successor, const CarryOver& carry_over, Instant now) {
        changes_.take_the_last_before(successor, now, {});
        change_log_.look(changes_, now);
        change_log_.flush();
        changes_.go_on_with(successor, carry_over, now, {});
        auto log = std::make_unique<StateLog>(successor, now);
        log->go_on_from(*log_, successor, carry_over);
        log_ = std::move(log);
        is_successor_ = true;
    }
    const ChangeJournal& changes() const { return changes_; }

  private:
    ChangeJournal changes_;
    ChangeLog change_log_;
    std::unique_ptr<StateLog> log_;
    bool is_successor_ = false;
};

}  // namespace tribus::test
