#include "pipelines/dronecan/node.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "tests/support/dronecan_frames.h"

namespace tribus::dronecan::node_test {
namespace {

using namespace test;
using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr UniqueId kUniqueId{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16};
constexpr NodeId kTool = 127;

NodeSettings node_42() {
    NodeSettings settings;
    settings.id = 42;
    settings.unique_id = kUniqueId;
    settings.name = "org.tribus";
    settings.version_minor = 1;
    settings.parameters = {
        {.name = "uavcan.node_id", .value = 42, .at_start = 42, .least = 0, .most = 127},
        {.name = "uavcan.pubp-RCInput",
         .value = 10000,
         .at_start = 10000,
         .least = 10000,
         .most = 1000000,
         .output = 3}};
    return settings;
}

/// A node on a bus that accepts everything at once.
class NodeOnBus {
  public:
    explicit NodeOnBus(NodeSettings settings) : node_(std::move(settings)) { node_.start(now_); }

    Node& node() { return node_; }
    Instant now() const { return now_; }

    /// Lets time pass. Returns everything that the node sends.
    std::vector<CanFrame> run(Duration length, NodeHealth health = NodeHealth::ok) {
        std::vector<CanFrame> said;
        const Instant end = now_ + length;
        for (Instant next = now_; next <= end;) {
            now_ = next;
            next = node_.poll(now_, health);
            for (auto frames = node_.frames_to_send(now_); !frames.empty();
                 frames = node_.frames_to_send(now_)) {
                said.insert(said.end(), frames.begin(), frames.end());
                node_.written();
                next = node_.poll(now_, health);
            }
            EXPECT_GT(next, now_) << "it wants to be called without end";
        }
        now_ = end;
        return said;
    }
    void hear(const std::vector<CanFrame>& frames) {
        for (const CanFrame& frame : frames) {
            node_.receive(frame, now_);
        }
    }
    /// Returns the node's answer to a request of a tool.
    template <class Request>
    std::vector<CanFrame> ask(const Request& request, NodeId destination = 42, bool fd = false) {
        hear(frames_of_transfer({.source = kTool,
                                 .destination = destination,
                                 .priority = 17,
                                 .transfer_id = transfer_id_++},
                                request, fd));
        return run({});
    }

