#include "tests/lab/can_bus.h"

#include <net/if.h>
#include <netpacket/packet.h>
#include <sys/socket.h>

#include <algorithm>
#include <cstddef>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <vector>

#include <gtest/gtest.h>

#include "tests/lab/shell.h"
#include "tests/loopback/program.h"
#include "transports/links/unique_fd.h"

namespace tribus::test {
namespace {

// PCI slots of the two cards in run_guest.
constexpr std::string_view kNearSlot = "0000:00:12.0";
constexpr std::string_view kFarSlot = "0000:00:13.0";
constexpr std::string_view kFdSlot = "0000:00:14.0";
// Size of a frame in the kernel. A token bucket of one frame paces every frame.
constexpr unsigned kClassicBytes = 16;
constexpr unsigned kFdBytes = 72;
// The default of a CAN driver.
constexpr std::string_view kQueueFrames = "10";
// Almost no rate: a classic frame takes 16 seconds.
constexpr unsigned kStalledRate = 8;

std::filesystem::path card(std::string_view slot) {
    return std::filesystem::path("/sys/bus/pci/devices") / slot;
}

/// Returns the interfaces of a card in order, once its driver has made them.
std::vector<std::string> interfaces_of(std::string_view slot, std::size_t count) {
    require_guest();
    std::vector<std::string> names;
    EXPECT_TRUE(eventually([&] {
        names.clear();
        std::error_code none;
        for (const auto& entry : std::filesystem::directory_iterator(card(slot) / "net", none)) {
            names.push_back(entry.path().filename());
        }
        return names.size() == count;
    })) << "no CAN interface at "
        << slot;
    names.resize(count);
    std::sort(names.begin(), names.end());
    return names;
}

std::string interface_of(std::string_view slot) {
    return interfaces_of(slot, 1).front();
}

/// A queue sleeps until a time that it calculated with its old rate, unless a packet arrives. This
/// one is no CAN frame, so the interface drops it.
void wake_queue(const std::string& interface) {
    const UniqueFd packets(::socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, 0));
    sockaddr_ll address{};
    address.sll_family = AF_PACKET;
    address.sll_ifindex = static_cast<int>(interface_index(interface));
    const char nothing = 0;
    const auto* any = reinterpret_cast<const sockaddr*>(&address);
    // If the queue is full, the packet is refused, but it still wakes the queue.
    ::sendto(packets.get(), &nothing, sizeof(nothing), 0, any, sizeof(address));
}

}  // namespace

void set_link_up(const std::string& interface) {
    shell("ip link set dev " + interface + " up");
}

void set_link_down(const std::string& interface) {
    shell("ip link set dev " + interface + " down");
}

void swap_names(const std::string& one, const std::string& other) {
    const auto set = [](const std::string& interface, const std::string& what) {
        return " 'link set dev " + interface + " " + what + "'";
    };
    shell("printf '%s\\n'" + set(one, "down") + set(other, "down") + set(one, "name swapped") +
          set(other, "name " + one) + set("swapped", "name " + other) + set(one, "up") +
          set(other, "up") + " | ip -batch -");
}

unsigned interface_index(const std::string& interface) {
    return ::if_nametoindex(interface.c_str());
}

VirtualBus::VirtualBus(const std::string& name) : name_(name) {
    create();
}

VirtualBus::~VirtualBus() {
    if (there_) {
        remove();
    }
}

void VirtualBus::down() const {
    set_link_down(name_);
}

void VirtualBus::up() const {
    set_link_up(name_);
}

void VirtualBus::remove() {
    shell("ip link del dev " + name_);
    there_ = false;
}

void VirtualBus::create() {
    shell("ip link add dev " + name_ + " up mtu 72 type vcan");
    there_ = true;
}

PacedBus::PacedBus(unsigned bits_per_second, Kind kind, const std::string& name)
    : kind_(kind), rate_(bits_per_second), near_(name + "0"), far_(name + "1") {
    const std::string mtu = std::to_string(kind_ == Kind::fd ? kFdBytes : kClassicBytes);
    // Neither end can be up before it knows the other one.
    shell("printf '%s\\n' 'link add dev " + near_ + " mtu " + mtu + " type vxcan peer name " +
          far_ + " mtu " + mtu + "' 'link set dev " + near_ + " up' 'link set dev " + far_ +
          " up' | ip -batch -");
    set_rate(near_, rate_);
    set_rate(far_, rate_);
}

PacedBus::~PacedBus() {
    run_shell("ip link del dev " + near_);
}

void PacedBus::stall() const {
    set_rate(near_, kStalledRate);
}

void PacedBus::flow() const {
    set_rate(near_, rate_);
    wake_queue(near_);
}

void PacedBus::set_rate(const std::string& end, unsigned bits_per_second) const {
    const unsigned burst = (kind_ == Kind::fd ? kFdBytes : kClassicBytes) + 1;
    // The first command sets the inner queue to its own length, so the second one must follow each
    // time.
    shell("printf '%s\\n' 'qdisc replace dev " + end + " root handle 1: tbf rate " +
          std::to_string(bits_per_second) + "bit burst " + std::to_string(burst) +
          " limit 10000' 'qdisc replace dev " + end + " parent 1:1 handle 2: pfifo limit " +
          std::string(kQueueFrames) + "' | tc -batch -");
}

ControllerPair::ControllerPair(unsigned bits_per_second, const std::string& options)
    : near_(interface_of(kNearSlot)),
      far_(interface_of(kFarSlot)),
      rate_(bits_per_second),
      options_(options) {
    configure(near_, rate_, options_);
    configure(far_, rate_, options_);
}

ControllerPair::~ControllerPair() {
    if (near_.empty()) {
        plug();
    }
    run_shell("ip link set dev " + near_ + " down; ip link set dev " + far_ + " down");
}

void ControllerPair::unplug() {
    write_kernel_file(card(kNearSlot) / "remove", "1");
    near_.clear();
}

void ControllerPair::plug() {
    write_kernel_file("/sys/bus/pci/rescan", "1");
    near_ = interface_of(kNearSlot);
    configure(near_, rate_, options_);
}

void ControllerPair::configure(const std::string& interface, unsigned bits_per_second,
                               const std::string& options) const {
    shell("ip link set dev " + interface + " down && ip link set dev " + interface +
          " up type can bitrate " + std::to_string(bits_per_second) + " " + options);
}

FdControllerPair::FdControllerPair() {
    require_guest();
    shell("modprobe ctucanfd_pci");
    const std::vector<std::string> names = interfaces_of(kFdSlot, 2);
    near_ = names.front();
    far_ = names.back();
    for (const std::string& name : names) {
        shell("ip link set dev " + name + " up type can bitrate 1000000 dbitrate 4000000 fd on");
    }
}

FdControllerPair::~FdControllerPair() {
    run_shell("ip link set dev " + near_ + " down; ip link set dev " + far_ + " down");
}

}  // namespace tribus::test
