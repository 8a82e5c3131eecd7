#include <csignal>
#include <cstdint>
#include <ctime>
#include <optional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"
#include "tests/loopback/udp_socket.h"
#include "tests/reference/plain_ibus.h"
#include "tests/support/ibus_frames.h"

/// The program between two UDP addresses of this machine, read by a plain socket.
namespace tribus::test::udp_test {
namespace {

class Udp : public Loopback {
  protected:
    std::string config(const std::string& protocol) {
        return write_config("[input.sim]\nprotocol = \"ibus\"\naddress = \"127.0.0.1:" +
                            std::to_string(in_) + "\"\n[output.copy]\nprotocol = \"" + protocol +
                            "\"\naddress = \"127.0.0.1:" + std::to_string(servos_.port()) +
                            "\"\n[pipeline.main]\nfrom = \"sim\"\nto = \"copy\"\n"
                            "[pipeline.main.failsafe]\naction = \"silence\"\n");
    }
    /// Sends `sent` again and again until a datagram equals `wanted`.
    bool comes_through(const Bytes& sent, const Bytes& wanted) {
        return eventually([&] {
            sender_.send_to(in_, sent);
            while (const auto bytes = servos_.receive()) {
                if (*bytes == wanted) {
                    return true;
                }
            }
            return false;
        });
    }

    UdpSocket sender_;
    UdpSocket servos_;
    std::uint16_t in_ = free_udp_port();
};

TEST_F(Udp, ADatagramIsAFrameInBothDirections) {
    Program& program = run(config("ibus"));
    Bytes payload(28);
    for (std::size_t slot = 0; slot < 14; ++slot) {
        const unsigned pulse = 1000 + 10 * static_cast<unsigned>(slot);
        payload[2 * slot] = static_cast<std::uint8_t>(pulse);
        payload[2 * slot + 1] = static_cast<std::uint8_t>(pulse >> 8U);
    }
    const Bytes frame = servo_frame(payload, 0x40);
    EXPECT_TRUE(comes_through(frame, frame)) << program.errors();
    expect_clean_end(program);
}

TEST_F(Udp, WhatADatagramLeavesUnfinishedIsNotContinuedByTheNext) {
    Program& program = run(config("ibus"));
    const Bytes frame = servo_frame(Bytes(28, 5), 0x40);
    // Longer than `power_on`, before which no output is under control.
    for (int i = 0; i < 150; ++i) {
        sender_.send_to(in_, Bytes(frame.begin(), frame.begin() + 20));
        sender_.send_to(in_, Bytes(frame.begin() + 20, frame.end()));
        const timespec pause{.tv_sec = 0, .tv_nsec = 8'000'000};
        ::nanosleep(&pause, nullptr);
    }
    EXPECT_FALSE(servos_.receive()) << "no datagram was a frame";
    const Bytes other = servo_frame(Bytes(28, 4), 0x40);
    EXPECT_TRUE(comes_through(other, other)) << program.errors();
    expect_clean_end(program);
}

TEST_F(Udp, EndsWithSilenceWhenTheSenderIsSilent) {
    Program& program = run(config("ibus"));
    const Bytes frame = servo_frame(Bytes(28, 5), 0x40);
    ASSERT_TRUE(comes_through(frame, frame)) << program.errors();
    // The log may miss a control that lasts shorter than the main thread waits for a processor.
    EXPECT_TRUE(eventually([&] {
        while (servos_.receive()) {
        }
        const timespec pause{.tv_sec = 0, .tv_nsec = 500'000'000};
        ::nanosleep(&pause, nullptr);
        return !servos_.receive();
    })) << "a lost input must not be sent on: "
        << program.errors();
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::udp_test
