#include "pipelines/realtime/scheduling.h"

#include <fcntl.h>
#include <pthread.h>
#include <sched.h>
#include <sys/prctl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <cstring>

#include "pipelines/realtime/locked_memory.h"

namespace tribus {
namespace {

using Missing = std::vector<std::string>;

std::string reason(int error) {
    return std::strerror(error);
}

void pin(int cpu, Missing& missing) {
    cpu_set_t cpus;
    CPU_ZERO(&cpus);
    CPU_SET(static_cast<std::size_t>(cpu), &cpus);
    const int error = ::pthread_setaffinity_np(::pthread_self(), sizeof cpus, &cpus);
    if (error != 0) {
        missing.push_back("the data thread is not pinned to CPU " + std::to_string(cpu) + " (" +
                          reason(error) + "); choose a CPU that `nproc` counts, from 0");
    }
}

void run_first(int priority, Missing& missing) {
    const sched_param parameters{.sched_priority = priority};
    const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
    if (error != 0) {
        missing.push_back("the data thread has no real-time priority (" + reason(error) +
                          "); run as root, or give CAP_SYS_NICE or `ulimit -r " +
                          std::to_string(priority) + "`");
    }
}

void keep_in_memory(Missing& missing) {
    const int error = lock_memory();
    if (error != 0) {
        missing.push_back("not all memory is locked (" + reason(error) +
                          "); run as root, or give CAP_IPC_LOCK or `ulimit -l unlimited`");
    }
}

/// Touches the stack from below this function's frame down to `end`, at most `kRealtimeStackBytes`.
[[gnu::noinline, gnu::no_sanitize_address]] void touch_stack_to(const void* end) {
    constexpr std::ptrdiff_t kOwnFrame = 1024;
    constexpr std::ptrdiff_t kPageBytes = 4096;
    auto* const here = static_cast<volatile std::uint8_t*>(__builtin_frame_address(0));
    const std::ptrdiff_t deepest = std::min<std::ptrdiff_t>(
        here - static_cast<const volatile std::uint8_t*>(end), kRealtimeStackBytes);
    for (std::ptrdiff_t depth = kOwnFrame; depth <= deepest; depth += kPageBytes) {
        *(here - depth) = 0;
    }
}

/// Touches the stack to its end, so that its pages are present. Thread-local storage takes a part
/// of the size that a stack was made with.
void touch_stack() {
    pthread_attr_t attributes;
    if (::pthread_getattr_np(::pthread_self(), &attributes) != 0) {
        return;
    }
    void* end = nullptr;
    std::size_t size = 0;
    ::pthread_attr_getstack(&attributes, &end, &size);
    ::pthread_attr_destroy(&attributes);
    touch_stack_to(end);
}

/// Waking a processor from deep sleep takes longer than all work on a frame: with a limit of 0 us,
/// the p50 of the latency through two ptys fell to a third.
UniqueFd limit_wake_latency(Missing& missing) {
    constexpr const char* kDevice = "/dev/cpu_dma_latency";
    UniqueFd device(::open(kDevice, O_WRONLY | O_CLOEXEC));
    const std::int32_t longest_us = 0;
    if (device.valid() &&
        ::write(device.get(), &longest_us, sizeof longest_us) == sizeof longest_us) {
        return device;
    }
    // A kernel without this device has no sleep states to prevent.
    if (errno != ENOENT) {
        missing.push_back("idle processors may sleep deeply and wake late (" +
                          std::string(kDevice) + ": " + reason(errno) +
                          "); run as root, or let a udev rule give the user write access to it");
    }
    return {};
}

void mask_continue(int how) {
    sigset_t set;
    ::sigemptyset(&set);
    ::sigaddset(&set, SIGCONT);
    ::pthread_sigmask(how, &set, nullptr);
}

}  // namespace

void handle_sigcont() {
    mask_continue(SIG_BLOCK);
    struct sigaction action {};
    action.sa_handler = [](int) {};
    // Without SA_RESTART, so that system calls are interrupted.
    ::sigaction(SIGCONT, &action, nullptr);
}

void unblock_sigcont() {
    mask_continue(SIG_UNBLOCK);
}

Scheduling make_realtime(const SchedulingSettings& settings) {
    Scheduling got;
    if (settings.cpu) {
        pin(*settings.cpu, got.missing);
    }
    // Without SCHED_FIFO the kernel would delay each sleep by up to 50 us to combine wake-ups.
    ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
    if (!settings.realtime) {
        return got;
    }
    run_first(settings.priority, got.missing);
    keep_in_memory(got.missing);
    touch_stack();
    got.latency_limit = limit_wake_latency(got.missing);
    return got;
}

}  // namespace tribus
