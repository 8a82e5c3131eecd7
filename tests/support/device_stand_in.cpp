#include "tests/support/device_stand_in.h"

#include <dlfcn.h>
#include <fcntl.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <mutex>
#include <utility>

namespace tribus::test {
/// Not without a name: this file may be joined with others.
namespace stand_ins {

/// The C library's own function of that name.
template <class Function>
Function* of_library(const char* name) {
    return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

static int library_open(const char* path, int flags, mode_t mode) {
    static auto* const function = of_library<int(const char*, int, ...)>("open");
    return function(path, flags, mode);
}

static int library_fstat(int descriptor, struct stat* node) {
    static auto* const function = of_library<int(int, struct stat*)>("fstat");
    return function(descriptor, node);
}

static std::mutex entering;
static std::vector<DeviceStandIn*> all;
/// Without any, each call goes straight to the C library.
static std::atomic<std::size_t> count = 0;

template <class Is>
DeviceStandIn* find(Is is) {
    const std::scoped_lock lock(entering);
    const auto found = std::ranges::find_if(all, is);
    return found == all.end() ? nullptr : *found;
}

static DeviceStandIn* at_path(const char* path) {
    return count == 0 ? nullptr
                      : find([=](const DeviceStandIn* each) { return each->path() == path; });
}

static DeviceStandIn* of_descriptor(int descriptor) {
    struct stat node {};
    return count == 0 || library_fstat(descriptor, &node) != 0
               ? nullptr
               : find([&](const DeviceStandIn* each) { return each->has(node); });
}

/// As a system call ends: -1 with errno where the kernel returns an error.
static long result(long answer) {
    if (answer >= 0) {
        return answer;
    }
    errno = static_cast<int>(-answer);
    return -1;
}

static DeviceStandIn::Answer answer_to_read(int descriptor, void* room, std::size_t size) {
    DeviceStandIn* device = of_descriptor(descriptor);
    return device == nullptr ? std::nullopt
                             : device->read({static_cast<std::uint8_t*>(room), size});
}

static DeviceStandIn::Answer answer_to_write(int descriptor, const void* bytes, std::size_t size) {
    DeviceStandIn* device = of_descriptor(descriptor);
    return device == nullptr ? std::nullopt
                             : device->write({static_cast<const std::uint8_t*>(bytes), size});
}

}  // namespace stand_ins

DeviceStandIn::DeviceStandIn(std::string path) : path_(std::move(path)) {
    if (::stat(path_.c_str(), &node_) != 0) {
        file_ = ::memfd_create("device", MFD_CLOEXEC);
        stand_ins::library_fstat(file_, &node_);
    }
    enter();
}

DeviceStandIn::DeviceStandIn(int descriptor) {
    stand_ins::library_fstat(descriptor, &node_);
    enter();
}

void DeviceStandIn::enter() {
    const std::scoped_lock lock(stand_ins::entering);
    stand_ins::all.push_back(this);
    stand_ins::count = stand_ins::all.size();
}

DeviceStandIn::~DeviceStandIn() {
    {
        const std::scoped_lock lock(stand_ins::entering);
        std::erase(stand_ins::all, this);
        stand_ins::count = stand_ins::all.size();
    }
    if (file_ >= 0) {
        ::close(file_);
    }
}

DeviceStandIn::Answer DeviceStandIn::control(unsigned long /*request*/, void* /*argument*/) {
    return -ENOTTY;
}

int DeviceStandIn::open_file(int flags) {
    ++opened;
    if (const Answer answer = open()) {
        return static_cast<int>(stand_ins::result(*answer));
    }
    return file_ < 0 ? stand_ins::library_open(path_.c_str(), flags, 0)
                     : ::fcntl(file_, F_DUPFD_CLOEXEC, 0);
}

DeviceStandIn::Answer DeviceStandIn::take_control(unsigned long request, void* argument) {
    asked.push_back(request);
    const auto refusal = refused.find(request);
    return refusal != refused.end() ? -refusal->second : control(request, argument);
}

bool DeviceStandIn::has(const struct stat& node) const {
    return node.st_dev == node_.st_dev && node.st_ino == node_.st_ino;
}

}  // namespace tribus::test

namespace calls = tribus::test::stand_ins;

extern "C" {

int open(const char* path, int flags, ...) {
    va_list list;
    va_start(list, flags);
    const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(list, mode_t) : 0;
    va_end(list);
    tribus::test::DeviceStandIn* device = calls::at_path(path);
    return device != nullptr ? device->open_file(flags) : calls::library_open(path, flags, mode);
}

/// The C library calls this for `open` where it checks arguments.
int __open_2(const char* path, int flags) {
    return open(path, flags);
}

int access(const char* path, int mode) noexcept {
    static auto* const function = calls::of_library<int(const char*, int)>("access");
    tribus::test::DeviceStandIn* device = calls::at_path(path);
    return device != nullptr ? static_cast<int>(calls::result(device->open().value_or(0)))
                             : function(path, mode);
}

int fstat(int descriptor, struct stat* node) noexcept {
    const int told = calls::library_fstat(descriptor, node);
    tribus::test::DeviceStandIn* device = told == 0 ? calls::of_descriptor(descriptor) : nullptr;
    const auto answer = device != nullptr ? device->state(*node) : std::nullopt;
    return answer ? static_cast<int>(calls::result(*answer)) : told;
}

int ioctl(int descriptor, unsigned long request, ...) noexcept {
    static auto* const function = calls::of_library<int(int, unsigned long, ...)>("ioctl");
    va_list list;
    va_start(list, request);
    void* const argument = va_arg(list, void*);
    va_end(list);
    tribus::test::DeviceStandIn* device = calls::of_descriptor(descriptor);
    const auto answer = device != nullptr ? device->take_control(request, argument) : std::nullopt;
    return answer ? static_cast<int>(calls::result(*answer))
                  : function(descriptor, request, argument);
}

ssize_t read(int descriptor, void* room, std::size_t size) {
    static auto* const function = calls::of_library<ssize_t(int, void*, std::size_t)>("read");
    const auto answer = calls::answer_to_read(descriptor, room, size);
    return answer ? calls::result(*answer) : function(descriptor, room, size);
}

ssize_t write(int descriptor, const void* bytes, std::size_t size) {
    static auto* const function =
        calls::of_library<ssize_t(int, const void*, std::size_t)>("write");
    const auto answer = calls::answer_to_write(descriptor, bytes, size);
    return answer ? calls::result(*answer) : function(descriptor, bytes, size);
}

ssize_t sendto(int descriptor, const void* bytes, std::size_t size, int flags, const sockaddr* to,
               socklen_t length) {
    static auto* const function =
        calls::of_library<ssize_t(int, const void*, std::size_t, int, const sockaddr*, socklen_t)>(
            "sendto");
    const auto answer = calls::answer_to_write(descriptor, bytes, size);
    return answer ? calls::result(*answer) : function(descriptor, bytes, size, flags, to, length);
}

long syscall(long number, ...) noexcept {
    static auto* const function = calls::of_library<long(long, ...)>("syscall");
    va_list list;
    va_start(list, number);
    const long first = va_arg(list, long);
    void* const second = va_arg(list, void*);
    const long third = va_arg(list, long);
    const long fourth = va_arg(list, long);
    const long fifth = va_arg(list, long);
    const long sixth = va_arg(list, long);
    va_end(list);
    const auto descriptor = static_cast<int>(first);
    const auto size = static_cast<std::size_t>(third);
    const auto answer = number == SYS_read    ? calls::answer_to_read(descriptor, second, size)
                        : number == SYS_write ? calls::answer_to_write(descriptor, second, size)
                                              : std::nullopt;
    return answer ? calls::result(*answer)
                  : function(number, first, second, third, fourth, fifth, sixth);
}

}  // extern "C"
