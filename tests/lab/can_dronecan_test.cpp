#include <csignal>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/dronecan_ear.h"
#include "tests/lab/two_programs.h"
#include "transports/codecs/dronecan/types.h"

/// DroneCAN on a virtual bus: built programs, and nodes that the tests simulate.
namespace tribus::test::can_dronecan_test {
namespace {

using namespace dronecan;
using std::chrono::milliseconds;

const BusJob kJob{.format = "protocol = \"dronecan\"", .sender_lines = "node_id = 42"};
const BusJob kFdJob{.format = "protocol = \"dronecan\"\nfd = true", .sender_lines = "node_id = 42"};

class DroneCan : public TwoPrograms {};

TEST_F(DroneCan, EndsInFailsafeWhenTheSenderIsKilledAndComesBack) {
    const VirtualBus bus;
    Program* sender = &start_sender(kJob);
    Program& reader = start_reader(kJob);
    expect_times(expect_failsafe_and_recovery(
        "DroneCAN sender killed, started again",
        [&] {
            sender->signal(SIGKILL);
            sender->end();
        },
        [&] { sender = &start_sender(kJob); }));
    expect_clean_end(*sender);
    expect_clean_end(reader);
}

TEST_F(DroneCan, TellsTheFailsafeOfTheReceiver) {
    const VirtualBus bus;
    Program& sender = start_sender(kJob);
    Program& reader = start_reader(kJob);
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    // The i.Bus input gets no more frames.
    EXPECT_TRUE(eventually([&] {
        const auto seen = servos().listen();
        return std::ranges::any_of(seen, [](const SbusSight& sight) { return sight.failsafe; });
    }));
    RawCan listener("vcan0");
    EXPECT_TRUE(hear_until<RcInput>(listener, [](const TransferHead&, const RcInput& message) {
        return message.status == RcInput::kFailsafe && message.quality == 0;
    }));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(DroneCan, FallsSilentWhileAnotherNodeHasItsId) {
    const VirtualBus bus;
    Program& sender = start_sender(kJob);
    Program& reader = start_reader(kJob);
    ASSERT_TRUE(carry_until_control()) << sender.errors() << reader.errors();
    RawCan other("vcan0");
    send(other, frames_of_message(NodeStatus{}, 42, 0));
    EXPECT_TRUE(carry_until_failsafe());
    EXPECT_NE(sender.errors().find("another DroneCAN node has the id 42 too"), std::string::npos)
        << sender.errors();
    EXPECT_TRUE(carry_until_control()) << "no control after 5 s of silence";
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(DroneCan, TellsOfANodeWithItsIdOnceThoughItIsReloaded) {
    const VirtualBus bus;
    Program& sender = start_sender(kJob);
    RawCan other("vcan0");
    send(other, frames_of_message(NodeStatus{}, 42, 0));
    EXPECT_TRUE(sender.says("another DroneCAN node has the id 42 too"));
    sender.signal(SIGHUP);
    EXPECT_TRUE(sender.says("reloaded"));
    EXPECT_TRUE(sender.says("this program is DroneCAN node 42")) << "not back after 5 s of silence";
    EXPECT_EQ(count_of("has the id 42 too", sender.errors()), 1U) << sender.errors();
    expect_clean_end(sender);
}

TEST_F(DroneCan, SaysThatItIsThereAndAnswersWhoItIs) {
    const VirtualBus bus;
    RawCan tool("vcan0");
    Program& sender = start_sender(kJob);
    EXPECT_TRUE(hear_until<NodeStatus>(tool, [](const TransferHead& head, const NodeStatus&) {
        return head.source == 42;
    })) << sender.errors();
    send(tool, frames_of_transfer({.source = 127, .destination = 42, .transfer_id = 3},
                                  GetNodeInfo::Request{}));
    EXPECT_TRUE(hear_until<GetNodeInfo::Response>(tool, [](const TransferHead& head,
                                                           const GetNodeInfo::Response& info) {
        return head.destination == 127 && head.transfer_id == 3 &&
               info.name.view() == "org.tribus" && info.hardware_version.unique_id != UniqueId{};
    }));
    expect_clean_end(sender);
}

/// Returns the node id that a program reports as its own.
std::optional<NodeId> own_id(const Program& program) {
    const std::string errors = program.errors();
    const std::string words = "this program is DroneCAN node ";
    const std::size_t at = errors.find(words);
    return at == std::string::npos
               ? std::nullopt
               : std::optional(static_cast<NodeId>(std::stoi(errors.substr(at + words.size()))));
}

/// Simulates the allocator: assigns ids from `next` on, one for each unique id
/// (docs/protocols/can.md, "DroneCAN: nodes").
class Allocator {
  public:
    Allocator(const std::string& interface, NodeId next) : bus_(interface), next_(next) {}

    /// Answers the requests that have come. Returns the ids assigned so far.
    const std::map<std::vector<std::uint8_t>, NodeId>& serve() {
        for (const CanSight& sight : bus_.receive_all()) {
            const auto heard = ear_.take(sight.frame);
            if (heard && heard->first.source == kNobody) {
                answer(heard->second);
            }
        }
        return given_;
    }

  private:
    void answer(const Allocation& request) {
        if (request.first_part_of_unique_id) {
            known_.clear();
        }
        known_.insert(known_.end(), request.unique_id.begin(), request.unique_id.end());
        Allocation response;
        for (const std::uint8_t byte : known_) {
            response.unique_id.push_back(byte);
        }
        if (known_.size() == 16) {
            const auto [given, fresh] = given_.try_emplace(known_, next_);
            next_ = static_cast<NodeId>(next_ + (fresh ? 1 : 0));
            response.node_id = given->second;
        }
        send(bus_, frames_of_message(response, 1, transfer_id_));
        transfer_id_ = (transfer_id_ + 1) & kMostTransferId;
    }

    RawCan bus_;
    Ear<Allocation> ear_;
    NodeId next_;
    std::uint8_t transfer_id_ = 0;
    std::vector<std::uint8_t> known_;
    std::map<std::vector<std::uint8_t>, NodeId> given_;
};

class DroneCanAllocation : public TwoPrograms, public testing::WithParamInterface<bool> {};

INSTANTIATE_TEST_SUITE_P(Frames, DroneCanAllocation, testing::Bool(),
                         [](const auto& test) { return test.param ? "Fd" : "Classic"; });

TEST_P(DroneCanAllocation, TwoNodesGetIdsFromAnAllocatorAndRcGoesFromOneToTheOther) {
    const VirtualBus bus;
    BusJob job{.format = GetParam() ? kFdJob.format : kJob.format};
    job.sender_tables = "[dronecan.own]\ninterface = \"vcan0\"\ndynamic = true\nnode_id = 30\n";
    job.reader_tables = "[dronecan.own]\ninterface = \"vcan0\"\ndynamic = true\n";
    Allocator allocator("vcan0", 60);
    Program& sender = start_sender(job);
    Program& reader = start_reader(job);
    EXPECT_TRUE(carry_until([&](const SbusSight& sight) {
        return allocator.serve().size() == 2 && own_id(sender) && own_id(reader) && sight.good();
    })) << sender.errors()
        << reader.errors();
    EXPECT_EQ((std::set{own_id(sender), own_id(reader)}),
              (std::set<std::optional<NodeId>>{60, 61}));
    RawCan listener("vcan0");
    EXPECT_TRUE(eventually([&] {
        const auto heard = listener.receive_all();
        return std::ranges::any_of(heard, [&](const CanSight& sight) {
            const auto head = head_of(sight.frame);
            return head && head->kind == TransferKind::message &&
                   head->data_type_id == RcInput::kId && head->source == own_id(sender) &&
                   sight.frame.fd == GetParam();
        });
    }));
    expect_clean_end(sender);
    expect_clean_end(reader);
}

TEST_F(DroneCan, CommandsOfAnAutopilotMoveServosAndTheirEndIsAFailsafe) {
    const VirtualBus bus;
    RawCan autopilot("vcan0");
    Program& program = run(write_config(R"([input.autopilot]
protocol = "dronecan"
interface = "vcan0"
carries = "servos"
timeout = "400ms"
[output.servos]
protocol = "sbus"
device = "@servos"
period = "7ms"
[pipeline.main]
from = "autopilot"
to = "servos"
[pipeline.main.failsafe]
hold = "300ms"
preset = { 1 = 1000, 3 = 988, other = 1500 }
recover = "300ms"
)"));
    ArrayCommand message;
    message.commands.push_back({.actuator_id = 1, .command_value = 0.5F});
    std::uint8_t transfer_id = 0;
    auto next = Clock::now();
    Clock::time_point last_sent{};
    const auto wanted = sbus_raw(1750);
    EXPECT_TRUE(eventually([&] {
        if (Clock::now() >= next) {
            next += milliseconds(20);
            last_sent = Clock::now();
            send(autopilot, frames_of_message(message, 10, transfer_id));
            transfer_id = (transfer_id + 1) & kMostTransferId;
        }
        const auto seen = servos().listen();
        return std::ranges::any_of(
            seen, [&](const SbusSight& sight) { return sight.good() && sight.raw[0] == wanted; });
    })) << program.errors();
    std::optional<Clock::duration> to_failsafe;
    EXPECT_TRUE(eventually([&] {
        for (const SbusSight& sight : servos().listen()) {
            if (sight.failsafe && !to_failsafe) {
                to_failsafe = sight.seen - last_sent;
            }
        }
        return to_failsafe.has_value();
    })) << program.errors();
    ASSERT_TRUE(to_failsafe);
    expect_failsafe_time(*to_failsafe, milliseconds(7));
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::can_dronecan_test
