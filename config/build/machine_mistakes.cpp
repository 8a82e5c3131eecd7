#include "config/build/machine_mistakes.h"

#include <linux/major.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <fmt/format.h>

#include "config/build/build.h"
#include "core/quotes.h"

namespace tribus {
namespace {

/// What `path` is, if it can never be a serial port. Empty if nothing is there or it may be one.
std::string_view what_else(const std::string& path) {
    struct stat told {};
    if (::stat(path.c_str(), &told) != 0) {
        return {};
    }
    // Memory devices: /dev/null, /dev/zero, /dev/random and others.
    if (S_ISCHR(told.st_mode) && major(told.st_rdev) == MEM_MAJOR) {
        return "this is not a serial device";
    }
    return S_ISDIR(told.st_mode)   ? "this is a folder"
           : S_ISBLK(told.st_mode) ? "this is a disk"
                                   : std::string_view();
}

}  // namespace

std::vector<Mistake> mistaken_devices(const Configuration& configuration) {
    std::vector<Mistake> mistakes;
    for (const PortPlan& port : plan_ports(configuration)) {
        const std::string_view other = port.config.link == LinkKind::serial
                                           ? what_else(port.config.device)
                                           : std::string_view();
        if (!other.empty()) {
            mistakes.push_back({configuration.file, port.config.where,
                                fmt::format("\"device\" is {}: {}; give a serial device, such as "
                                            "/dev/ttyUSB0",
                                            in_quotes(port.config.device), other)});
        }
    }
    return mistakes;
}

std::vector<Mistake> mistaken_processor(const Configuration& configuration, int processors) {
    const auto& runtime = configuration.runtime;
    if (!runtime.cpu || *runtime.cpu < processors) {
        return {};
    }
    const std::string allowed =
        processors == 1 ? "0, its only one" : fmt::format("0 to {}", processors - 1);
    return {{configuration.file, runtime.cpu_where,
             fmt::format("\"cpu\" is {}, which this machine does not have; allowed: {}",
                         *runtime.cpu, allowed)}};
}

int configured_processors() {
    return static_cast<int>(::sysconf(_SC_NPROCESSORS_CONF));
}

}  // namespace tribus
