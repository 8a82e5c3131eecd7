#include "app/init/dialogue.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "app/doctor/line_advice.h"
#include "tests/unit/app/init/examined_places.h"
#include "transports/codecs/dronecan/dronecan.h"
#include "transports/codecs/ibus/ibus.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/codecs/sbus/sbus.h"
#include "transports/links/can/can_medium.h"
#include "transports/links/serial/serial_medium.h"

namespace tribus::init::test::dialogue_test {
namespace {

/// Ports that a test describes. `listen` returns the stories of a port in turn, then always the
/// last.
class DescribedPorts : public Ports {
  public:
    std::vector<ExaminedPlace> ports;
    std::map<std::string, std::vector<doctor::LineStory>> stories;  ///< by node
    std::map<std::string, std::string> refusals;                    ///< by node
    std::size_t listened = 0;

    std::vector<ExaminedPlace> all() override { return ports; }
    ExaminedPlace look(const std::string& place) override {
        for (const ExaminedPlace& examined : ports) {
            if (examined.name == place || examined.node == place) {
                return examined;
            }
        }
        ExaminedPlace examined = interface_named(place);
        examined.known = place.find('/') != std::string::npos;
        examined.medium = examined.known ? &kSerialMedium : &kCanMedium;
        return examined;
    }
    ExaminedPlace listen(const std::string& place) override {
        ExaminedPlace examined = look(place);
        const auto& heard = stories[examined.node];
        if (!heard.empty()) {
            examined.story = heard[std::min(listened, heard.size() - 1)];
            examined.findings = doctor::judge_story(*examined.story, examined.node);
        }
        ++listened;
        return examined;
    }
    std::string try_line(ExaminedPlace& examined, const LineSettings& /*line*/) override {
        return refusals[examined.node];
    }
};

class InitDialogue : public testing::Test {
  protected:
    InitDialogue() { ports.ports = {free_port("0"), free_port("1"), interface_named("can0")}; }

    /// Answers the questions with these lines.
    Dialogue& answers(const std::string& lines) {
        in_.clear();
        in_.str(lines);
        return dialogue_;
    }
    /// Whether this was printed; line breaks do not matter.
    bool said(const std::string& text) const {
        std::istringstream words(out_.str());
        std::string all;
        for (std::string word; words >> word;) {
            all += word + " ";
        }
        return all.find(text) != std::string::npos;
    }
    std::string all_said() const { return out_.str(); }
    bool all_answers_read() { return in_.peek() == std::istringstream::traits_type::eof(); }

    DescribedPorts ports;

