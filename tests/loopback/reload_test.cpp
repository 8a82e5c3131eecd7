#include <csignal>

#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "tests/loopback/loopback.h"

namespace tribus::test {
namespace {

class Reload : public Loopback {
  protected:
    /// Lets the receiver send 1100 us on channel 1 until a good frame of the servos has `first_us`.
    void expect_first_channel(int first_us) {
        EXPECT_TRUE(eventually([&] {
            repeater_.send_if_due();
            const auto seen = servos_.listen();
            return !seen.empty() && seen.back().good() && seen.back().raw[0] == sbus_raw(first_us);
        })) << "channel 1 never was "
            << first_us;
    }
    std::string with_channel(const std::string& rule) {
        return main_job(kPatientInput, "", "[pipeline.main.channels]\n1 = " + rule);
    }

    FarEnd& receiver_ = device("receiver");
    ServoBank servos_{device("servos")};
    Repeater repeater_{receiver_, ibus_bytes(sticks_with_first(1100))};
};

TEST_F(Reload, TakesANewConfiguration) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    write_config(with_channel("{ from = 1, reverse = true }"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("started", 2));
    expect_first_channel(1900);
    EXPECT_EQ(servos_.strays(), 0U);
    expect_clean_end(program);
}

TEST_F(Reload, RefusesAConfigurationWithMistakesAndGoesOn) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    const std::string path = write_config(with_channel("{ form = 1, reverse = true }"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reload refused"));
    EXPECT_EQ(count_of(path + ":14:7: ", program.errors()), 1U) << program.errors();
    expect_first_channel(1100);
    EXPECT_EQ(count_of("started", program.errors()), 1U);
    EXPECT_EQ(count_of("in failsafe", program.errors()), 0U) << "the refusal was not seamless";
    expect_clean_end(program);
}

TEST_F(Reload, RefusesAConfigurationFileThatIsGoneAndGoesOn) {
    const std::string path = write_config(main_job(kPatientInput));
    Program& program = run(path);
    expect_first_channel(1100);
    std::filesystem::remove(path);
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("reload refused"));
    expect_first_channel(1100);
    expect_clean_end(program);
}

TEST_F(Reload, ReturnsToTheOldConfigurationWhereADeviceOfTheNewOneIsMissing) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    std::string text = with_channel("{ from = 1, reverse = true }");
    text.replace(text.find("@receiver"), 9, "@missing");
    write_config(text);
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("back to the old configuration"));
    EXPECT_TRUE(program.says("missing: there is no such device"));
    expect_first_channel(1100);
    expect_clean_end(program);
}

/// A loose plug and an impatient hand: the outputs that are left must not die of it.
TEST_F(Reload, WhileADeviceIsGoneDoesNotEndTheProgram) {
    Program& program = run(write_config(main_job(kPatientInput)));
    expect_first_channel(1100);
    receiver_.pull();
    EXPECT_TRUE(program.says("is gone"));
    program.signal(SIGHUP);
    EXPECT_TRUE(program.says("back to the old configuration"));
    servos_.listen();
    EXPECT_TRUE(eventually([&] {
        const auto seen = servos_.listen();
        return !seen.empty() && seen.back().failsafe;
    })) << "the output does not say failsafe";
    receiver_.plug_in();
    expect_first_channel(1100);
    EXPECT_TRUE(program.says("is back"));
    expect_clean_end(program);
}

}  // namespace
}  // namespace tribus::test
