#include <sys/eventfd.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "config/build/build.h"
#include "config/build/carry_over.h"
#include "config/load.h"
#include "pipelines/realtime/data_thread.h"
#include "tests/support/seen_within.h"

/// Reloads of a running loop whose links always have an event pending on each of their descriptors.
/// The address sanitizer sees here when the data thread uses what a reload has destroyed.
namespace tribus::test::loop_reload_test {
namespace {

/// One kind of link, and an input that needs it.
struct LinkKind {
    std::string name;
    std::string device;
    std::string input;
    int descriptors = 1;
    bool each_arrival = false;

    friend void PrintTo(const LinkKind& kind, std::ostream* stream) { *stream << kind.name; }
};

const std::vector<LinkKind>& kinds() {
    static const std::vector<LinkKind> all{
        {"Terminal", "/dev/ttyS7", "protocol = \"sbus\"\ndevice = \"/dev/ttyS7\"\n", 1, true},
        {"Network", "127.0.0.1:14550", "protocol = \"crsf\"\naddress = \"127.0.0.1:14550\"\n"},
        {"Gamepad", "/dev/input/event9",
         "protocol = \"gamepad\"\ndevice = \"/dev/input/event9\"\naxes = { ABS_X = 1 }\n", 2},
        {"PulseLine", "GPIO17", "protocol = \"ppm\"\nline = \"GPIO17\"\n", 2},
        {"Can", "can0", "protocol = \"can\"\ninterface = \"can0\"\n", 2},
        {"OtherTerminal", "/dev/ttyS8", "protocol = \"sbus\"\ndevice = \"/dev/ttyS8\"\n", 1, true},
        {"OtherCan", "can1", "protocol = \"can\"\ninterface = \"can1\"\n", 2},
    };
    return all;
}

/// Descriptors that are always ready.
struct Pending {
    explicit Pending(int count) {
        for (int i = 0; i < count; ++i) {
            events.emplace_back(::eventfd(1, EFD_NONBLOCK | EFD_CLOEXEC));
        }
    }
    int of(std::size_t index) const { return index < events.size() ? events[index].get() : -1; }

    std::vector<UniqueFd> events{};
};

std::atomic<int> reads = 0;

class PendingBytes final : public ByteLink {
  public:
    explicit PendingBytes(const LinkKind& kind)
        : pending_(kind.descriptors), each_arrival_(kind.each_arrival) {}
    int descriptor() const override { return pending_.of(0); }
    int second_descriptor() const override { return pending_.of(1); }
    bool wakes_at_each_arrival() const override { return each_arrival_; }
    ReadStatus read(Reception& reception) override {
        ++reads;
        reception.count = 0;
        reception.full = false;
        reception.goes_on = false;
        return ReadStatus::nothing;
    }
    WriteStatus write(std::span<const std::uint8_t>) override { return WriteStatus::written; }
    void discard_unread() override {}

  private:
    Pending pending_;
    bool each_arrival_;
};

class PendingCan final : public CanLink {
  public:
    explicit PendingCan(const LinkKind& kind) : pending_(kind.descriptors) {}
    int descriptor() const override { return pending_.of(0); }
    int second_descriptor() const override { return pending_.of(1); }
    ReadStatus read(CanReception& reception, Instant, Duration) override {
        ++reads;
        reception.count = 0;
        reception.full = false;
        return ReadStatus::nothing;
    }
    WriteStatus write(std::size_t, std::span<const CanFrame>, Instant) override {
        return WriteStatus::written;
    }
    Instant poll(Instant) override { return kNever; }
    CanBusState state() const override { return {}; }
    CanLinkStatus status() const override { return {}; }

  private:
    Pending pending_;
};

std::unique_ptr<Link> link_of(const std::string& device) {
    const auto kind = std::ranges::find(kinds(), device, &LinkKind::device);
    if (kind == kinds().end()) {
        return nullptr;
    }
    if (kind->name.ends_with("Can")) {
        return std::make_unique<PendingCan>(*kind);
    }
    return std::make_unique<PendingBytes>(*kind);
}

/// One loop, the configuration that it runs, and the descriptors of its links.
struct Set {
    explicit Set(const std::vector<LinkKind>& inputs) {
        std::string text;
        std::string names;
        for (const LinkKind& input : inputs) {
            text += "[input." + input.name + "]\n" + input.input;
            names += (names.empty() ? "\"" : ", \"") + input.name + "\"";
        }
        text += "[output.servos]\nprotocol = \"ibus\"\ndevice = \"/dev/none\"\n[pipeline.main]\n";
        text += "from = [" + names + "]\nto = \"servos\"\n";
        auto loaded = load_configuration(text, "test.toml");
        EXPECT_TRUE(loaded) << text << (loaded ? "" : loaded.error().front().text);
        configuration = std::move(*loaded);
        engine = build_engine(configuration);
        plans = plan_ports(configuration);
    }
    void make_loop(const std::vector<PortCarry>& carried) {
        std::vector<PortWiring> wiring;
        std::vector<std::unique_ptr<Link>> links;
        for (std::size_t port = 0; port < plans.size(); ++port) {
            wiring.push_back(plans[port].wiring);
            const bool has_link = carried.empty() || !carried[port].takes_link;
            links.push_back(has_link ? link_of(plans[port].config.device) : nullptr);
            if (links.back() != nullptr) {
                descriptors.push_back(links.back()->descriptor());
                descriptors.push_back(links.back()->second_descriptor());
            }
        }
        loop = std::make_unique<Loop>(*engine, std::move(wiring), std::move(links));
        EXPECT_TRUE(loop->prepare());
    }
    std::vector<PortCarry> carried_from(const Set& before) const {
        std::vector<PortCarry> carried;
        for (const PortPlan& plan : plans) {
            const auto known = std::ranges::find_if(before.plans, [&](const PortPlan& plan_before) {
                return plan_before.config.device == plan.config.device;
            });
            carried.push_back(
                known == before.plans.end()
                    ? PortCarry{}
                    : PortCarry{.from = static_cast<std::size_t>(known - before.plans.begin()),
                                .takes_link = true});
        }
        return carried;
    }

