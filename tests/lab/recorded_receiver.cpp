#include "tests/lab/recorded_receiver.h"

namespace tribus::test {

std::vector<Sticks> recorded_sticks(Capture capture) {
    return channel_rows("ibus_servo18_afhds3.channels.csv", capture);
}

RecordedReceiver::RecordedReceiver(FarEnd& wire, Capture capture)
    : wire_(wire), bursts_(recording_of("ibus_servo18_afhds3.timed.txt", capture).bursts) {}

void RecordedReceiver::start() {
    next_ = 0;
    started_ = Clock::now();
}

void RecordedReceiver::send_due() {
    while (!ended() && Clock::now() - started_ >= *bursts_[next_].start) {
        latest_ = Clock::now();
        wire_.send(bursts_[next_].bytes);
        ++next_;
    }
}

}  // namespace tribus::test
