#include "config/schema/value_catalog.h"

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "tests/unit/config/main_job.h"

namespace tribus::test::value_catalog_test {
namespace {

using Texts = std::vector<std::string>;

const std::string kConstant = "[values.cells]\nconstant = 6\nunit = \"V\"\n";
const std::string kMessage =
    "[values.pack]\ninterface = \"can0\"\ndronecan = \"uavcan.equipment.power.CircuitStatus\"\n"
    "signals = { u = \"voltage\" }\n";
const std::string kReceiver =
    "[sensor_bus.probes]\nrole = \"receiver\"\ndevice = \"/dev/ttyS\"\ntimeout = \"4s\"\n";
const std::string kSensor =
    "[sensor_bus.own]\nrole = \"sensor\"\ndevice = \"/dev/ttyT\"\n"
    "[[sensor_bus.own.sensor]]\ntype = \"external_voltage\"\nvalue = \"cells\"\n";

/// The nine lines and more. The catalog refers to it.
struct Job {
    explicit Job(const std::string& more)
        : configuration(loaded(main_job_with(10, more))),
          catalog(catalog_of(value_sources(configuration))) {}
    /// `NAME UNIT MILLISECONDS` of so many values from that one on.
    Texts values(std::string_view first, std::size_t count) const {
        Texts shown;
        for (std::size_t i = catalog.find(first).value(); shown.size() < count; ++i) {
            const NamedValue& value = catalog.settings.values.at(i);
            shown.push_back(fmt::format("{} {} {}", value.name, value.unit,
                                        value.lasts == kForever
                                            ? "for ever"
                                            : std::to_string(value.lasts / Duration(1'000'000))));
        }
        return shown;
    }
    std::string name(std::size_t value) const { return catalog.settings.values.at(value).name; }