    Configuration configuration;
    std::unique_ptr<Engine> engine;
    std::vector<PortPlan> plans;
    std::unique_ptr<Loop> loop;
    std::vector<int> descriptors{};
};

/// Whether an epoll descriptor of this process watches `descriptor`: the kernel lists what it
/// watches as lines `tfd: NUMBER` (proc(5)).
bool is_watched(int descriptor) {
    for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fdinfo")) {
        std::ifstream info(entry.path());
        for (std::string word; info >> word;) {
            int watched = -1;
            if (word == "tfd:" && info >> watched && watched == descriptor) {
                return true;
            }
        }
    }
    return false;
}

/// Waits until the loop has read `more` times since there were `before` reads.
void expect_reads(int more, int before = reads) {
    EXPECT_TRUE(seen_within([&] { return reads >= before + more; }));
}

/// Runs `before`, reloads to `after`, destroys what `after` did not take, and runs on.
void reload(const std::vector<LinkKind>& inputs_before, const std::vector<LinkKind>& inputs_after) {
    auto before = std::make_unique<Set>(inputs_before);
    Set after(inputs_after);
    before->make_loop({});
    DataThread thread(*before->loop, SchedulingSettings{.cpu = {}, .realtime = false});
    ASSERT_TRUE(thread.prepare());
    const int before_it_runs = reads;
    thread.run();
    expect_reads(1, before_it_runs);

    const CarryOver carry = plan_carry_over(before->configuration, after.configuration);
    EXPECT_TRUE(carry.obstacles.empty());
    const std::vector<PortCarry> ports = after.carried_from(*before);
    after.make_loop(ports);
    thread.hand_over_to(*after.loop,
                        {.engine = carry.engine, .values = carry.values, .ports = ports});
    for (std::size_t port = 0; port < after.plans.size(); ++port) {
        EXPECT_EQ(after.loop->take_lost(port), nullptr) << after.plans[port].config.device;
    }
    for (std::size_t port = 0; port < before->plans.size(); ++port) {
        const bool taken = std::ranges::any_of(ports, [&](const PortCarry& carried) {
            return carried.from == CarriedFrom(port) && carried.takes_link;
        });
        const auto kind =
            std::ranges::find(kinds(), before->plans[port].config.device, &LinkKind::device);
        if (!taken && kind != kinds().end()) {
            const auto dropped = static_cast<std::size_t>(kind->descriptors);
            for (std::size_t i = 0; i < dropped; ++i) {
                EXPECT_FALSE(is_watched(before->descriptors[2 * port + i]))
                    << kind->name << ", descriptor " << i;
            }
        }
    }
    before.reset();
    // Events of terminals are told once; the others come again and again.
    if (!std::ranges::all_of(inputs_after, &LinkKind::each_arrival)) {
        expect_reads(20);
    }
    after.loop->request_end();
    thread.join();
}

class LoopReload : public testing::TestWithParam<LinkKind> {};

TEST_P(LoopReload, DropsTheLink) {
    for (const LinkKind& stays : kinds()) {
        if (stays.name != GetParam().name) {
            reload({GetParam(), stays}, {stays});
            reload({stays, GetParam()}, {stays});
        }
    }
}

TEST_P(LoopReload, AddsTheLink) {
    for (const LinkKind& stays : kinds()) {
        if (stays.name != GetParam().name) {
            reload({stays}, {GetParam(), stays});
        }
    }
}

TEST_P(LoopReload, AddsAllOtherLinksBesideIt) {
    std::vector<LinkKind> all{GetParam()};
    for (const LinkKind& other : kinds()) {
        if (other.name != GetParam().name) {
            all.push_back(other);
        }
    }
    reload({GetParam()}, all);
    reload(all, {GetParam()});
}

TEST_P(LoopReload, ChangesTheLinkForAnother) {
    for (const LinkKind& other : kinds()) {
        if (other.name != GetParam().name) {
            reload({GetParam()}, {other});
        }
    }
}

INSTANTIATE_TEST_SUITE_P(Links, LoopReload, testing::ValuesIn(kinds()),
                         [](const auto& kind) { return kind.param.name; });

}  // namespace
}  // namespace tribus::test::loop_reload_test
