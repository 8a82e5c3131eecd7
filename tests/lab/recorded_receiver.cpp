#include "tests/lab/recorded_receiver.h"
#include "tests/support/captures.h"

#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <utility>

#include <gtest/gtest.h>

namespace tribus::test {
namespace {

const std::string kRecording = capture("ibus_servo18_afhds3").string();

}  // namespace

std::vector<Sticks> recorded_sticks() {
    std::ifstream file(kRecording + ".channels.csv");
    std::vector<Sticks> rows;
    std::string line;
    std::getline(file, line);
    while (std::getline(file, line)) {
        std::istringstream cells(line);
        Sticks sticks;
        for (std::string cell; std::getline(cells, cell, ',');) {
            sticks.push_back(std::stoi(cell));
        }
        rows.push_back(std::move(sticks));
    }
    return rows;
}

RecordedReceiver::RecordedReceiver(FarEnd& wire) : wire_(wire) {
    std::ifstream file(kRecording + ".timed.txt");
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    auto recording = parse_recording(text, "recording");
    EXPECT_TRUE(recording && recording->timed) << "the captures are not there";
    if (recording && recording->timed) {
        bursts_ = std::move(recording->bursts);
    }
}

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
