#include <algorithm>
#include <chrono>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <regex>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/loopback/udp_socket.h"

/// Two programs, an i.Bus receiver at one and SBUS servos at the other, and a router between them
/// that rewrites addresses.
namespace tribus::test::network_test {
namespace {

class Network : public Loopback {
  protected:
    Network() { write_key("boat.key", '7'); }
    std::string shore_config(std::string_view key) {
        return write_config("[input.radio]\nprotocol = \"ibus\"\ndevice = \"@radio\"\n" +
                                std::string(kPatientInput) +
                                "\n[output.boat]\nprotocol = \"network\"\naddress = \"127.0.0.1:" +
                                std::to_string(router_->port()) + "\"\n" + std::string(key) +
                                "[pipeline.main]\nfrom = \"radio\"\nto = \"boat\"\n",
                            "shore.toml");
    }
    std::string boat_config(std::string_view key) {
        return write_config("[input.shore]\nprotocol = \"network\"\naddress = \"127.0.0.1:" +
                                std::to_string(boat_port_) + "\"\n" + std::string(key) +
                                "[output.servos]\nprotocol = \"sbus\"\ndevice = \"@servos\"\n"
                                "[pipeline.main]\nfrom = \"shore\"\nto = \"servos\"\n",
                            "boat.toml");
    }

    /// Passes on what waits, from both sides.
    void route() {
        while (const auto datagram = router_->receive()) {
            shore_port_ = router_->sender();
            seen_.push_back(*datagram);
            outside_->send_to(boat_port_, *datagram);
        }
        while (const auto datagram = outside_->receive()) {
            router_->send_to(shore_port_, *datagram);
        }
    }
    /// Moves the sticks until the servos do, with the first channel at `first_us`.
    bool servos_follow(int first_us) {
        radio_.change(ibus_bytes(sticks_with_first(first_us, 14)));
        return eventually([&] {
            radio_.send_if_due();
            route();
            for (const SbusSight& sight : servos_.listen()) {
                if (sight.good() && sight.raw[0] == sbus_raw(first_us)) {
                    return true;
                }
            }
            return false;
        });
    }

    /// Calls `send` again and again, until the servos have got frames for 1.4 s, 14 ms each.
    /// Control would be there after 500 ms.
    template <class Send>
    void expect_no_control_while(Send send) {
        constexpr int kFrames = 100;
        int frames = 0;
        EXPECT_TRUE(eventually([&] {
            send();
            std::this_thread::sleep_for(std::chrono::milliseconds(15));
            for (const SbusSight& sight : servos_.listen()) {
                ++frames;
                EXPECT_FALSE(sight.good());
            }
            return frames >= kFrames;
        })) << "the servos got "
            << frames << " frames";
    }

    /// A whole recorded conversation, played to a boat that starts again.
    void expect_recorded_frames_to_move_nothing(std::string_view boat_lines,
                                                std::string_view shore_lines) {
        Program& boat = run(boat_config(boat_lines));
        Program& shore = run(shore_config(shore_lines));
        ASSERT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
        shore.signal(SIGKILL);
        shore.end();
        boat.signal(SIGKILL);
        boat.end();
        servos_.listen();
        const std::size_t snapshot_bytes = seen_.back().size();
        const auto play = [&](bool with_hellos) {
            for (const Bytes& datagram : seen_) {
                if (with_hellos || datagram.size() == snapshot_bytes) {
                    outside_->send_to(boat_port_, datagram);
                }
            }
        };
        Program& boat_again = run(boat_config(boat_lines));
        expect_no_control_while([&] { play(false); });
        EXPECT_TRUE(boat_again.says("input shore: replayed")) << boat_again.errors();
        // It answers the hellos by challenges of numbers that the snapshots have answered before.
        expect_no_control_while([&] { play(true); });
        expect_clean_end(boat_again);
    }