    Configuration configuration;
    ValueCatalog catalog;
};

TEST(CatalogOfValues, HasTheFactsOfInputsOutputsAndTheMachineInTheirOrder) {
    const Job job("");
    EXPECT_EQ(job.catalog.settings.values.size(), 10U + 18U + 4U + 18U + 6U);
    EXPECT_EQ(job.catalog.find("input.receiver.frame_rate"), 0U);
    EXPECT_EQ(
        job.values("input.receiver.frame_rate", 11),
        (Texts{"input.receiver.frame_rate Hz 500", "input.receiver.loss_ratio % 500",
               "input.receiver.age ms 500", "input.receiver.good  500", "input.receiver.cause  500",
               "input.receiver.link_quality % 500", "input.receiver.rssi dBm 500",
               "input.receiver.snr dB 500", "input.receiver.power mW 500",
               "input.receiver.mode  500", "input.receiver.channel.1 us 500"}));
    EXPECT_EQ(job.values("input.receiver.channel.18", 6),
              (Texts{"input.receiver.channel.18 us 500", "output.servos.frame_rate Hz 500",
                     "output.servos.failsafe  500", "output.servos.holding  500",
                     "output.servos.cannot_send  500", "output.servos.channel.1 us 500"}));
    EXPECT_EQ(job.values("output.servos.channel.18", 7),
              (Texts{"output.servos.channel.18 us 500", "machine.temperature degC 5000",
                     "machine.load % 5000", "machine.memory % 5000", "machine.supply V 5000",
                     "machine.undervoltage  5000", "machine.uptime s 5000"}));
}

TEST(CatalogOfValues, SaysWhichFactEachOfThemIs) {
    const Job job(
        "[output.second]\nprotocol = \"ibus\"\ndevice = \"/dev/ttyC\"\n"
        "[pipeline.b]\nfrom = \"receiver\"\nto = \"second\"\n");
    const auto& health = job.catalog.settings.health;
    ASSERT_EQ(health.size(), 10U + 2U * 4U);
    for (std::size_t i = 0; i < 10; ++i) {
        EXPECT_EQ(health[i].index, 0U);
        EXPECT_EQ(std::get<InputFact>(health[i].fact), static_cast<InputFact>(i));
    }
    EXPECT_EQ(job.name(health[2].value), "input.receiver.age");
    EXPECT_EQ(job.name(health[11].value), "output.servos.failsafe");
    EXPECT_EQ(std::get<OutputFact>(health[11].fact), OutputFact::failsafe);
    EXPECT_EQ(job.name(health[17].value), "output.second.cannot_send");
    EXPECT_EQ(std::get<OutputFact>(health[17].fact), OutputFact::cannot_send);
    EXPECT_EQ(health[17].index, 1U);
    EXPECT_EQ(job.name(job.catalog.settings.machine.at(1)), "machine.load");
}

TEST(CatalogOfValues, SaysWhichChannelEachOfThemIs) {
    const auto& channels = Job("").catalog.settings.channels;
    ASSERT_EQ(channels.size(), 36U);
    EXPECT_FALSE(channels[17].of_output);
    EXPECT_EQ(channels[17].channel, 17U);
    EXPECT_TRUE(channels[18].of_output);
    EXPECT_EQ(channels[18].channel, 0U);
    EXPECT_EQ(channels[18].index, 0U);
    EXPECT_EQ(Job("").name(channels[18].value), "output.servos.channel.1");
}

TEST(CatalogOfValues, HasConstantsForEver) {
    const Job job(kMessage + kConstant);
    EXPECT_EQ(job.values("cells", 1), Texts{"cells V for ever"});
    ASSERT_EQ(job.catalog.settings.constants.size(), 1U);
    EXPECT_EQ(job.catalog.settings.constants[0].number, 6);
    EXPECT_EQ(job.name(job.catalog.settings.constants[0].value), "cells");
}

TEST(CatalogOfValues, HasTheValuesOfAMessageByTheirOwnNames) {
    const Job job(kConstant + kMessage);
    EXPECT_EQ(job.values("cells", 5),
              (Texts{"cells V for ever", "pack.circuit_id  3000", "pack.u V 3000",
                     "pack.current A 3000", "pack.error_flags  3000"}));
    EXPECT_EQ(job.catalog.find("pack.voltage"), std::nullopt);
    ASSERT_EQ(job.catalog.messages.size(), 1U);
    EXPECT_EQ(job.catalog.messages[0].config,
              &std::get<ValueMessageConfig>(job.configuration.values[1].source));
    EXPECT_EQ(job.catalog.messages[0].values,
              (std::vector<std::optional<std::size_t>>{1, 2, 3, 4}));
}

TEST(CatalogOfValues, HasTheReadingsOfABusByAddressAndByType) {
    const Job job(kReceiver);
    EXPECT_EQ(job.values("probes.1", 3),
              (Texts{"probes.1  4000", "probes.1.raw  4000", "probes.2  4000"}));
    EXPECT_EQ(job.values("probes.15.raw", 3),
              (Texts{"probes.15.raw  4000", "probes.internal_voltage V 4000",
                     "probes.temperature degC 4000"}));
    EXPECT_EQ(job.values("probes.gps_status.fix", 2),
              (Texts{"probes.gps_status.fix  4000", "probes.gps_status.satellites  4000"}));
    EXPECT_EQ(job.catalog.find("probes.16"), std::nullopt);
    const auto& readings = job.catalog.readings.at(0);
    EXPECT_EQ(job.name(readings.by_address[0].raw), "probes.1.raw");
    EXPECT_EQ(job.name(readings.by_address[14].fields.at(0)), "probes.15");
    EXPECT_EQ(readings.by_type.at(3).type, 3);
    EXPECT_EQ(job.name(readings.by_type[3].fields.at(0)), "probes.external_voltage");
    EXPECT_EQ(job.name(readings.by_type[11].fields.at(1)), "probes.gps_status.satellites");
}

TEST(CatalogOfValues, HasNoReadingsOfABusOnWhichItIsTheSensors) {
    const Job job(kConstant + kSensor + kReceiver);
    ASSERT_EQ(job.catalog.readings.size(), 2U);
    EXPECT_TRUE(job.catalog.readings[0].by_type.empty());
    EXPECT_EQ(job.catalog.find("own.1"), std::nullopt);
    EXPECT_FALSE(job.catalog.readings[1].by_type.empty());
}

TEST(NamedValues, AreNeededWhereABusOrAnOutputUsesThem) {
    const auto needed = [](const std::string& more) {
        return needs_values(loaded(main_job_with(10, more)));
    };
    EXPECT_FALSE(needed(""));
    EXPECT_FALSE(needed(kConstant + kMessage));
    EXPECT_TRUE(needed(kReceiver));
    const std::string telemetry =
        "[output.o]\nprotocol = \"crsf-telemetry\"\ndevice = \"/dev/ttyC\"\n";
    EXPECT_TRUE(needed(kConstant + telemetry + "battery = { voltage = \"cells\" }\n"));
    const std::string dronecan =
        "[output.bus]\nprotocol = \"dronecan\"\ninterface = \"can1\"\nnode_id = 42\n"
        "[pipeline.b]\nfrom = \"receiver\"\nto = \"bus\"\n";
    EXPECT_FALSE(needed(dronecan)) << "it could, but names none";
}

}  // namespace
}  // namespace tribus::test::value_catalog_test
