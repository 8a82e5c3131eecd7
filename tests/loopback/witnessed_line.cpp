#include "tests/loopback/witnessed_line.h"

#include <cstddef>

#include <fmt/format.h>

namespace tribus::test {

WitnessedLine::WitnessedLine(FarEnd& receiver, FarEnd& servos, unsigned number,
                             Clock::duration most_age, MachineStops& stops)
    : receiver_(receiver),
      servos_(servos),
      number_(number),
      ibus_(number % 2 == 0),
      witness_(number, most_age, stops),
      random_(number + 1),
      due_(Clock::now() + std::chrono::milliseconds(number)) {}

std::string WitnessedLine::configuration(std::string_view input, std::string_view failsafe) const {
    return fmt::format(
        "[input.r{0}]\nprotocol = \"{1}\"\ndevice = \"{2}\"\n{3}\n"
        "[output.s{0}]\nprotocol = \"sbus\"\ndevice = \"{4}\"\nperiod = \"{6}ms\"\n"
        "[pipeline.p{0}]\nfrom = \"r{0}\"\nto = \"s{0}\"\n[pipeline.p{0}.failsafe]\n{5}\n",
        number_, ibus_ ? "ibus" : "sbus", receiver_.path(), input, servos_.path(), failsafe,
        kOutputPeriod.count());
}

Bytes WitnessedLine::frame() {
    const Sticks sticks = witness_.next();
    if (ibus_) {
        return ibus_bytes(sticks);
    }
    SbusSight sight = sbus_sight_of(sticks);
    sight.channel_17 = false;
    sight.channel_18 = false;
    return sbus_bytes(sight);
}

Bytes WitnessedLine::damaged(Bytes frame) {
    // A byte added before the frame, or equal to the one in its place, would leave the frame whole.
    const auto place = static_cast<std::ptrdiff_t>(1 + random_() % (frame.size() - 2));
    const auto added =
        static_cast<std::uint8_t>(frame[static_cast<std::size_t>(place)] + 1 + random_() % 255);
    switch (random_() % 4) {
        case 0:
            frame.erase(frame.begin() + place);
            break;
        case 1:
            frame.insert(frame.begin() + place, added);
            break;
        case 2:
            frame.erase(frame.begin(), frame.begin() + place);
            break;
        default:
            frame.erase(frame.begin() + place, frame.end());
    }
    return frame;
}

void WitnessedLine::send(Bytes frame) {
    const bool hurts = std::bernoulli_distribution(hurt_share_)(random_);
    hurt_ += hurts ? 1U : 0U;
    const bool taken = receiver_.send(hurts ? damaged(std::move(frame)) : frame);
    hurts || !taken ? witness_.spoiled() : witness_.sent();
}

void WitnessedLine::turn() {
    const auto now = Clock::now();
    if (now >= due_) {
        due_ += std::chrono::milliseconds(ibus_ ? 7 : 14);
        if (!pulled_ && now >= silent_until_) {
            send(frame());
        }
    }
    witness_.listen(servos_);
}

void WitnessedLine::pull_in_a_frame() {
    const Bytes whole = frame();
    receiver_.send(std::span(whole).first(whole.size() / 2));
    witness_.spoiled();
    receiver_.pull();
    pulled_ = true;
}

void WitnessedLine::plug_in() {
    receiver_.plug_in();
}

void WitnessedLine::go_on() {
    const Bytes whole = frame();
    receiver_.send(std::span(whole).subspan(whole.size() / 2));
    witness_.spoiled();
    pulled_ = false;
}

}  // namespace tribus::test