  private:
    Node node_;
    Instant now_ = kStart;
    std::uint8_t transfer_id_ = 5;
};

/// Returns a node that has already sent its first NodeStatus.
NodeOnBus started(NodeSettings settings) {
    NodeOnBus bus(std::move(settings));
    bus.run(milliseconds(1));
    return bus;
}

TEST(DroneCanNode, SaysEachSecondThatItIsThere) {
    NodeOnBus bus(node_42());
    const auto said = bus.run(milliseconds(2999));
    ASSERT_EQ(said.size(), 3U);
    // docs/protocols/can.md, "DroneCAN: worked examples", example 5: node 42 with priority 24,
    // uptime first.
    EXPECT_EQ(said[0], frames_from(0x1801552A, {"00000000000000C0"})[0]);
    EXPECT_EQ(said[2], frames_from(0x1801552A, {"02000000000000C2"})[0]);
}

TEST(DroneCanNode, WantsWhatIsAddressedToItAndWhatOthersSendUnderItsId) {
    const Node node(node_42());
    const auto wants = [&](const CanFrame& frame) {
        return std::ranges::any_of(node.wanted(),
                                   [&](const CanIdMatch& ids) { return ids.matches(frame); });
    };
    const auto request_to = [](NodeId id) {
        return frames_of_transfer(
            {.source = kTool, .destination = id, .priority = 17, .transfer_id = 0},
            GetNodeInfo::Request{})[0];
    };
    EXPECT_TRUE(wants(request_to(42)));
    EXPECT_FALSE(wants(request_to(43)));
    EXPECT_TRUE(wants(frames_of_message(NodeStatus{}, 42, 0)[0]));
    EXPECT_FALSE(wants(frames_of_message(NodeStatus{}, 43, 0)[0]));
}

TEST(DroneCanNode, WarnsWhereItsOutputsHaveLostTheirInputs) {
    NodeOnBus bus(node_42());
    const auto status = message_of_frames<NodeStatus>(bus.run({}, NodeHealth::warning));
    EXPECT_EQ(status.health, NodeStatus::kHealthWarning);
    EXPECT_EQ(status.mode, NodeStatus::kModeOperational);
}

TEST(DroneCanNode, SaysThatItGoes) {
    NodeOnBus bus = started(node_42());
    bus.node().end(bus.now());
    const auto status = message_of_frames<NodeStatus>(bus.run(seconds(5)));
    EXPECT_EQ(status.mode, NodeStatus::kModeOffline);
    EXPECT_TRUE(bus.run(seconds(5)).empty());
}

TEST(DroneCanNode, AnswersWhoItIsWithTheTransferIdAndPriorityOfTheRequest) {
    NodeOnBus bus = started(node_42());
    const auto frames = bus.ask(GetNodeInfo::Request{});
    const auto head = head_of(frames.at(0));
    ASSERT_TRUE(head);
    EXPECT_EQ(*head, (TransferHead{.kind = TransferKind::response,
                                   .data_type_id = GetNodeInfo::kId,
                                   .source = 42,
                                   .destination = kTool,
                                   .priority = 17,
                                   .transfer_id = 5}));
    const auto info = message_of_frames<GetNodeInfo::Response>(frames);
    EXPECT_EQ(info.name.view(), "org.tribus");
    EXPECT_EQ(info.hardware_version.unique_id, kUniqueId);
    EXPECT_EQ(info.software_version.minor, 1);
}

TEST(DroneCanNode, AnswersInFdFramesToThoseWhoAskInThem) {
    NodeOnBus bus = started(node_42());
    const auto frames = bus.ask(RestartNode::Request{}, 42, true);
    ASSERT_EQ(frames.size(), 1U);
    EXPECT_TRUE(frames[0].fd);
}

TEST(DroneCanNode, DoesNotAnswerForOthers) {
    NodeOnBus bus = started(node_42());
    EXPECT_TRUE(bus.ask(GetNodeInfo::Request{}, 43).empty());
}

ParamGetSet::Request parameter_named(const std::string& name) {
    ParamGetSet::Request request;
    request.name = BoundedText<92>(name);
    return request;
}

TEST(DroneCanNode, ShowsItsParametersByNumberAndByName) {
    NodeOnBus bus = started(node_42());
    ParamGetSet::Request by_number;
    by_number.index = 1;
    for (const auto& request : {by_number, parameter_named("uavcan.pubp-RCInput")}) {
        const auto answer = message_of_frames<ParamGetSet::Response>(bus.ask(request));
        EXPECT_EQ(answer.name.view(), "uavcan.pubp-RCInput");
        EXPECT_EQ(std::get<std::int64_t>(answer.value.held), 10000);
        EXPECT_EQ(std::get<std::int64_t>(answer.min_value.held), 10000);
        EXPECT_EQ(std::get<std::int64_t>(answer.max_value.held), 1000000);
    }
}

TEST(DroneCanNode, AnswersWithAnEmptyNameWhereThereIsNoSuchParameter) {
    NodeOnBus bus = started(node_42());
    ParamGetSet::Request by_number;
    by_number.index = 2;
    for (const auto& request : {by_number, parameter_named("no.such")}) {
        const auto answer = message_of_frames<ParamGetSet::Response>(bus.ask(request));
        EXPECT_TRUE(answer.name.empty());
        EXPECT_TRUE(std::holds_alternative<ParamEmpty>(answer.value.held));
    }
}

/// Requests to write the parameter and returns the result.
std::pair<std::int64_t, std::optional<Duration>> written(NodeSettings settings, std::int64_t value,
                                                         const char* name = "uavcan.pubp-RCInput") {
    NodeOnBus bus = started(std::move(settings));
    auto request = parameter_named(name);
    request.value.held = value;
    const auto answer = message_of_frames<ParamGetSet::Response>(bus.ask(request));
    const auto change = bus.node().take_period_request();
    return {std::get<std::int64_t>(answer.value.held),
            change ? std::optional(change->period) : std::nullopt};
}

TEST(DroneCanNode, LetsNobodyWriteUnlessThatIsAllowed) {
    EXPECT_EQ(written(node_42(), 20000), std::pair(std::int64_t{10000}, std::optional<Duration>{}));
}

TEST(DroneCanNode, TakesAPeriodWhereWritingIsAllowed) {
    NodeSettings settings = node_42();
    settings.may_write = true;
    EXPECT_EQ(written(settings, 20000),
              std::pair(std::int64_t{20000}, std::optional<Duration>(milliseconds(20))));
    EXPECT_EQ(written(settings, 9999), std::pair(std::int64_t{10000}, std::optional<Duration>{}));
    EXPECT_EQ(written(settings, 1000001),
              std::pair(std::int64_t{10000}, std::optional<Duration>{}));
    EXPECT_EQ(written(settings, 43, "uavcan.node_id"),
              std::pair(std::int64_t{42}, std::optional<Duration>{}));
}

TEST(DroneCanNode, SavesNothing) {
    NodeOnBus bus = started(node_42());
    EXPECT_FALSE(
        message_of_frames<ParamExecuteOpcode::Response>(bus.ask(ParamExecuteOpcode::Request{})).ok);
}

TEST(DroneCanNode, RefusesARestartUnlessThatIsAllowed) {
    NodeOnBus bus = started(node_42());
    EXPECT_FALSE(message_of_frames<RestartNode::Response>(bus.ask(RestartNode::Request{})).ok);
    EXPECT_FALSE(bus.node().report().restart_wanted);
}

TEST(DroneCanNode, WantsToRestartWhereThatIsAllowedAndTheMagicNumberIsRight) {
    NodeSettings settings = node_42();
    settings.may_restart = true;
    NodeOnBus bus = started(settings);
    RestartNode::Request wrong;
    wrong.magic_number = 1;
    EXPECT_FALSE(message_of_frames<RestartNode::Response>(bus.ask(wrong)).ok);
    EXPECT_FALSE(bus.node().report().restart_wanted);
    EXPECT_TRUE(message_of_frames<RestartNode::Response>(bus.ask(RestartNode::Request{})).ok);
    EXPECT_TRUE(bus.node().report().restart_wanted);
}

TEST(DroneCanNode, TellsWhatItCounts) {
    NodeOnBus bus = started(node_42());
    bus.node().set_bus_counters(7, 8, 9);
    bus.ask(GetNodeInfo::Request{});
    const auto answer =
        message_of_frames<GetTransportStats::Response>(bus.ask(GetTransportStats::Request{}));
    EXPECT_EQ(answer.transfers_tx, 2U);  // its status and the first answer
    EXPECT_EQ(answer.transfers_rx, 2U);
    ASSERT_EQ(answer.can_iface_stats.size(), 1U);
    EXPECT_EQ(answer.can_iface_stats[0].frames_tx, 7U);
    EXPECT_EQ(answer.can_iface_stats[0].frames_rx, 8U);
    EXPECT_EQ(answer.can_iface_stats[0].errors, 9U);
}

TEST(DroneCanNode, CountsATransferWithADamagedByte) {
    NodeOnBus bus = started(node_42());
    auto frames =
        frames_of_transfer({.source = 99, .destination = 42, .priority = 17, .transfer_id = 3},
                           parameter_named("uavcan.pubp-RCInput"));
    ASSERT_GE(frames.size(), 3U);
    frames[1].data[0] ^= 1U;
    bus.hear(frames);
    const auto answer =
        message_of_frames<GetTransportStats::Response>(bus.ask(GetTransportStats::Request{}));
    EXPECT_EQ(answer.transfer_errors, 1U);
}

TEST(DroneCanNode, FallsSilentWhereAnotherNodeHasItsIdUntilThatIsGoneFor5Seconds) {
    NodeOnBus bus = started(node_42());
    EXPECT_EQ(bus.node().identity().id, 42);
    bus.hear(frames_of_message(NodeStatus{}, 42, 0));
    EXPECT_EQ(bus.node().identity().id, kNobody);
    EXPECT_EQ(bus.node().state().stage, NodeStage::conflict);
    EXPECT_TRUE(bus.run(milliseconds(4000)).empty());
    bus.hear(frames_of_message(NodeStatus{}, 42, 1));
    EXPECT_TRUE(bus.run(milliseconds(4999)).empty());
    EXPECT_FALSE(bus.run(milliseconds(1)).empty());
    EXPECT_EQ(bus.node().identity().id, 42);
    EXPECT_EQ(bus.node().report().counts.conflicts, 1U);
}

TEST(DroneCanNode, DoesNotMindOtherNodes) {
    NodeOnBus bus = started(node_42());
    bus.hear(frames_of_message(NodeStatus{}, 43, 0));
    EXPECT_EQ(bus.node().identity().id, 42);
}

TEST(DroneCanNode, OffersATransferAgainThatTheBusCouldNotTakeAndDropsItAfterASecond) {
    NodeOnBus bus = started(node_42());
    bus.hear(frames_of_transfer({.source = kTool, .destination = 42}, GetNodeInfo::Request{}));
    Instant now = bus.now();
    int offers = 0;
    for (; bus.node().report().counts.dropped == 0; now = bus.node().poll(now, NodeHealth::ok)) {
        if (!bus.node().frames_to_send(now).empty()) {
            ++offers;
            bus.node().busy(now);
            EXPECT_TRUE(bus.node().frames_to_send(now).empty());
        }
    }
    EXPECT_EQ(offers, 502);  // every 2 ms from 0 to 1002 ms
}

TEST(DroneCanNode, AnswersEightNodesThatAskAtOnceAndLetsTheOthersAskAgain) {
    NodeOnBus bus = started(node_42());
    for (NodeId asker = 1; asker <= 10; ++asker) {
        bus.hear(frames_of_transfer({.source = asker, .destination = 42}, RestartNode::Request{}));
    }
    EXPECT_EQ(bus.run({}).size(), 8U);
}

NodeSettings nameless() {
    NodeSettings settings = node_42();
    settings.id = kNobody;
    settings.dynamic = true;
    return settings;
}

Allocation answer_of(NodeId id, std::size_t bytes) {
    Allocation message;
    message.node_id = id;
    for (std::size_t i = 0; i < bytes; ++i) {
        message.unique_id.push_back(kUniqueId[i]);
    }
    return message;
}

TEST(DroneCanNodeWithoutId, AsksFromNobodyAndSaysNothingElse) {
    NodeOnBus bus(nameless());
    const auto said = bus.run(seconds(10));
    EXPECT_GE(said.size(), 10U);  // every 600 to 1000 ms
    EXPECT_LE(said.size(), 16U);
    for (const CanFrame& frame : said) {
        const auto head = head_of(frame);
        ASSERT_TRUE(head);
        EXPECT_EQ(head->source, kNobody);
        EXPECT_EQ(head->data_type_id, Allocation::kId);
    }
    EXPECT_TRUE(bus.ask(GetNodeInfo::Request{}).empty());
    EXPECT_EQ(bus.node().identity().id, kNobody);
}

TEST(DroneCanNodeWithoutId, SaysItsUniqueIdInThreePartsAndTakesTheIdThatItGets) {
    NodeOnBus bus(nameless());
    for (const auto& [before, first, bytes] :
         {std::tuple{0, true, 6}, std::tuple{6, false, 6}, std::tuple{12, false, 4}}) {
        std::vector<CanFrame> said;
        while (said.empty()) {
            said = bus.run(milliseconds(10));
        }
        const auto request = message_of_frames<Allocation>(said);
        EXPECT_EQ(request.first_part_of_unique_id, first);
        ASSERT_EQ(request.unique_id.size(), static_cast<std::size_t>(bytes));
        EXPECT_EQ(request.unique_id[0], kUniqueId[static_cast<std::size_t>(before)]);
        const bool last = before == 12;
        bus.hear(
            frames_of_message(answer_of(last ? 99 : 0, static_cast<std::size_t>(before + bytes)), 1,
                              static_cast<std::uint8_t>(before)));
    }
    EXPECT_FALSE(bus.run(milliseconds(1)).empty());
    EXPECT_EQ(bus.node().identity().id, 99);
    EXPECT_EQ(bus.node().state().stage, NodeStage::online);
}

TEST(DroneCanNodeWithoutId, DoesNotTakeTheIdOfAnother) {
    NodeOnBus bus(nameless());
    Allocation other = answer_of(99, 16);
    other.unique_id[15] ^= 1U;
    bus.hear(frames_of_message(other, 1, 0));
    bus.run(milliseconds(1));
    EXPECT_EQ(bus.node().identity().id, kNobody);
}

TEST(DroneCanNodeWithoutId, LetsAnotherCandidateGoFirst) {
    NodeOnBus bus(nameless());
    for (int i = 0; i < 50; ++i) {
        bus.hear(frames_of_message(answer_of(0, 6), kNobody, static_cast<std::uint8_t>(i % 32)));
        EXPECT_TRUE(bus.run(milliseconds(500)).empty());
    }
}

TEST(DroneCanNodeWithoutId, BeginsAnewWhereItsWholeUniqueIdIsConfirmedWithoutAnId) {
    AllocationClient client(kUniqueId, kNobody, 1);
    client.start(kStart);
    client.take(answer_of(0, 16), 1, kStart);
    const Allocation request = client.run(client.due());
    EXPECT_TRUE(request.first_part_of_unique_id);
    ASSERT_EQ(request.unique_id.size(), 6U);
    EXPECT_EQ(request.unique_id[0], kUniqueId[0]);
}

TEST(DroneCanNodeWithoutId, PausesForAnotherTimeBeforeEachRequest) {
    AllocationClient client(kUniqueId, kNobody, 1);
    client.start(kStart);
    std::set<Duration> pauses;
    for (int i = 0; i < 20; ++i) {
        const Instant now = client.due();
        EXPECT_TRUE(client.run(now).first_part_of_unique_id) << "nobody answered";
        pauses.insert(client.due() - now);
    }
    EXPECT_EQ(pauses.size(), 20U);
}

TEST(DroneCanNodeWithoutId, AsksForAnotherWhereANodeHasTheSame) {
    NodeOnBus bus(nameless());
    bus.hear(frames_of_message(answer_of(99, 16), 1, 0));
    bus.run(milliseconds(1));
    ASSERT_EQ(bus.node().identity().id, 99);
    bus.hear(frames_of_message(NodeStatus{}, 99, 0));
    EXPECT_EQ(bus.node().identity().id, kNobody);
    EXPECT_EQ(head_of(bus.run(seconds(1)).at(0))->source, kNobody);
}

TEST(DroneCanNode, KeepsItsSecondsHoweverLateItsTurns) {
    Node node(node_42());
    node.start(Instant{});
    node.poll(Instant{}, NodeHealth::ok);
    node.written();
    node.poll(Instant(milliseconds(1300)), NodeHealth::ok);
    node.written();
    EXPECT_EQ(node.poll(Instant(milliseconds(1301)), NodeHealth::ok), Instant(seconds(2)));
}

}  // namespace
}  // namespace tribus::dronecan::node_test
