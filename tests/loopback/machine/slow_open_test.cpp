#include <atomic>
#include <chrono>
#include <memory>
#include <string>
#include <thread>

#include <gtest/gtest.h>

#include "app/appliance/appliance.h"
#include "config/load.h"
#include "pipelines/realtime/clock.h"
#include "tests/support/log_in_memory.h"
#include "transports/links/medium.h"

/// A port whose opening takes long and fails, such as one that is measured.
namespace tribus::test::slow_open_test {
namespace {

using namespace std::chrono_literals;

constexpr Duration kOpening = 100ms;
std::atomic<bool> missing = true;
std::atomic<int> opened = 0;

const Medium kSlowPorts{
    .name = "a slow port",
    .place = {.key = "device"},
    .place_absent = "",
    .is_missing = [](const std::string& /*place*/) { return missing.load(); },
    .open = [](const std::string& /*place*/,
               const LinkUse& /*use*/) -> tl::expected<std::unique_ptr<Link>, std::string> {
        ++opened;
        std::this_thread::sleep_for(missing ? 0ms : kOpening);
        return tl::unexpected(std::string("no rate fits"));
    }};

/// The main thread has other things to do: sockets, log, watchdog.
TEST(SlowOpen, IsTriedATenthOfTheTimeAtMost) {
    const LogInMemory log{"%v"};
    Configuration configuration =
        load_configuration(
            "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/slow\"\n"
            "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/none\"\n"
            "[pipeline.main]\nfrom = \"receiver\"\nto = \"servos\"\n"
            "[runtime]\nrealtime = \"off\"\n",
            "test.toml")
            .value();
    configuration.inputs[0].port.medium = &kSlowPorts;
    const auto appliance =
        Appliance::start(std::move(configuration), Appliance::MissingDevices::wait_for).value();
    missing = false;
    opened = 0;
    const Instant begin = monotonic_now();
    while (monotonic_now() - begin < 15 * kOpening) {
        appliance->look_after_devices(monotonic_now());
        std::this_thread::sleep_for(1ms);
    }
    EXPECT_GE(opened, 1);
    EXPECT_LE(opened, 2);
}

}  // namespace
}  // namespace tribus::test::slow_open_test
