#include "tests/bench/subject.h"

#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "pipelines/realtime/clock.h"
#include "tests/bench/tester.h"
#include "transports/links/unique_fd.h"

namespace tribus::bench {
namespace {

/// Longer than any program needs to start, even on a loaded machine.
constexpr Duration kPatience = std::chrono::seconds(10);

tl::expected<std::vector<Lane>, std::string> open_lanes(std::size_t count, Carries carries) {
    std::vector<Lane> lanes;
    for (std::size_t i = 0; i < count; ++i) {
        auto lane = Lane::open(carries);
        if (!lane) {
            return tl::unexpected(lane.error());
        }
        lanes.push_back(std::move(*lane));
    }
    return lanes;
}

std::string filled(std::string word, std::string_view name, const std::string& device) {
    for (std::size_t at = word.find(name); at != std::string::npos; at = word.find(name)) {
        word.replace(at, name.size(), device);
    }
    return word;
}

std::string output_text(const std::string& name, const std::string& device,
                        const ApplianceSettings& settings) {
    const bool sbus = settings.carries == Carries::sbus || settings.carries == Carries::sbus_of_14;
    return fmt::format(
        "[output.{}]\nprotocol = \"{}\"\ndevice = \"{}\"\n{}period = \"{}us\"\nforce = true\n",
        name, sbus ? "sbus" : "ibus", device, sbus ? "" : "channels = 18\n",
        settings.period / std::chrono::microseconds(1));
}

/// All 18 channels go through a rule, as in a user's map.
std::string pipeline_text(std::size_t lane, const std::string& outputs) {
    std::string text = fmt::format(
        "[pipeline.p{0}]\nfrom = \"in{0}\"\nto = [{1}]\n[pipeline.p{0}.channels]\n", lane, outputs);
    for (std::size_t channel = 1; channel <= kChannelCount; ++channel) {
        text += fmt::format("{0} = {{ from = {0}, min = 900, max = 2100 }}\n", channel);
    }
    return text +
           fmt::format("[pipeline.p{}.failsafe]\nhold = \"300ms\"\nrecover = \"0ms\"\n", lane);
}

}  // namespace

std::string runtime_text(const ApplianceSettings& settings) {
    std::string text =
        fmt::format("[runtime]\nrealtime = \"{}\"\n", settings.priority ? "require" : "off");
    text += settings.priority ? fmt::format("priority = {}\n", *settings.priority) : "";
    text += settings.cpu ? fmt::format("cpu = {}\n", *settings.cpu) : "";
    return text;
}

tl::expected<Process, std::string> run_configuration(const std::string& text,
                                                     const ApplianceSettings& settings) {
    // In memory, so that no file is left behind.
    const UniqueFd file(::memfd_create("configuration", MFD_CLOEXEC));
    if (::write(file.get(), text.data(), text.size()) != static_cast<ssize_t>(text.size())) {
        return tl::unexpected(std::string("no memory for a configuration"));
    }
    std::vector<std::string> words = settings.in_front;
    words.insert(words.end(),
                 {settings.program, "run", fmt::format("/proc/self/fd/{}", file.get())});
    return Process::execute(words, {file.get()}, settings.environment);
}

tl::expected<void, std::string> wait_until_started(Process& process) {
    const Instant end = monotonic_now() + kPatience;
    while (process.errors().find("started") == std::string::npos) {
        if (!process.runs() || interrupted() || monotonic_now() > end) {
            return tl::unexpected("tribus run did not start: " + process.errors());
        }
        sleep_until(monotonic_now() + std::chrono::milliseconds(2));
    }
    return {};
}

std::string configuration_text(const std::vector<Lane>& lanes, const ApplianceSettings& settings,
                               const std::vector<Pty>& further_outputs) {
    std::string text = runtime_text(settings);
    for (std::size_t i = 0; i < lanes.size(); ++i) {
        const bool sbus_in = settings.carries == Carries::ibus_of_sbus;
        text += fmt::format("[input.in{}]\nprotocol = \"{}\"\ndevice = \"{}\"\ntimeout = \"1s\"\n",
                            i, sbus_in ? "sbus" : "ibus", lanes[i].in_path());
        text += output_text(fmt::format("out{}", i), lanes[i].out_path(), settings);
        std::string outputs = fmt::format("\"out{}\"", i);
        for (std::size_t further = 0; i == 0 && further < further_outputs.size(); ++further) {
            const std::string name = fmt::format("further{}", further);
            text += output_text(name, further_outputs[further].path, settings);
            outputs += fmt::format(", \"{}\"", name);
        }
        text += pipeline_text(i, outputs);
    }
    return text;
}

Subject::Subject(std::vector<Lane> lanes, Process process, std::vector<Pty> further_outputs)
    : lanes_(std::move(lanes)),
      further_outputs_(std::move(further_outputs)),
      process_(std::move(process)) {}

tl::expected<Subject, std::string> Subject::relay(std::size_t lane_count,
                                                  const RelaySettings& settings) {
    auto lanes = open_lanes(lane_count, Carries::same);
    if (!lanes) {
        return tl::unexpected(lanes.error());
    }
    std::vector<std::pair<std::string, std::string>> devices;
    for (const Lane& lane : *lanes) {
        devices.emplace_back(lane.in_path(), lane.out_path());
    }
    auto process = Process::fork([&] { return run_relay(devices, settings); });
    if (!process) {
        return tl::unexpected(process.error());
    }
    return Subject(std::move(*lanes), std::move(*process), {});
}

tl::expected<Subject, std::string> Subject::appliance(std::size_t lane_count,
                                                      const ApplianceSettings& settings) {
    auto lanes = open_lanes(lane_count, settings.carries);
    if (!lanes) {
        return tl::unexpected(lanes.error());
    }
    std::vector<Pty> further;
    for (std::size_t i = 1; i < settings.outputs_per_input; ++i) {
        auto pty = Pty::open();
        if (!pty) {
            return tl::unexpected(pty.error());
        }
        further.push_back(std::move(*pty));
    }
    auto process = run_configuration(configuration_text(*lanes, settings, further), settings);
    if (!process) {
        return tl::unexpected(process.error());
    }
    return Subject(std::move(*lanes), std::move(*process), std::move(further));
}

tl::expected<Subject, std::string> Subject::command(const std::vector<std::string>& words) {
    auto lanes = open_lanes(1, Carries::same);
    if (!lanes) {
        return tl::unexpected(lanes.error());
    }
    std::vector<std::string> named;
    named.reserve(words.size());
    for (const std::string& word : words) {
        named.push_back(filled(filled(word, "{in}", lanes->front().in_path()), "{out}",
                               lanes->front().out_path()));
    }
    auto process = Process::execute(named);
    if (!process) {
        return tl::unexpected(process.error());
    }
    return Subject(std::move(*lanes), std::move(*process), {});
}

tl::expected<void, std::string> Subject::wait_until_it_carries() {
    const Instant end = monotonic_now() + kPatience;
    Instant next = monotonic_now();
    std::vector<bool> carries(lanes_.size(), false);
    while (std::find(carries.begin(), carries.end(), false) != carries.end()) {
        if (!process_.runs() || interrupted() || monotonic_now() > end) {
            const std::string errors = process_.errors();
            return tl::unexpected(errors.empty() ? "no frame comes through" : errors);
        }
        for (std::size_t i = 0; i < lanes_.size(); ++i) {
            carries[i] = lanes_[i].receive() || carries[i];
            lanes_[i].send();
        }
        next += std::chrono::milliseconds(7);
        sleep_until(next);
    }
    // Waits for frames that are still on their way.
    sleep_until(monotonic_now() + std::chrono::milliseconds(20));
    for (Lane& lane : lanes_) {
        lane.drain();
        lane.start_counting();
    }
    return {};
}

void Subject::drain_further_outputs() {
    std::array<std::uint8_t, 1024> buffer{};
    for (const Pty& pty : further_outputs_) {
        while (::read(pty.master.get(), buffer.data(), buffer.size()) > 0) {
        }
    }
}

std::uint64_t Subject::arrived() const {
    std::uint64_t arrived = 0;
    for (const Lane& lane : lanes_) {
        arrived += lane.counts().arrived;
    }
    return arrived;
}

std::uint64_t Subject::lost() const {
    std::uint64_t lost = 0;
    for (const Lane& lane : lanes_) {
        lost += lane.counts().sent - lane.counts().arrived;
    }
    return lost;
}

std::uint64_t Subject::torn() const {
    std::uint64_t torn = 0;
    for (const Lane& lane : lanes_) {
        torn += lane.counts().torn;
    }
    return torn;
}

tl::expected<Subject, std::string> carrying(tl::expected<Subject, std::string> started) {
    if (!started) {
        return started;
    }
    if (auto carries = started->wait_until_it_carries(); !carries) {
        return tl::unexpected(carries.error());
    }
    return started;
}

}  // namespace tribus::bench
