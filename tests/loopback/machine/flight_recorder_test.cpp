#include "app/recorder/flight_recorder.h"

#include <sys/resource.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "config/load.h"
#include "tests/support/seen_within.h"
#include "tests/support/temporary_folder.h"

namespace tribus::test::flight_recorder_test {
namespace {

using namespace std::chrono_literals;

constexpr Instant kNow{10s};
constexpr Duration kWallNow = 1'795'348'805s;

/// While this object exists, no memory can be allocated.
class NoMemory {
  public:
    NoMemory() {
        ::getrlimit(RLIMIT_AS, &before_);
        const rlimit none{.rlim_cur = 1, .rlim_max = before_.rlim_max};
        ::setrlimit(RLIMIT_AS, &none);
    }
    NoMemory(const NoMemory&) = delete;
    NoMemory& operator=(const NoMemory&) = delete;
    ~NoMemory() { ::setrlimit(RLIMIT_AS, &before_); }

  private:
    rlimit before_{};
};

class FlightRecorderOf : public testing::Test {
  protected:
    FlightRecorderOf() {
        const auto text = fmt::format(
            "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"/dev/receiver\"\n"
            "[output.servos]\nprotocol = \"sbus\"\ndevice = \"/dev/servos\"\n"
            "[pipeline.main]\nfrom = [\"receiver\"]\nto = [\"servos\"]\n"
            "[recorder]\nmemory = 65536\ndirectory = \"{}\"\n",
            (folder_.path() / "recordings").string());
        configuration_ = load_configuration(text, "test.toml").value();
        recorder_ = FlightRecorder::make(configuration_).value();
        ports_ = plan_ports(configuration_);
    }
    void take_ring(std::size_t port) {
        ports_[port].wiring.capture = recorder_->ring_for(ports_[port], *configuration_.recorder);
    }
    /// Requests a recording and returns the answer.
    std::string ask() {
        std::string answer = recorder_->answer({}, kNow, kWallNow);
        const std::vector<std::string> number{"1"};
        EXPECT_TRUE(seen_within([&] {
            answer = recorder_->answer(number, kNow, kWallNow);
            return answer.find("\"writing\"") == std::string::npos;
        }));
        return answer;
    }

    TemporaryFolder folder_;
    Configuration configuration_;
    std::vector<PortPlan> ports_;
    std::unique_ptr<FlightRecorder> recorder_;
};

TEST_F(FlightRecorderOf, PortsWithoutMemoryFailsAndSaysWhy) {
    {
        const NoMemory none;
        take_ring(0);
        take_ring(1);
    }
    recorder_->record_ports(configuration_, ports_, kNow);
    const std::string answer = ask();
    EXPECT_NE(answer.find("\"state\":\"failed\""), std::string::npos) << answer;
    EXPECT_NE(answer.find("no port is recorded (/dev/receiver: cannot get memory: "),
              std::string::npos)
        << answer;
}

TEST_F(FlightRecorderOf, OnePortWithMemoryNamesTheOtherAndNoFileOfIt) {
    {
        const NoMemory none;
        take_ring(0);
    }
    take_ring(1);
    recorder_->record_ports(configuration_, ports_, kNow);
    const std::string answer = ask();
    ASSERT_NE(answer.find("\"state\":\"written\""), std::string::npos) << answer;
    const auto recordings = std::filesystem::directory_iterator(folder_.path() / "recordings");
    const std::filesystem::path folder = recordings->path();
    std::ifstream file(folder / "README.txt");
    const std::string told{std::istreambuf_iterator<char>(file), {}};
    EXPECT_NE(told.find("not recorded: /dev/receiver: cannot get memory: "), std::string::npos)
        << told;
    EXPECT_EQ(told.find("input-receiver.txt"), std::string::npos) << told;
    EXPECT_NE(told.find("output-servos.txt"), std::string::npos) << told;
}

}  // namespace
}  // namespace tribus::test::flight_recorder_test
