#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/recorded_receiver.h"
#include "tests/lab/spi_butterfly.h"
#include "tests/loopback/loopback.h"
#include "tests/reference/plain_uart.h"

/// The built program with SBUS out of an SPI port: an independent UART reads the bits that the
/// kernel's driver put on the data line. The guest's clock counts its instructions, and its driver
/// makes each bit with the guest's only processor.
namespace tribus::test::ppm_sbus_spi_test {
namespace {

constexpr int kBitsOfThePortPerBit = 8;

class LabSbusSpi : public Loopback {
  protected:
    LabSbusSpi() { require_guest(); }

    std::string to_spi() const {
        return "[input.receiver]\nprotocol = \"ibus\"\ndevice = \"@receiver\"\ntimeout = "
               "\"200ms\"\n"
               "[output.servos]\nprotocol = \"sbus\"\nspi = \"" +
               port_.device() +
               "\"\nperiod = \"100ms\"\n[pipeline.main]\nfrom = \"receiver\"\n"
               "to = \"servos\"\n"
               "[pipeline.main.failsafe]\nhold = \"0s\"\nrecover = \"0s\"\n";
    }
    /// The undamaged bytes that a UART reads of the latest three frames on the line; times are bits
    /// of the port.
    Bytes read_bytes() {
        constexpr std::size_t kThreeFrames = 8000;
        const std::vector<bool> fresh = port_.sent_bits();
        bits_.insert(bits_.end(), fresh.begin(), fresh.end());
        const auto old =
            static_cast<std::ptrdiff_t>(bits_.size() - std::min(bits_.size(), kThreeFrames));
        bits_.erase(bits_.begin(), bits_.begin() + old);
        const PlainUart uart{.baud = 1e6 / kBitsOfThePortPerBit};
        const auto level = [this](double at) {
            const auto bit = static_cast<std::size_t>(at);
            return bit < bits_.size() && bits_[bit];
        };
        Bytes bytes;
        for (const UartByte& byte : uart.read(level, 0, static_cast<double>(bits_.size()))) {
            if (!byte.parity_error && !byte.framing_error) {
                bytes.push_back(byte.value);
            }
        }
        return bytes;
    }
    /// Sends the sticks until a frame on the line has them.
    bool leaves(const Sticks& sticks) {
        Repeater repeater(receiver_, ibus_bytes(sticks));
        const Bytes wanted = sbus_bytes(sbus_sight_of(sticks));
        return eventually([&] {
            repeater.send_if_due();
            const Bytes seen = read_bytes();
            return std::ranges::search(seen, wanted).begin() != seen.end();
        });
    }

    FarEnd& receiver_ = device("receiver");
    SpiButterfly port_;

  private:
    std::vector<bool> bits_;
};

TEST_F(LabSbusSpi, EachFrameOnTheLineIsThatOfTheRecordedReceiver) {
    Program& program = run(write_config(to_spi()));
    for (const Capture capture : captures()) {
        const std::vector<Sticks> all = recorded_sticks(capture);
        for (std::size_t frame = 0; frame < 400; frame += 80) {
            EXPECT_TRUE(leaves(all.at(frame))) << frame;
        }
    }
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test::ppm_sbus_spi_test
