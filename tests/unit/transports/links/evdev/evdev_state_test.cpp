#include "transports/links/evdev/evdev_state.h"

#include <array>
#include <cstdint>
#include <vector>

#include <gtest/gtest.h>

namespace tribus::test::evdev_state_test {
namespace {

using Report = std::vector<int>;

input_event event(std::uint16_t type, std::uint16_t code, std::int32_t value) {
    input_event event{};
    event.type = type;
    event.code = code;
    event.value = value;
    return event;
}

Report report(EvdevState& state, bool gone = false) {
    std::array<std::uint8_t, gamepad_report::kMostBytes> bytes{};
    const std::size_t length = state.write(bytes, gone);
    return {bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(length)};
}

int position(const Report& report, std::size_t axis) {
    return static_cast<std::int16_t>(report.at(5 + 3 * axis) | report.at(6 + 3 * axis) << 8);
}

EvdevState with_axis(std::int32_t least, std::int32_t most) {
    EvdevState state;
    input_absinfo range{};
    range.minimum = least;
    range.maximum = most;
    state.add_axis(ABS_X, range);
    return state;
}

TEST(EvdevState, ScalesEveryAxisFromEndToEnd) {
    for (const auto& [least, most] : {std::pair(0, 255), std::pair(-32768, 32767), std::pair(-1, 1),
                                      std::pair(-2147483647 - 1, 2147483647)}) {
        EvdevState state = with_axis(least, most);
        for (const auto& [value, wanted] :
             {std::pair(least, -32767), std::pair(most, 32767),
              std::pair(static_cast<std::int32_t>((std::int64_t{least} + most) / 2), 0)}) {
            state.take(event(EV_ABS, ABS_X, value));
            EXPECT_NEAR(position(report(state), 0), wanted, 256) << least << " " << value;
        }
    }
    EvdevState narrow = with_axis(10, 20);
    narrow.take(event(EV_ABS, ABS_X, 1000));
    EXPECT_EQ(position(report(narrow), 0), 32767) << "beyond its own range";
}

TEST(EvdevState, PutsTheEndsOfAnAxisWhereTheyBelongExactly) {
    EvdevState state = with_axis(-100, 100);
    for (const auto& [value, wanted] : {std::pair(-100, -32767), std::pair(-1000, -32767),
                                        std::pair(0, 0), std::pair(100, 32767)}) {
        state.take(event(EV_ABS, ABS_X, value));
        EXPECT_EQ(position(report(state), 0), wanted) << value;
    }
    EvdevState positive = with_axis(100, 200);
    positive.take(event(EV_ABS, ABS_X, 150));
    EXPECT_EQ(position(report(positive), 0), 0);
}

TEST(EvdevState, HasNoAxisWithoutARange) {
    EvdevState state = with_axis(5, 5);
    EXPECT_EQ(report(state), (Report{0x67, 2, 0, 0}));
}

TEST(EvdevState, BeginsWithAChange) {
    EvdevState state;
    EXPECT_EQ(report(state), (Report{0x67, 2, 0, 0}));
    EXPECT_EQ(report(state), (Report{0x67, 0, 0, 0}));
}

TEST(EvdevState, IgnoresAnAxisThatTheDeviceDoesNotHave) {
    EvdevState state;
    input_absinfo range{};
    range.maximum = 10;
    state.add_axis(ABS_Y, range);
    report(state);
    state.take(event(EV_ABS, ABS_X, 5));
    EXPECT_EQ(report(state), (Report{0x67, 0, 1, 0, ABS_Y, 0x01, 0x80}));
}

TEST(EvdevState, HasTheButtonsFromTheFirstToTheLastCodeAndNoKeys) {
    EvdevState state;
    report(state);
    for (const int code : {KEY_A, BTN_MISC - 1, KEY_CNT}) {
        state.take(event(EV_KEY, static_cast<std::uint16_t>(code), 1));
    }
    EXPECT_EQ(report(state), (Report{0x67, 0, 0, 0}));
    state.take(event(EV_KEY, BTN_MISC, 1));
    EXPECT_EQ(report(state), (Report{0x67, 2, 0, 1, 0x00, 0x01}));
    state.take(event(EV_KEY, BTN_MISC, 0));
    state.take(event(EV_KEY, KEY_CNT - 1, 1));
    EXPECT_EQ(report(state), (Report{0x67, 2, 0, 1, 0xFF, 0x02}));
}

/// The numbers of SYN_REPORT and SYN_DROPPED, 0 and 3, are those of axes too.
TEST(EvdevState, TellsSynchronisationFromAxesAndOtherEvents) {
    EvdevState state = with_axis(-100, 100);
    input_absinfo range{};
    range.minimum = -100;
    range.maximum = 100;
    state.add_axis(ABS_RX, range);
    report(state);
    EXPECT_EQ(state.take(event(EV_ABS, ABS_RX, 100)), EvdevState::Outcome::none);
    EXPECT_EQ(state.take(event(EV_ABS, ABS_X, 100)), EvdevState::Outcome::none);
    EXPECT_EQ(state.take(event(EV_SYN, SYN_MT_REPORT, 0)), EvdevState::Outcome::none);
    EXPECT_EQ(state.take(event(EV_REL, ABS_X, -100)), EvdevState::Outcome::none);
    EXPECT_EQ(state.take(event(EV_MSC, BTN_SOUTH, 1)), EvdevState::Outcome::none);
    EXPECT_EQ(state.take(event(EV_SYN, SYN_REPORT, 0)), EvdevState::Outcome::complete);
    EXPECT_EQ(report(state), (Report{0x67, 2, 2, 0,      //
                                     ABS_X, 0xFF, 0x7F,  //
                                     ABS_RX, 0xFF, 0x7F}));
}

TEST(EvdevState, WritesAxesAndPressedButtonsByTheirCodes) {
    EvdevState state = with_axis(-1, 1);
    input_absinfo hat{};
    hat.minimum = -1;
    hat.maximum = 1;
    state.add_axis(ABS_HAT0Y, hat);
    state.take(event(EV_ABS, ABS_HAT0Y, -1));
    state.take(event(EV_KEY, BTN_SOUTH, 1));
    state.take(event(EV_KEY, BTN_TRIGGER_HAPPY5, 1));
    EXPECT_EQ(state.take(event(EV_SYN, SYN_REPORT, 0)), EvdevState::Outcome::complete);
    EXPECT_EQ(report(state), (Report{0x67, 2, 2, 2,     //
                                     0x00, 0x00, 0x00,  //
                                     0x11, 0x01, 0x80,  //
                                     0x30, 0x01, 0xC4, 0x02}));
    state.take(event(EV_KEY, BTN_SOUTH, 0));
    EXPECT_EQ(report(state).at(3), 1);
}

TEST(EvdevState, ShowsAPressThatEndedBeforeTheReportOnce) {
    EvdevState state = with_axis(-1, 1);
    state.take(event(EV_KEY, BTN_SOUTH, 1));
    state.take(event(EV_KEY, BTN_SOUTH, 0));
    EXPECT_EQ(report(state).at(3), 1);
    EXPECT_EQ(report(state).at(3), 0);
}

TEST(EvdevState, SaysWhetherSomethingChanged) {
    EvdevState state = with_axis(-100, 100);
    report(state);
    EXPECT_EQ(report(state).at(1), 0);
    state.take(event(EV_ABS, ABS_X, 0));
    EXPECT_EQ(report(state).at(1), 0) << "the same value";
    state.take(event(EV_ABS, ABS_X, 1));
    EXPECT_EQ(report(state).at(1), 2);
    state.take(event(EV_KEY, BTN_SOUTH, 1));
    EXPECT_EQ(report(state).at(1), 2);
    state.take(event(EV_KEY, BTN_SOUTH, 2));
    EXPECT_EQ(report(state).at(1), 0) << "a key that repeats";
    EXPECT_EQ(report(state, true).at(1), 1);
}

TEST(EvdevState, IgnoresWhatComesBetweenDroppedEventsAndTheNextReport) {
    EvdevState state = with_axis(-100, 100);
    state.take(event(EV_ABS, ABS_X, 50));
    state.take(event(EV_SYN, SYN_DROPPED, 0));
    state.take(event(EV_ABS, ABS_X, -50));
    state.take(event(EV_KEY, BTN_SOUTH, 1));
    EXPECT_EQ(state.take(event(EV_SYN, SYN_REPORT, 0)), EvdevState::Outcome::dropped);
    const Report seen = report(state);
    EXPECT_EQ(position(seen, 0), 16383);
    EXPECT_EQ(seen.at(3), 0);
    EXPECT_EQ(state.take(event(EV_SYN, SYN_REPORT, 0)), EvdevState::Outcome::complete);
}

TEST(EvdevState, KeepsToTheRoomOfAReport) {
    EvdevState state;
    input_absinfo range{};
    range.maximum = 1;
    for (std::uint16_t code = 0; code < 40; ++code) {
        state.add_axis(code, range);
    }
    input_absinfo empty{};
    state.add_axis(ABS_X, empty);
    for (std::uint16_t code = BTN_MISC; code < BTN_MISC + 100; ++code) {
        state.take(event(EV_KEY, code, 1));
    }
    state.take(event(EV_KEY, KEY_A, 1));
    const Report seen = report(state);
    EXPECT_EQ(seen.size(), gamepad_report::kMostBytes);
    EXPECT_EQ(seen.at(2), 16);
    EXPECT_EQ(seen.at(3), 32);
}

}  // namespace
}  // namespace tribus::test::evdev_state_test
