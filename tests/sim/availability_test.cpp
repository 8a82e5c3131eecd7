#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "core/counted.h"
#include "tests/sim/availability_flight.h"
#include "tests/sim/stored_table.h"

/// Availability: an output has control whenever a link is usable, however many frames are marked,
/// missing or not plausible. It is compared with the rule of a flight controller.
namespace tribus::test::availability_test {
namespace {

using namespace availability;

/// So much later than the plain rule control may come.
constexpr Duration kMostLater = 100ms + kPeriod;
/// So many times a frame newer than the timeout was missing before the plain rule gave control.
constexpr std::size_t kExcused = 13;
/// The share of the time in control may be so much lower.
constexpr double kMostLess = 0.001;

Quality share(Sent instead, double share) {
    return [=](std::uint32_t /*number*/, Instant /*at*/, std::mt19937& random) {
        return std::bernoulli_distribution(share)(random) ? instead : Sent::good;
    };
}
/// A jammed hop of 47, as FrSky's receivers mark it.
Quality one_in_47() {
    return [](std::uint32_t number, Instant /*at*/, std::mt19937& /*random*/) {
        return number % 47 == 46 ? Sent::marked : Sent::good;
    };
}
/// ExpressLRS before 3.4 marks each frame for which no new packet has come (its PR 2457).
Quality packets_per_second(int rate, Duration period) {
    return [=](std::uint32_t /*number*/, Instant at, std::mt19937& /*random*/) {
        const Duration each = Duration(1s) / rate;
        const Duration now = at.time_since_epoch();
        return now / each != (now - period) / each ? Sent::good : Sent::marked;
    };
}

constexpr std::array kReceivers{
    // Futaba FASSTest 12CH: quicker than 150 Hz.
    Receiver{"sbus", 6300us, true}, Receiver{"sbus", 7ms, true},
    Receiver{"sbus", 9ms, true},    Receiver{"sbus", 14ms, true},
    Receiver{"ibus", 7700us},       Receiver{"ibus", 4ms},
    Receiver{"crsf", 4ms},          Receiver{"crsf", 20ms},
    Receiver{"sumd", 10ms},         Receiver{"ghst", 4ms, false, "[1000, 2000]", 2010},
};
constexpr const Receiver& kOfModes = kReceivers[2];

std::vector<std::pair<std::string, Quality>> qualities(const Receiver& receiver) {
    std::vector<std::pair<std::string, Quality>> all{{"all good", share(Sent::good, 0)}};
    constexpr std::array kShares{2, 5, 10, 15, 20, 30, 50};
    const auto add = [&](std::string_view name, Sent instead) {
        for (const int percent : kShares) {
            all.emplace_back(fmt::format("{} % {}", percent, name),
                             share(instead, percent / 100.0));
        }
    };
    if (receiver.marks) {
        add("marked", Sent::marked);
        all.emplace_back("one in 47 marked", one_in_47());
        for (const int rate : {25, 50, 100, 150}) {
            all.emplace_back(fmt::format("ExpressLRS at {} Hz", rate),
                             packets_per_second(rate, receiver.period));
        }
    }
    add("missing", Sent::missing);
    add("implausible", Sent::implausible);
    return all;
}

/// The first receiver has `quality`, the other ones another one.
Case of_mode(std::string_view mode, std::size_t receivers, const std::string& name,
             const Quality& quality) {
    const std::array others{packets_per_second(50, kOfModes.period), share(Sent::missing, 0.3)};
    Case one{kOfModes, name, {quality}, std::string(mode)};
    one.of_inputs.insert(one.of_inputs.end(), others.begin(),
                         others.begin() + static_cast<std::ptrdiff_t>(receivers - 1));
    return one;
}

std::vector<Case> cases() {
    std::vector<Case> all;
    for (const Receiver& receiver : kReceivers) {
        for (const auto& [name, quality] : qualities(receiver)) {
            all.push_back({receiver, name, {quality}});
        }
    }
    for (const auto& [mode, receivers] : {std::pair("sticky", std::size_t{1}),
                                          {"freshest", 1},
                                          {"priority", 2},
                                          {"sticky", 2},
                                          {"freshest", 2},
                                          {"median", 3}}) {
        for (const auto& [name, quality] : qualities(kOfModes)) {
            all.push_back(of_mode(mode, receivers, name, quality));
        }
    }
    return all;
}

std::string seconds(const std::vector<std::optional<Duration>>& durations,
                    const std::vector<bool>& always_fresh) {
    std::string text;
    for (std::size_t i = 0; i < durations.size(); ++i) {
        text += durations[i]
                    ? fmt::format(" {:5.2f}", std::chrono::duration<double>(*durations[i]).count())
                    : "     -";
        text += always_fresh[i] ? " " : "*";
    }
    return text;
}

std::string title_of(const Case& one) {
    std::string title =
        fmt::format("\n{} each {:.1f} ms", one.receiver.protocol,
                    std::chrono::duration<double, std::milli>(one.receiver.period).count());
    if (one.of_inputs.size() > 1 || one.mode != "priority") {
        title += fmt::format(", {}, {}", counted(one.of_inputs.size(), "receiver"), one.mode);
    }
    return title + "\n";
}

std::string row_of(const Case& one, const Availability& availability) {
    std::string row = fmt::format(
        "{:<20}{} {:6.2f} % |{} {:6.2f} %", one.quality,
        seconds(availability.to_control, availability.always_fresh), 100 * availability.share,
        seconds(availability.to_control_by_rule, std::vector<bool>(1 + kOutages.size(), true)),
        100 * availability.share_by_rule);
    if (one.of_inputs.size() > 1) {
        row += fmt::format("  {:3.0f} %", 100 * availability.share_of_first);
    }
    return row + "\n";
}

/// Returns how often a frame newer than the timeout was missing before the plain rule gave control.
std::size_t expect_no_later_than_the_rule(const Availability& availability) {
    std::size_t excused = 0;
    EXPECT_GE(availability.share, availability.share_by_rule - kMostLess);
    for (std::size_t i = 0; i < availability.to_control.size(); ++i) {
        const auto expect_within = [&](const std::optional<Duration>& most) {
            const auto& control = availability.to_control[i];
            EXPECT_TRUE(!most || (control && *control <= *most + kMostLater)) << "event " << i;
        };
        expect_within(availability.to_recovery[i]);
        if (availability.always_fresh[i]) {
            expect_within(availability.to_control_by_rule[i]);
        }
        excused += availability.always_fresh[i] ? 0U : 1U;
    }
    return excused;
}

TEST(Availability, IsThatOfAFlightControllerOrBetter) {
    std::string table =
        "# Time in seconds until an SBUS output has control, after the start and after outages of\n"
        "# 0.2, 0.5, 1 and 3 s, and the share of the time in control in which a frame newer than\n"
        "# the timeout (100 ms) existed; first of tribus (recover 500 ms), then of the plain rule\n"
        "# of a flight controller (up after 500 ms without a pause of 150 ms between valid\n"
        "# frames). *: for a moment there was no such frame before the rule gave control; then it\n"
        "# comes at most 0.61 s after that moment. Of several receivers the first one has the\n"
        "# quality of the row and all outages. The second one is an ExpressLRS at 50 Hz, of the\n"
        "# third one 30 % are missing; both have no outages of 0.5 and 3 s. Last: the share of "
        "the\n"
        "# time in control in which the first receiver has it.\n";
    std::string before;
    std::size_t excused = 0;
    for (const Case& one : cases()) {
        const Availability availability = ReceivedFlight(one).availability();
        const std::string title = title_of(one);
        table += title == before ? "" : title;
        before = title;
        table += row_of(one, availability);
        SCOPED_TRACE(title + one.quality);
        excused += expect_no_later_than_the_rule(availability);
        EXPECT_EQ(availability.implausible_seen, availability.implausible_sent);
    }
    EXPECT_EQ(excused, kExcused);
    expect_stored("availability.txt", table);
}

}  // namespace
}  // namespace tribus::test::availability_test
