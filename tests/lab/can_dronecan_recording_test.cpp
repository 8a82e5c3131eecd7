#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <fstream>
#include <functional>
#include <set>
#include <span>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "tests/lab/candump.h"
#include "tests/lab/dronecan_ear.h"
#include "tests/lab/recorded_receiver.h"
#include "tests/lab/shell.h"
#include "tests/lab/two_programs.h"
#include "transports/codecs/dronecan/types.h"

/// A recorded 18-channel receiver at the i.Bus input of one program, DroneCAN to another program,
/// SBUS servos there. A third node asks both for their node information, and candump logs the bus.
namespace tribus::test::can_dronecan_recording_test {
namespace {

using nlohmann::json;
using std::chrono::milliseconds;

constexpr dronecan::NodeId kSender = 42;
constexpr dronecan::NodeId kReader = 43;
constexpr dronecan::NodeId kTool = 127;

/// Returns whether `rows` contain all of `wanted` in order. One row may match several of them.
template <class Row, class Wanted, class Same>
testing::AssertionResult in_order(std::span<const Row> rows, const std::vector<Wanted>& wanted,
                                  Same same) {
    std::size_t row = 0;
    for (std::size_t i = 0; i < wanted.size(); ++i) {
        while (row < rows.size() && !same(rows[row], wanted[i])) {
            ++row;
        }
        if (row == rows.size()) {
            return testing::AssertionFailure()
                   << "number " << i << " of " << wanted.size() << " was not recorded there";
        }
    }
    return testing::AssertionSuccess();
}

class RecordedOverDroneCan : public TwoPrograms,
                             public testing::WithParamInterface<std::tuple<bool, Capture>> {
  protected:
    RecordedOverDroneCan() {
        for (const Sticks& sticks : rows_) {
            positions_.push_back(sbus_sight_of(sticks));
        }
    }

    void start() {
        BusJob job{.format = std::get<bool>(GetParam()) ? "protocol = \"dronecan\"\nfd = true"
                                                        : "protocol = \"dronecan\"",
                   .sender_lines = "node_id = " + std::to_string(kSender)};
        job.reader_tables =
            "[dronecan.own]\ninterface = \"vcan0\"\nnode_id = " + std::to_string(kReader) + "\n";
        sender_ = &start_sender(job);
        reader_ = &start_reader(job);
    }
    std::string errors() const { return sender_->errors() + reader_->errors(); }

    /// Returns what the servos see until `done` returns true for a frame.
    template <class Done>
    std::vector<SbusSight> listen_until(Done done) {
        std::vector<SbusSight> seen;
        EXPECT_TRUE(eventually([&] {
            recorded_.send_due();
            bool found = false;
            for (const SbusSight& sight : servos().listen()) {
                seen.push_back(sight);
                found = found || done(sight);
            }
            return found;
        })) << errors();
        return seen;
    }
    std::vector<SbusSight> play_to_the_end() {
        recorded_.start();
        return listen_until([&](const SbusSight& sight) {
            return recorded_.ended() && sight.good() && same_channels(sight, positions_.back());
        });
    }
    std::vector<SbusSight> fall_silent() {
        return listen_until([](const SbusSight& sight) { return sight.failsafe; });
    }
    std::vector<SbusSight> play_until_control() {
        recorded_.start();
        return listen_until([](const SbusSight& sight) { return sight.good(); });
    }
    void ask_who_is_there() {
        RawCan tool("vcan0");
        for (const dronecan::NodeId node : {kSender, kReader}) {
            send(tool, frames_of_transfer({.source = kTool, .destination = node},
                                          dronecan::GetNodeInfo::Request{}));
            EXPECT_TRUE((hear_until<dronecan::GetNodeInfo::Response>(
                tool,
                [&](const dronecan::TransferHead& head, const auto&) {
                    return head.source == node && head.destination == kTool;
                })))
                << errors();
        }
    }
    void end() {
        expect_clean_end(*sender_);
        expect_clean_end(*reader_);
    }

    /// Returns the good frames without repetitions.
    static std::vector<SbusSight> good_positions(const std::vector<SbusSight>& seen) {
        std::vector<SbusSight> good;
        for (const SbusSight& sight : seen) {
            if (sight.good() && (good.empty() || !same_channels(good.back(), sight))) {
                good.push_back(sight);
            }
        }
        return good;
    }

    const std::vector<Sticks> rows_ = recorded_sticks(std::get<Capture>(GetParam()));
    std::vector<SbusSight> positions_;
    VirtualBus bus_;
    Candump candump_{folder(), "vcan0"};
    RecordedReceiver recorded_{receiver(), std::get<Capture>(GetParam())};
    Program* sender_ = nullptr;
    Program* reader_ = nullptr;
};

INSTANTIATE_TEST_SUITE_P(Frames, RecordedOverDroneCan,
                         testing::Combine(testing::Bool(), testing::ValuesIn(captures())),
                         [](const auto& test) {
                             return std::string(std::get<bool>(test.param) ? "Fd" : "Classic") +
                                    capture_name(std::get<Capture>(test.param));
                         });

TEST_P(RecordedOverDroneCan, SticksComeOutInTheirOrderAndNoneThatWasNotRecorded) {
    start();
    const auto positions = good_positions(play_to_the_end());
    EXPECT_TRUE(in_order(std::span<const SbusSight>(positions_), positions, same_channels));
    // The recording has 378 positions, its twin as many or more. Even a machine that is stalled
    // most of the time lets a tenth of them through.
    EXPECT_GT(positions.size(), 37U);
    EXPECT_EQ(servos().strays(), 0U);
    end();
}

TEST_P(RecordedOverDroneCan, EndsInFailsafeAfterTimeoutAndHoldAndComesBackAfterRecover) {
    start();
    play_to_the_end();
    const auto silent_since = recorded_.latest();
    const auto seen = fall_silent();
    const auto failsafe = std::ranges::find_if(seen, &SbusSight::failsafe);
    ASSERT_NE(failsafe, seen.end());
    EXPECT_TRUE(std::all_of(seen.begin(), failsafe, [&](const SbusSight& sight) {
        return same_channels(sight, positions_.back());
    })) << "other sticks than the last ones are held";
    EXPECT_TRUE(std::any_of(seen.begin(), failsafe, [](const SbusSight& sight) {
        return sight.frame_lost;
    })) << "held sticks are not marked";
    Sticks presets(18, 1500);
    presets[0] = 1000;
    presets[2] = 988;
    EXPECT_TRUE(same_channels(*failsafe, sbus_sight_of(presets)));
    // A frame of either program counts for the period after it.
    expect_failsafe_time(failsafe->seen - silent_since, milliseconds(10 + 7));

    const auto back = Clock::now();
    const auto later = play_until_control();
    const auto first_good = std::ranges::find_if(later, &SbusSight::good);
    ASSERT_NE(first_good, later.end());
    EXPECT_GE(first_good->seen - back, kRecover);
    EXPECT_TRUE(
        in_order(std::span<const SbusSight>(positions_), good_positions(later), same_channels));
    end();
}

/// Output of `tribus decode` for a log of candump.
struct Explained {
    std::vector<json> transfers;
    json summary;
};

Explained explained(const std::string& folder, const std::string& log) {
    std::ofstream(folder + "/bus.log") << log;
    const ShellResult decoded =
        run_shell(std::string(TRIBUS_PROGRAM) + " decode --protocol dronecan --format json " +
                  folder + "/bus.log");
    if (decoded.status != 0) {
        ADD_FAILURE() << decoded.output;
        return {};
    }
    Explained all;
    std::istringstream lines(decoded.output);
    for (std::string line; std::getline(lines, line);) {
        json object = json::parse(line);
        if (object.contains("summary")) {
            all.summary = object["summary"];
        } else {
            all.transfers.push_back(std::move(object));
        }
    }
    return all;
}

TEST_P(RecordedOverDroneCan, DecodeFindsAWholeKnownTransferInEveryFrameThatCandumpLogged) {
    start();
    play_to_the_end();
    fall_silent();
    play_until_control();
    ask_who_is_there();
    end();
    const std::string log = candump_.log();
    const auto [transfers, summary] = explained(folder(), log);
    ASSERT_TRUE(summary.is_object());

    const auto logged = static_cast<std::uint64_t>(std::ranges::count(log, '\n'));
    EXPECT_EQ(summary["can_frames"], logged);
    EXPECT_EQ(summary["frames"], transfers.size());
    for (const char* const mishap :
         {"other_can_frames", "repeated_frames", "error_frames", "unanswered"}) {
        EXPECT_EQ(summary[mishap], 0) << mishap;
    }
    for (const auto& [reason, count] : summary["rejected"].items()) {
        EXPECT_EQ(count, 0) << reason;
    }
    std::uint64_t in_transfers = 0;
    for (const json& transfer : transfers) {
        in_transfers += transfer["frames"].get<std::uint64_t>();
        EXPECT_FALSE(transfer["type"].is_null() || transfer.contains("broken")) << transfer;
    }
    EXPECT_EQ(in_transfers, logged);
}

TEST_P(RecordedOverDroneCan, BothNodesSaySoAndAnswerInTheLogThatCarriesTheRecordedSticks) {
    start();
    play_to_the_end();
    ask_who_is_there();
    end();
    std::set<std::pair<std::string, int>> said;
    std::vector<Sticks> carried;
    for (const json& transfer : explained(folder(), candump_.log()).transfers) {
        said.emplace(
            transfer["kind"].get<std::string>() + " " + transfer["type"].get<std::string>(),
            transfer["source"].get<int>());
        if (transfer.contains("channels") && !transfer["failsafe"].get<bool>() &&
            !transfer["frame_lost"].get<bool>()) {
            EXPECT_EQ(transfer["fd"], std::get<bool>(GetParam()));
            carried.push_back(transfer["channels"].get<Sticks>());
        }
    }
    const std::set<std::pair<std::string, int>> wanted{
        {"message dronecan.sensors.rc.RCInput", kSender},
        {"message uavcan.protocol.NodeStatus", kSender},
        {"message uavcan.protocol.NodeStatus", kReader},
        {"request uavcan.protocol.GetNodeInfo", kTool},
        {"response uavcan.protocol.GetNodeInfo", kSender},
        {"response uavcan.protocol.GetNodeInfo", kReader},
    };
    EXPECT_EQ(said, wanted);
    EXPECT_GT(carried.size(), 37U);
    EXPECT_TRUE(in_order(std::span<const Sticks>(rows_), carried, std::equal_to<>()));
}

}  // namespace
}  // namespace tribus::test::can_dronecan_recording_test
