#include "tests/bench/daemon_counts.h"

#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <string_view>

#include "app/bench/latency.h"
#include "app/bench/subject.h"
#include "app/bench/tester.h"

namespace tribus::bench {
namespace {

using Refused = tl::unexpected<std::string>;

/// Counts from the start of the program to its end.
tl::expected<std::uint64_t, std::string> instructions_of_run(std::uint64_t frames) {
    ApplianceSettings ours;
    ours.program = TRIBUS_PROGRAM;
    ours.carries = Carries::sbus;
    ours.period = std::chrono::milliseconds(7);
    ours.in_front = {"valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null"};
    auto subject = Subject::appliance(1, ours);
    if (!subject) {
        return Refused(subject.error());
    }
    if (auto carries = subject->wait_until_it_carries(kFramePeriod); !carries) {
        return Refused(carries.error());
    }
    const TesterPriority priority;
    drive(*subject, {.period = std::chrono::microseconds(7700), .rounds = frames});
    subject->process().end();
    const std::string said = subject->process().errors();
    constexpr std::string_view kMark = "Collected : ";
    const std::size_t at = said.find(kMark);
    if (at == said.npos) {
        return Refused("callgrind counted nothing: " + said);
    }
    return std::strtoull(said.c_str() + at + kMark.size(), nullptr, 10);
}

}  // namespace

tl::expected<double, std::string> instructions_a_frame() {
    constexpr std::uint64_t kFew = 200;
    constexpr std::uint64_t kMany = 1000;
    const auto few = instructions_of_run(kFew);
    const auto many = instructions_of_run(kMany);
    if (!few || !many) {
        return Refused(few ? many.error() : few.error());
    }
    return static_cast<double>(*many - *few) / static_cast<double>(kMany - kFew);
}

}  // namespace tribus::bench
