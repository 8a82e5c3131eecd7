#include <algorithm>
#include <csignal>

#include <string>

#include <gtest/gtest.h>

#include "tests/lab/can_bus.h"
#include "tests/lab/raw_can.h"
#include "tests/lab/two_programs.h"

/// A new configuration needs other ids of an interface. Its socket is opened in addition to the old
/// one and replaces it while frames flow.
namespace tribus::test::can_reload_test {
namespace {

class BusReload : public TwoPrograms {
  protected:
    /// Makes one program reload its configuration while frames flow.
    void reload(Program& side, const std::string& name, const std::string& text) {
        write_config(text, name);
        const std::size_t before = count_of("reloaded", side.errors());
        side.signal(SIGHUP);
        EXPECT_TRUE(carry_until([&](const SbusSight&) {
            return count_of("reloaded", side.errors()) > before;
        })) << side.errors();
    }
    /// Each of two outputs tells each loss of its input once.
    void expect_seamless(const Program& side) {
        constexpr std::size_t outputs = 2;
        EXPECT_LE(count_of("in failsafe", side.errors()), outputs * outages()) << side.errors();
        EXPECT_LE(count_of("holding", side.errors()), outputs * outages()) << side.errors();
    }

    VirtualBus bus_;
    FarEnd& tail_ = device("tail");
    Program& sender_ = start_sender({});
    Program& reader_ = start_reader({});
};

TEST_F(BusReload, AReaderThatWantsFurtherIdsLosesNoFrameForIt) {
    ASSERT_TRUE(carry_until_control());
    const auto descriptors = reader_.open_descriptors();
    const std::string further =
        reader_text({.reader_tables = "[input.spare]\nprotocol = \"can\"\ninterface = \"vcan0\"\n"
                                      "id = 0x400\n[output.tail]\nprotocol = \"sbus\"\n"
                                      "device = \"@tail\"\n[pipeline.tail]\n"
                                      "from = [\"spare\", \"bus\"]\nto = \"tail\"\n"});
    reload(reader_, "reader.toml", further);
    // The second pipeline receives the first one's frames on the new socket.
    ServoBank tail(tail_);
    EXPECT_TRUE(carry_until([&](const SbusSight&) {
        const auto seen = tail.listen();
        return !seen.empty() && seen.back().good();
    })) << reader_.errors();
    reload(reader_, "reader.toml", reader_text({}));
    EXPECT_TRUE(carry_until_control());
    EXPECT_EQ(reader_.open_descriptors(), descriptors);
    expect_seamless(reader_);
    expect_seamless(sender_);
    expect_clean_end(sender_);
    expect_clean_end(reader_);
}

TEST_F(BusReload, ASenderThatGetsASecondOutputGoesOnWithTheFirst) {
    ASSERT_TRUE(carry_until_control());
    const auto descriptors = sender_.open_descriptors();
    const std::string second =
        sender_text({.sender_tables = "[output.second]\nprotocol = \"can\"\n"
                                      "interface = \"vcan0\"\nid = 0x400\n[pipeline.second]\n"
                                      "from = \"receiver\"\nto = \"second\"\n"});
    RawCan ear("vcan0");
    reload(sender_, "sender.toml", second);
    EXPECT_TRUE(carry_until([&](const SbusSight&) {
        const auto heard = ear.receive_all();
        return std::ranges::any_of(heard,
                                   [](const CanSight& sight) { return sight.frame.id == 0x400; });
    })) << sender_.errors();
    reload(sender_, "sender.toml", sender_text({}));
    EXPECT_TRUE(carry_until_control());
    EXPECT_EQ(sender_.open_descriptors(), descriptors);
    expect_seamless(reader_);
    expect_seamless(sender_);
    expect_clean_end(sender_);
    expect_clean_end(reader_);
}

TEST_F(BusReload, TellsOfABusThatIsDownOnce) {
    ASSERT_TRUE(carry_until_control());
    set_link_down("vcan0");
    EXPECT_TRUE(reader_.says("interface vcan0: is down"));
    reload(reader_, "reader.toml", reader_text({}));
    set_link_up("vcan0");
    EXPECT_TRUE(reader_.says("interface vcan0: works"));
    EXPECT_EQ(count_of("vcan0: is down", reader_.errors()), 1U) << reader_.errors();
    EXPECT_TRUE(carry_until_control());
    expect_clean_end(sender_);
    expect_clean_end(reader_);
}

}  // namespace
}  // namespace tribus::test::can_reload_test