  private:
    std::istringstream in_;
    std::ostringstream out_;
    Messages messages_{out_, 40, false};
    Dialogue dialogue_{in_, true, messages_, ports};
};

Attachment taken(const std::string& number) {
    return *decide_input(free_port(number), &kIbusProtocol).attachment;
}

TEST_F(InitDialogue, EnterTakesTheFirstFreePortAndWhatIsHeardThere) {
    ports.ports[0] = with_problem(free_port("0"), "port.in_use", "it is in use by cat");
    ports.stories["/dev/ttyUSB1"] = {heard_ibus()};
    const auto input = answers("\n").ask_input();
    ASSERT_TRUE(input) << all_said();
    EXPECT_EQ(input->node, "/dev/ttyUSB1");
    EXPECT_EQ(input->protocol, &kIbusProtocol);
    EXPECT_TRUE(said("it is in use by cat")) << all_said();
    EXPECT_TRUE(said("Heard: i.Bus, 14 channels")) << all_said();
}

TEST_F(InitDialogue, APortIsChosenByNumberNameOrPath) {
    for (const std::string answer : {"2", "/dev/ttyUSB1", "/dev/serial/by-id/usb-FTDI_1"}) {
        ports.stories["/dev/ttyUSB1"] = {heard_sbus()};
        const auto input = answers(answer + "\n").ask_input();
        ASSERT_TRUE(input) << answer;
        EXPECT_EQ(input->name, "/dev/serial/by-id/usb-FTDI_1") << answer;
        EXPECT_EQ(input->protocol, &kSbusProtocol) << answer;
    }
}

TEST_F(InitDialogue, AWrongAnswerIsAskedForAgainWithWhatIsAllowed) {
    ports.stories["/dev/ttyUSB1"] = {heard_ibus()};
    const auto input = answers("7\nttyUSB9\n 2 \r\n").ask_input();
    ASSERT_TRUE(input) << all_said();
    EXPECT_EQ(input->node, "/dev/ttyUSB1");
    EXPECT_TRUE(said("There is no serial device and no CAN interface \"7\"")) << all_said();
    EXPECT_TRUE(said("There is no serial device and no CAN interface \"ttyUSB9\"")) << all_said();
    EXPECT_TRUE(said("allowed: 1 to 3, a path such as")) << all_said();
    EXPECT_TRUE(all_answers_read());
}

TEST_F(InitDialogue, AfterSilenceEnterListensAgain) {
    ports.stories["/dev/ttyUSB0"] = {doctor::LineStory(), heard_ibus()};
    const auto input = answers("1\n\n").ask_input();
    ASSERT_TRUE(input) << all_said();
    EXPECT_EQ(ports.listened, 2U);
    EXPECT_TRUE(said("nothing was heard")) << all_said();
}

TEST_F(InitDialogue, AfterSilenceAnotherPortCanBeChosen) {
    ports.stories["/dev/ttyUSB0"] = {doctor::LineStory()};
    ports.stories["/dev/ttyUSB1"] = {heard_ibus()};
    const auto input = answers("1\nother\n2\n").ask_input();
    ASSERT_TRUE(input) << all_said();
    EXPECT_EQ(input->node, "/dev/ttyUSB1");
}

TEST_F(InitDialogue, AfterSilenceTheProtocolCanBeNamed) {
    ports.stories["/dev/ttyUSB0"] = {doctor::LineStory()};
    const auto input = answers("1\nsbus\n").ask_input();
    ASSERT_TRUE(input) << all_said();
    EXPECT_EQ(input->protocol, &kSbusProtocol);
}

/// What a person sees when nothing was heard, from the question to the cursor.
TEST_F(InitDialogue, AfterSilenceQuestionAndReasonAreOnOneSmallScreenTheReasonLast) {
    ports.stories["/dev/ttyUSB0"] = {doctor::LineStory()};
    std::istringstream in("1\n");
    std::ostringstream out;
    Messages messages(out, 60, false);
    EXPECT_FALSE(Dialogue(in, true, messages, ports).ask_input());
    const std::string asked = out.str().substr(out.str().find("What now?"));
    EXPECT_LE(std::ranges::count(asked, '\n'), 20) << asked;
    for (const Protocol* protocol : offered_protocols(SettingScope::input, kSerialMedium)) {
        EXPECT_NE(asked.find("  " + std::string(protocol->name)), std::string::npos) << asked;
    }
    EXPECT_LT(asked.find("mavlink"), asked.find("[line.silence]")) << asked;
    EXPECT_LT(asked.find("[line.silence]"), asked.find("/dev/ttyUSB0: nothing was heard."));
    EXPECT_NE(asked.find("/dev/ttyUSB0: nothing was heard.\nA number; Enter takes 1.\n> "),
              std::string::npos)
        << asked;
}

TEST_F(InitDialogue, AfterSilenceSaysThePortOnce) {
    ports.stories["/dev/ttyUSB0"] = {doctor::LineStory()};
    EXPECT_FALSE(answers("1\n").ask_input());
    const std::string asked = all_said().substr(all_said().find("What now?"));
    const std::size_t first = asked.find("/dev/ttyUSB0");
    EXPECT_NE(first, std::string::npos) << asked;
    EXPECT_EQ(asked.find("/dev/ttyUSB0", first + 1), std::string::npos) << asked;
}

TEST_F(InitDialogue, AProtocolThatThePortCannotRunIsRefused) {
    ports.ports = {mini_uart()};
    ports.stories["/dev/ttyS0"] = {doctor::LineStory()};
    const auto input = answers("1\nsbus\nibus\n").ask_input();
    ASSERT_TRUE(input) << all_said();
    EXPECT_EQ(input->protocol, &kIbusProtocol);
    EXPECT_TRUE(said("it has no parity bit")) << all_said();
}

TEST_F(InitDialogue, TheProtocolOfAnInterfaceIsAskedFor) {
    const auto native = answers("can0\n\n").ask_input();
    ASSERT_TRUE(native) << all_said();
    EXPECT_EQ(native->protocol, &kCanProtocol);
    const auto dronecan = answers("3\ndronecan\n").ask_input();
    ASSERT_TRUE(dronecan) << all_said();
    EXPECT_EQ(dronecan->protocol, &kDroneCanProtocol);
    EXPECT_EQ(ports.listened, 0U);
}

TEST_F(InitDialogue, AnSpiPortIsOfferedForSbusWithoutAnInverter) {
    ports.ports = {free_port("0"), spi_port()};
    const auto output = answers("2\n\n").ask_output({taken("0")});
    ASSERT_TRUE(output) << all_said();
    EXPECT_EQ(output->protocol, &kSbusProtocol);
    EXPECT_EQ(output->medium, &kSpiSerialMedium);
    EXPECT_TRUE(said("/dev/spidev0.0: SPI port: SBUS without an inverter")) << all_said();
}

TEST_F(InitDialogue, AnSpiPortCarriesOneInputOrOneOutput) {
    ports.ports = {spi_port(), free_port("0")};
    Attachment input{.protocol = &kSbusProtocol,
                     .medium = &kSpiSerialMedium,
                     .name = "/dev/spidev0.0",
                     .node = "/dev/spidev0.0"};
    const auto output = answers("1\n\n2\n\n").ask_output({input});
    ASSERT_TRUE(output) << all_said();
    EXPECT_EQ(output->node, "/dev/ttyUSB0");
    EXPECT_TRUE(said("/dev/spidev0.0 carries one input or one output; use another port"));
}

TEST_F(InitDialogue, TheProtocolOfAnInputAtAnSpiPortIsAskedFor) {
    ports.ports = {spi_port()};
    const auto input = answers("1\n\n").ask_input();
    ASSERT_TRUE(input) << all_said();
    EXPECT_EQ(input->protocol, &kSbusProtocol);
    EXPECT_EQ(ports.listened, 0U);
}

TEST_F(InitDialogue, EnterTakesSbusAtAPortOtherThanThatOfTheInput) {
    const auto output = answers("\n\n").ask_output({taken("0")});
    ASSERT_TRUE(output) << all_said();
    EXPECT_EQ(output->node, "/dev/ttyUSB1");
    EXPECT_EQ(output->protocol, &kSbusProtocol);
}

TEST_F(InitDialogue, ProtocolsThatThePortCannotRunAreNotOffered) {
    ports.ports = {mini_uart()};
    const auto output = answers("1\n99\n1\n").ask_output({});
    ASSERT_TRUE(output) << all_said();
    EXPECT_EQ(output->protocol, &kIbusProtocol);
    EXPECT_TRUE(said("sbus is impossible at this port: it has no parity bit")) << all_said();
    EXPECT_TRUE(said("\"99\" is not one of them")) << all_said();
}

TEST_F(InitDialogue, AnOutputThatItsPortRefusesIsAskedForAgain) {
    ports.refusals["/dev/ttyUSB0"] = "asked for 100000 baud, it made 115200";
    const auto output = answers("1\nsbus\n2\nsbus\n").ask_output({});
    ASSERT_TRUE(output) << all_said();
    EXPECT_EQ(output->node, "/dev/ttyUSB1");
    EXPECT_TRUE(said("asked for 100000 baud")) << all_said();
}

TEST_F(InitDialogue, AnOutputOnThePortOfAnInputMustHaveTheSameRate) {
    const auto output = answers("1\nsbus\n1\nibus\n").ask_output({taken("0")});
    ASSERT_TRUE(output) << all_said();
    EXPECT_EQ(output->node, "/dev/ttyUSB0");
    EXPECT_EQ(output->protocol, &kIbusProtocol);
    EXPECT_TRUE(said("a port has one rate and parity")) << all_said();
}

TEST_F(InitDialogue, WithoutAPortEnterLooksAgain) {
    ports.ports.clear();
    EXPECT_FALSE(answers("\n\n").ask_output({}));
    EXPECT_TRUE(said("No serial port and no CAN interface was found")) << all_said();
}

TEST_F(InitDialogue, TheThrottleIsLowCentredOrAPulse) {
    EXPECT_EQ(answers("\n").ask_throttle(), 988);
    EXPECT_EQ(answers("2\n").ask_throttle(), 1500);
    EXPECT_EQ(answers("1100\n").ask_throttle(), 1100);
    EXPECT_EQ(answers("1100 us\n").ask_throttle(), 1100);
    EXPECT_EQ(answers("3\n2501\nlow\n500us\n").ask_throttle(), 500);
    EXPECT_TRUE(said("\"2501\" is not allowed")) << all_said();
}

TEST_F(InitDialogue, EveryQuestionReturnsNothingIfTheAnswersEnd) {
    ports.stories["/dev/ttyUSB0"] = {doctor::LineStory()};
    EXPECT_FALSE(answers("").ask_input());
    EXPECT_FALSE(answers("1\n").ask_input());
    EXPECT_FALSE(answers("can0\n").ask_input());
    EXPECT_FALSE(answers("").ask_output({}));
    EXPECT_FALSE(answers("1\n").ask_output({}));
    EXPECT_FALSE(answers("x\n").ask_throttle());
}

TEST_F(InitDialogue, KeepsTo40Columns) {
    ports.ports = {with_problem(free_port("0"), "port.in_use", "it is in use by cat"), mini_uart()};
    ports.stories["/dev/ttyS0"] = {doctor::LineStory()};
    answers("x\n\nibus\n").ask_input();
    answers("x\n2\n").ask_output({});
    answers("x\n").ask_throttle();
    std::istringstream lines(all_said());
    for (std::string line; std::getline(lines, line);) {
        EXPECT_LE(line.size(), 40U) << line;
    }
}

}  // namespace
}  // namespace tribus::init::test::dialogue_test