    static constexpr std::string_view kKey = "key = \"boat.key\"\n";
    static constexpr std::string_view kShoreEpoch =
        "key = \"boat.key\"\nepoch = \"@shore.epoch\"\n";
    static constexpr std::string_view kBoatEpoch = "key = \"boat.key\"\nepoch = \"@boat.epoch\"\n";
    FarEnd& radio_wire_ = device("radio");
    FarEnd& servo_wire_ = device("servos");
    Repeater radio_{radio_wire_, ibus_bytes(sticks_with_first(1500, 14))};
    ServoBank servos_{servo_wire_};
    std::optional<UdpSocket> router_{std::in_place};
    std::optional<UdpSocket> outside_{std::in_place};
    std::uint16_t boat_port_ = free_udp_port();
    std::uint16_t shore_port_ = 0;
    std::vector<Bytes> seen_;
    int first_us_ = 1200;
};

TEST_F(Network, WithAKeyCarriesSticksThroughARouterThatChangesItsPort) {
    Program& boat = run(boat_config(kKey));
    Program& shore = run(shore_config(kKey));
    EXPECT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
    outside_.emplace();
    EXPECT_TRUE(servos_follow(1300)) << boat.errors() << shore.errors();
    expect_clean_end(shore);
    expect_clean_end(boat);
}

TEST_F(Network, WithAKeyNeedsNoHandWhenEitherEndStartsAgain) {
    Program& boat = run(boat_config(kKey));
    Program& shore = run(shore_config(kKey));
    ASSERT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
    boat.signal(SIGKILL);
    boat.end();
    Program& boat_again = run(boat_config(kKey));
    EXPECT_TRUE(servos_follow(1300)) << boat_again.errors() << shore.errors();
    shore.signal(SIGKILL);
    shore.end();
    Program& shore_again = run(shore_config(kKey));
    EXPECT_TRUE(servos_follow(1600)) << boat_again.errors() << shore_again.errors();
    expect_clean_end(shore_again);
    expect_clean_end(boat_again);
}

TEST_F(Network, WithAKeySaysAtBothEndsThatTheOtherHasAnotherOne) {
    write_key("other.key", '8');
    Program& boat = run(boat_config(kKey));
    Program& shore = run(shore_config("key = \"other.key\"\n"));
    EXPECT_TRUE(eventually([&] {
        radio_.send_if_due();
        route();
        return shore.errors().find("output boat: cannot send: no receiver with the same key") !=
                   std::string::npos &&
               boat.errors().find("input shore: forged") != std::string::npos;
    })) << boat.errors()
        << shore.errors();
    expect_clean_end(shore);
    expect_clean_end(boat);
}

TEST_F(Network, WithAKeySaysThatSomebodyElseSendsAndStaysInControl) {
    Program& boat = run(boat_config(kKey));
    Program& shore = run(shore_config(kKey));
    ASSERT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
    // As long as a snapshot, and the answer to a challenge that nobody has sent yet.
    Bytes forged{0x54, 0x52, 0x01, 64};
    forged.resize(4 + 64);
    forged[4 + 7] = 200;
    outside_->send_to(boat_port_, forged);
    // A busy machine may delay messages of the shore until their challenge counts no more.
    const std::regex said(
        "input shore: refused [0-9]+ messages? that its key does not prove, while its own sender "
        "is heard");
    EXPECT_TRUE(eventually([&] {
        radio_.send_if_due();
        route();
        return std::regex_search(boat.errors(), said);
    })) << boat.errors();
    EXPECT_TRUE(servos_follow(1300)) << boat.errors() << shore.errors();
    EXPECT_EQ(boat.errors().find("input shore: forged"), std::string::npos) << boat.errors();
    expect_clean_end(shore);
    expect_clean_end(boat);
}

TEST_F(Network, WithAKeyRecordedFramesMoveNothing) {
    expect_recorded_frames_to_move_nothing(kKey, kKey);
}

TEST_F(Network, WithAnEpochGoesToAReceiverThatSaysNothing) {
    Program& boat = run(boat_config(kBoatEpoch));
    Program& shore = run(shore_config(kShoreEpoch));
    EXPECT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
    EXPECT_FALSE(outside_->receive()) << "the boat answers";
    expect_clean_end(shore);
    expect_clean_end(boat);
    EXPECT_EQ(boat.errors().find("garbled"), std::string::npos) << boat.errors();
}

/// An orderly end leaves the exact number, so that the boat need not wait.
TEST_F(Network, WithAnEpochNeedsNoHandWhenEitherEndStartsAgain) {
    Program& boat = run(boat_config(kBoatEpoch));
    Program& shore = run(shore_config(kShoreEpoch));
    ASSERT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
    expect_clean_end(boat);
    Program& boat_again = run(boat_config(kBoatEpoch));
    EXPECT_TRUE(servos_follow(1300)) << boat_again.errors() << shore.errors();
    shore.signal(SIGKILL);
    shore.end();
    Program& shore_again = run(shore_config(kShoreEpoch));
    EXPECT_TRUE(servos_follow(1600)) << boat_again.errors() << shore_again.errors();
    expect_clean_end(shore_again);
    expect_clean_end(boat_again);
}

/// Longer away than `timeout`, so that what comes then looks late to a boat that does not know for
/// how long the shore was away. Meanwhile somebody sends all again.
TEST_F(Network, WithAnEpochComesBackHoweverTheShoreEndedAndRecordedFramesMoveNothing) {
    Program& boat = run(boat_config(kBoatEpoch));
    int first_us = 1300;
    for (const int end : {SIGKILL, SIGTERM, SIGKILL}) {
        Program& shore = run(shore_config(kShoreEpoch));
        ASSERT_TRUE(servos_follow(first_us)) << boat.errors() << shore.errors();
        shore.signal(end);
        shore.end();
        ASSERT_TRUE(eventually([&] {
            route();
            return std::ranges::any_of(servos_.listen(),
                                       [](const SbusSight& sight) { return !sight.good(); });
        })) << "no failsafe after `timeout`";
        expect_no_control_while([&] {
            for (const Bytes& datagram : seen_) {
                outside_->send_to(boat_port_, datagram);
            }
        });
        first_us += 100;
    }
    Program& shore = run(shore_config(kShoreEpoch));
    EXPECT_TRUE(servos_follow(first_us)) << boat.errors() << shore.errors();
    expect_clean_end(shore);
    expect_clean_end(boat);
}

TEST_F(Network, WithAnEpochRecordedFramesMoveNothingAlsoAfterAStart) {
    expect_recorded_frames_to_move_nothing(kBoatEpoch, kShoreEpoch);
}

TEST_F(Network, WithAnEpochGoesOnOverAReload) {
    Program& boat = run(boat_config(kBoatEpoch));
    Program& shore = run(shore_config(kShoreEpoch));
    ASSERT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
    // The log looks a little later.
    EXPECT_TRUE(eventually([&] {
        radio_.send_if_due();
        route();
        return boat.errors().find("under control of shore") != std::string::npos;
    })) << boat.errors();
    boat_config(std::string(kBoatEpoch) + "timeout = \"450ms\"\n");
    shore_config(std::string(kShoreEpoch) + "period = \"15ms\"\n");
    for (Program* const program : {&boat, &shore}) {
        program->signal(SIGHUP);
        EXPECT_TRUE(eventually([&] {
            radio_.send_if_due();
            route();
            return program->errors().find("reloaded ") != std::string::npos;
        })) << program->errors();
    }
    EXPECT_TRUE(servos_follow(1300)) << boat.errors() << shore.errors();
    expect_clean_end(shore);
    expect_clean_end(boat);
    const std::string after = boat.errors().substr(boat.errors().find("reloaded "));
    EXPECT_EQ(after.find("input shore"), std::string::npos) << "its link was never lost: " << after;
}

/// docs/protocols/network.md, "Change the key".
TEST_F(Network, WithAKeyGoesOnWhileTheKeyIsChanged) {
    write_key("new.key", '8');
    Program& boat = run(boat_config(kKey));
    Program& shore = run(shore_config(kKey));
    ASSERT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
    const auto reload = [&](Program& program) {
        const std::size_t before = program.errors().size();
        program.signal(SIGHUP);
        EXPECT_TRUE(eventually([&] {
            radio_.send_if_due();
            route();
            return program.errors().find("reloaded ", before) != std::string::npos;
        })) << program.errors();
        EXPECT_TRUE(servos_follow(first_us_ += 50)) << boat.errors() << shore.errors();
    };
    boat_config("key = \"new.key\"\nold_key = \"boat.key\"\n");
    reload(boat);
    shore_config("key = \"new.key\"\n");
    reload(shore);
    boat_config("key = \"new.key\"\n");
    reload(boat);
    // Before this line the log may tell what the shore's new key did: the sticks stood still.
    const std::string after = boat.errors().substr(boat.errors().rfind("reloaded "));
    EXPECT_EQ(after.find("warning input shore"), std::string::npos)
        << "the link was lost: " << boat.errors();
    expect_clean_end(shore);
    expect_clean_end(boat);
}

TEST_F(Network, WithAnEpochThatCannotBeKeptDoesNotStart) {
    const std::string none = "key = \"boat.key\"\nepoch = \"@none/boat.epoch\"\n";
    Program& boat = start({"run", boat_config(none)});
    EXPECT_EQ(boat.end(), 1);
    EXPECT_NE(boat.errors().find("boat.toml:3:11: [input.shore] epoch: cannot write " +
                                 (folder() / "none/boat.epoch.lock").string() +
                                 ": No such file or directory"),
              std::string::npos)
        << boat.errors();

    Program& first = run(boat_config(kBoatEpoch));
    Program& second = start({"run", shore_config(kBoatEpoch)});
    EXPECT_EQ(second.end(), 1);
    EXPECT_NE(second.errors().find("boat.epoch is in use by another program"), std::string::npos)
        << second.errors();
    expect_clean_end(first);
}

TEST_F(Network, WithoutAKeyStaysOnThisMachineAndWorks) {
    Program& boat = run(boat_config(""));
    Program& shore = run(shore_config(""));
    EXPECT_TRUE(servos_follow(1700)) << boat.errors() << shore.errors();
    expect_clean_end(shore);
    expect_clean_end(boat);
}

}  // namespace
}  // namespace tribus::test::network_test
