#include "config/schema/choices.h"

#include <gtest/gtest.h>

#include <optional>
#include <string_view>
#include <utility>
#include <vector>

namespace tribus::test::choices_test {
namespace {

/// Every value of an enumeration, with its word in the language.
template <class Choice>
void expect_words(const std::vector<std::pair<Choice, std::string_view>>& all) {
    EXPECT_EQ(ChoiceWords<Choice>::kAll.size(), all.size());
    for (const auto& [choice, word] : all) {
        EXPECT_EQ(word_of(choice), word);
        EXPECT_EQ(choice_named<Choice>(word), choice) << word;
    }
    EXPECT_EQ(choice_named<Choice>("no such word"), std::nullopt);
}

TEST(ChoiceWords, AreThoseOfTheManualForEveryValue) {
    expect_words<Realtime>(
        {{Realtime::automatic, "auto"}, {Realtime::off, "off"}, {Realtime::require, "require"}});
    expect_words<ScheduleKind>({{ScheduleKind::follow, "follow"}, {ScheduleKind::grid, "grid"}});
    expect_words<Phase>({{Phase::free, "free"}, {Phase::locked, "locked"}});
    expect_words<ForeignSender>(
        {{ForeignSender::failsafe, "failsafe"}, {ForeignSender::ignore, "ignore"}});
    expect_words<SelectionMode>({{SelectionMode::priority, "priority"},
                                 {SelectionMode::sticky, "sticky"},
                                 {SelectionMode::freshest, "freshest"},
                                 {SelectionMode::median, "median"}});
    expect_words<FailsafeAction>({{FailsafeAction::preset, "preset"},
                                  {FailsafeAction::hold, "hold"},
                                  {FailsafeAction::silence, "silence"}});
    expect_words<LineRole>({{LineRole::link, "link"},
                            {LineRole::failsafe, "failsafe"},
                            {LineRole::fresh, "fresh"},
                            {LineRole::force_failsafe, "force_failsafe"},
                            {LineRole::select, "select"},
                            {LineRole::inverter, "inverter"},
                            {LineRole::button, "button"},
                            {LineRole::channel_switch, "switch"}});
    expect_words<GpioBias>({{GpioBias::as_is, "as_is"},
                            {GpioBias::pull_up, "pull_up"},
                            {GpioBias::pull_down, "pull_down"},
                            {GpioBias::none, "none"}});
    expect_words<BusRole>({{BusRole::sensor, "sensor"}, {BusRole::receiver, "receiver"}});
    expect_words<Wires>({{Wires::automatic, "auto"}, {Wires::one, "one"}, {Wires::two, "two"}});
    expect_words<SensorDialect>({{SensorDialect::flysky, "flysky"},
                                 {SensorDialect::betaflight, "betaflight"},
                                 {SensorDialect::inav, "inav"},
                                 {SensorDialect::ardupilot, "ardupilot"},
                                 {SensorDialect::edgetx, "edgetx"},
                                 {SensorDialect::flyplus, "flyplus"}});
}

}  // namespace
}  // namespace tribus::test::choices_test
