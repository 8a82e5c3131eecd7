#include <csignal>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/link_jobs.h"
#include "tests/loopback/udp_socket.h"

/// Two boxes with a link between them, and somebody on the way.
namespace tribus::test::link_attack_test {
namespace {

using std::chrono::milliseconds;

/// Somebody on the way, who records everything and sends what he likes.
class Attacked : public TwoPrograms, public testing::WithParamInterface<std::pair<BusJob, bool>> {
  protected:
    Attacked() {
        write_key("boat.key", '7');
        write_key("other.key", '8');
        shell("ip link set lo up");
    }

    bool has_key() const { return GetParam().second; }

    const BusJob& job_ = GetParam().first;
    VirtualBus bus_;
};

INSTANTIATE_TEST_SUITE_P(
    LinksWithAndWithoutAKey, Attacked,
    testing::Values(std::pair(kFdBus, false), std::pair(with_key(kFdBus), true),
                    std::pair(kClassicBus, false), std::pair(with_key(kClassicBus), true),
                    std::pair(kUdp, false), std::pair(with_key(kUdp), true),
                    std::pair(with_epoch(kFdBus), true), std::pair(with_epoch(kClassicBus), true),
                    std::pair(with_epoch(kUdp), true)),
    [](const auto& instance) {
        const BusJob& job = instance.param.first;
        const bool fd = job.format.find("fd") != std::string::npos;
        return std::string(job.sender_interface.empty() ? "Udp"
                           : fd                         ? "CanFd"
                                                        : "ClassicCan") +
               (!instance.param.second     ? "WithoutAKey"
                : job.reader_lines.empty() ? "WithAKey"
                                           : "WithAnEpoch");
    });

TEST_P(Attacked, RecordingMovesTheServosOfABoxThatStartedAgainOnlyWithoutAKey) {
    RawCan ear(bus_.name());
    std::optional<UdpSocket> middle;
    BusJob to_middle = job_;
    const bool over_udp = job_.sender_interface.empty();
    if (over_udp) {
        middle.emplace();
        const auto port = to_middle.format.find(std::to_string(kLinkPort));
        to_middle.format.replace(port, 4, std::to_string(middle->port()));
    }
    std::vector<Bytes> datagrams;
    std::uint16_t sender_port = 0;
    const auto pass_on = [&] {
        while (const auto datagram = middle ? middle->receive() : std::nullopt) {
            if (middle->sender() == kLinkPort) {
                middle->send_to(sender_port, *datagram);
            } else {
                sender_port = middle->sender();
                datagrams.push_back(*datagram);
                middle->send_to(kLinkPort, *datagram);
            }
        }
    };
    Program& reader = start_reader(job_);
    Program& sender = start_sender(to_middle);
    std::vector<CanSight> frames;
    int moved = 0;
    EXPECT_TRUE(eventually([&] {
        for (const auto end = Clock::now() + milliseconds(200); Clock::now() < end;) {
            for (const SbusSight& sight : carry_for(milliseconds(2))) {
                moved += sight.good() ? 1 : 0;
            }
            pass_on();
        }
        const auto more = ear.receive_all();
        frames.insert(frames.end(), more.begin(), more.end());
        return moved > 100;
    })) << sender.errors()
        << reader.errors();
    for (Program* program : {&sender, &reader}) {
        program->signal(SIGKILL);
        program->end();
    }
    servos().listen();

    Program& reader_again = start_reader(job_);
    bool fell = false;
    const auto look = [&] {
        std::this_thread::sleep_for(milliseconds(5));
        for (const SbusSight& sight : servos().listen()) {
            fell = fell || sight.good();
        }
    };
    for (std::size_t i = 0; i < frames.size(); ++i) {
        // Frames of one snapshot stay together.
        if (i > 0 && frames[i].kernel_time - frames[i - 1].kernel_time > milliseconds(3)) {
            look();
        }
        ear.send(frames[i].frame);
    }
    for (const Bytes& datagram : datagrams) {
        middle->send_to(kLinkPort, datagram);
        look();
    }
    EXPECT_NE(fell, has_key()) << reader_again.errors();
    EXPECT_EQ(reader_again.errors().find("replayed") != std::string::npos, has_key());
    expect_clean_end(reader_again);
}

TEST_P(Attacked, BoxWithAnotherKeyOrNoneMovesTheServosOnlyWithoutAKey) {
    BusJob forger = job_;
    if (has_key()) {
        forger.format.replace(forger.format.find("boat.key"), 4, "other");
    }
    Program& reader = start_reader(job_);
    Program& sender = start_sender(forger);
    bool fell = false;
    for (const auto end = Clock::now() + std::chrono::seconds(3); Clock::now() < end && !fell;) {
        for (const SbusSight& sight : carry_for(milliseconds(50))) {
            fell = fell || sight.good();
        }
    }
    EXPECT_NE(fell, has_key()) << reader.errors();
    EXPECT_EQ(reader.errors().find("forged") != std::string::npos, has_key()) << reader.errors();
    expect_clean_end(sender);
    expect_clean_end(reader);
}

}  // namespace
}  // namespace tribus::test::link_attack_test
