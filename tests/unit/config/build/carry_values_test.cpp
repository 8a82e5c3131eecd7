#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/carry_over.h"
#include "config/schema/value_catalog.h"
#include "tests/unit/config/main_job.h"

/// Named values, buses and messages that continue when a configuration replaces another.
namespace tribus::test::carry_values_test {
namespace {

using Froms = std::vector<CarriedFrom>;

std::string bus(const std::string& name, const std::string& more = "") {
    return "[sensor_bus." + name + "]\nrole = \"receiver\"\ndevice = \"/dev/tty" + name + "\"\n" +
           more;
}
std::string message(const std::string& name, const std::string& more = "") {
    return "[values." + name +
           "]\ninterface = \"can0\"\ndronecan = \"uavcan.equipment.power.BatteryInfo\"\n" + more;
}

std::string dbc_message(const std::string& file, const std::string& message) {
    return "[values.pack]\ninterface = \"can0\"\ndbc = \"" TRIBUS_SOURCE_DIR "/config/examples/" +
           file + ".dbc\"\nmessage = \"" + message + "\"\n";
}

/// A reload from the nine lines and `running` to the nine lines and `fresh`.
struct Reload {
    Reload(const std::string& fresh, const std::string& running)
        : before(loaded(main_job_with(10, running))),
          after(loaded(main_job_with(10, fresh))),
          carry(plan_carry_over(before, after).values) {}
    /// The name of the value from which that one takes over; empty if there is none.
    std::string source_of(std::string_view name) const {
        const auto fresh = catalog_of(value_sources(after));
        const auto running = catalog_of(value_sources(before));
        EXPECT_EQ(carry.values.size(), fresh.settings.values.size());
        const CarriedFrom from = carry.values.at(fresh.find(name).value());
        return from ? running.settings.values.at(*from).name : "";
    }
    Configuration before;
    Configuration after;
    ValueCarry carry;
};

TEST(CarriedValues, AreThoseOfBusesAndMessagesThatStay) {
    const Reload reload(bus("S") + bus("T") + message("new") + message("pack"),
                        message("pack") + bus("T"));
    EXPECT_EQ(reload.carry.buses, (Froms{std::nullopt, 0}));
    EXPECT_EQ(reload.carry.messages, (Froms{std::nullopt, 0}));
    for (const std::string name : {"T.1", "T.15.raw", "T.fuel", "pack.voltage", "pack.current"}) {
        EXPECT_EQ(reload.source_of(name), name);
    }
    for (const std::string name :
         {"S.1", "new.voltage", "input.receiver.good", "output.servos.failsafe", "machine.load"}) {
        EXPECT_EQ(reload.source_of(name), "") << name;
    }
}

TEST(CarriedValues, ComeFromThePlaceThatTheirSourceHad) {
    const Reload reload(bus("T") + bus("S") + message("b", "node = 7\n") + message("a"),
                        bus("S") + bus("T") + message("a") + message("b", "node = 7\n"));
    EXPECT_EQ(reload.carry.buses, (Froms{1, 0}));
    EXPECT_EQ(reload.carry.messages, (Froms{1, 0}));
}

TEST(CarriedValues, AreNoneOfASourceThatChanged) {
    const Reload reload(bus("S", "probe_every = 7\n") + message("pack", "node = 7\n"),
                        bus("S") + message("pack"));
    EXPECT_EQ(reload.carry.buses, Froms{std::nullopt});
    EXPECT_EQ(reload.carry.messages, Froms{std::nullopt});
    EXPECT_EQ(reload.source_of("S.1"), "");
    EXPECT_EQ(reload.source_of("pack.voltage"), "");
}

TEST(CarriedValues, AreThoseOfTheSameMessageOfTheSameDbcFile) {
    const auto carried = [](const std::string& fresh, const std::string& running) {
        return Reload(fresh + bus("T"), running + bus("T")).carry.messages;
    };
    const std::string channels = dbc_message("rc-box", "Channels1to4");
    EXPECT_EQ(carried(channels, channels), Froms{0});
    EXPECT_EQ(carried(channels, dbc_message("rc-box", "Channels5to8")), Froms{std::nullopt});
    EXPECT_EQ(carried(channels, dbc_message("telemetry", "Battery")), Froms{std::nullopt});
}

TEST(CarriedValues, AreNotMistakenForThoseOfALongerName) {
    const Reload reload(bus("S") + bus("S1", "probe_every = 7\n"), bus("S") + bus("S1"));
    EXPECT_EQ(reload.source_of("S.1"), "S.1");
    EXPECT_EQ(reload.source_of("S1.1"), "");
}

TEST(CarriedValues, AreNoneWhereNobodyNeededThem) {
    const Reload without_before(bus("S") + message("pack"), message("pack"));
    EXPECT_EQ(without_before.carry.buses, Froms{std::nullopt});
    EXPECT_EQ(without_before.carry.messages, Froms{std::nullopt});
    EXPECT_EQ(without_before.source_of("pack.voltage"), "");
    const Reload without_after(message("pack"), bus("S") + message("pack"));
    EXPECT_EQ(without_after.carry.messages, Froms{std::nullopt});
    EXPECT_EQ(without_after.source_of("pack.voltage"), "");
}

TEST(CarriedValues, AreNoneOfABusWhereATypeOfSensorChanged) {
    const std::string lift = "[sensor_type.lift]\nid = 133\n";
    const Reload reload(bus("S") + message("pack") + lift, bus("S") + message("pack"));
    EXPECT_EQ(reload.carry.buses, Froms{std::nullopt});
    EXPECT_EQ(reload.carry.messages, Froms{0});
    EXPECT_EQ(reload.source_of("S.1"), "");
    EXPECT_EQ(reload.source_of("pack.voltage"), "pack.voltage");
}

}  // namespace
}  // namespace tribus::test::carry_values_test
