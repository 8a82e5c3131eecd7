#include "pipelines/realtime/scheduling.h"

#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>

#include <cerrno>
#include <cstring>

namespace tribus {
namespace {

std::string reason(int error) {
    return std::strerror(error);
}

}  // namespace

std::vector<std::string> make_realtime(const SchedulingSettings& settings) {
    std::vector<std::string> missing;
    if (settings.cpu) {
        cpu_set_t cpus;
        CPU_ZERO(&cpus);
        CPU_SET(static_cast<std::size_t>(*settings.cpu), &cpus);
        const int error = ::pthread_setaffinity_np(::pthread_self(), sizeof cpus, &cpus);
        if (error != 0) {
            missing.push_back("the data thread is not pinned to CPU " +
                              std::to_string(*settings.cpu) + " (" + reason(error) +
                              "); choose a CPU that `nproc` counts, from 0");
        }
    }
    if (!settings.realtime) {
        return missing;
    }
    const sched_param parameters{.sched_priority = settings.priority};
    const int error = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters);
    if (error != 0) {
        missing.push_back("the data thread has no real-time priority (" + reason(error) +
                          "); run as root, or give CAP_SYS_NICE or `ulimit -r " +
                          std::to_string(settings.priority) + "`");
    }
    if (::mlockall(MCL_CURRENT | MCL_FUTURE) != 0) {
        missing.push_back("memory is not locked (" + reason(errno) +
                          "); run as root, or give CAP_IPC_LOCK or `ulimit -l unlimited`");
    }
    return missing;
}

}  // namespace tribus
