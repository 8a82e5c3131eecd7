#include "transports/links/start_thread.h"

#include <link.h>
#include <unistd.h>

#include <algorithm>
#include <span>

namespace tribus {
namespace {

/// Thread-local storage of the program and its libraries. The C library puts it on the stack of a
/// thread.
std::size_t thread_local_bytes() {
    std::size_t bytes = 0;
    const auto add = [](dl_phdr_info* object, std::size_t, void* sum) {
        for (const auto& segment : std::span(object->dlpi_phdr, object->dlpi_phnum)) {
            if (segment.p_type == PT_TLS) {
                *static_cast<std::size_t*>(sum) += segment.p_memsz + segment.p_align;
            }
        }
        return 0;
    };
    ::dl_iterate_phdr(add, &bytes);
    return bytes;
}

/// The C library's description of a thread, and its reserve for libraries that come later.
constexpr std::size_t kBesideThreadLocals = std::size_t{8} * 1024;

int set_stack(pthread_attr_t& attributes, std::size_t stack_bytes) {
    const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    const auto least = static_cast<std::size_t>(std::max(::sysconf(_SC_THREAD_STACK_MIN), 0L));
    const std::size_t bytes =
        std::max(stack_bytes, least) + thread_local_bytes() + kBesideThreadLocals;
    return ::pthread_attr_setstacksize(&attributes, (bytes + page - 1) / page * page);
}

int start(pthread_t& thread, pthread_attr_t& attributes, std::size_t stack_bytes,
          void* (*main)(void*), void* argument, ThreadKind kind) {
    int error = set_stack(attributes, stack_bytes);
    if (error == 0 && kind == ThreadKind::detached) {
        error = ::pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    }
    return error == 0 ? ::pthread_create(&thread, &attributes, main, argument) : error;
}

}  // namespace

int start_thread(pthread_t& thread, std::size_t stack_bytes, void* (*main)(void*), void* argument,
                 ThreadKind kind) {
    pthread_attr_t attributes;
    int error = ::pthread_attr_init(&attributes);
    if (error == 0) {
        error = start(thread, attributes, stack_bytes, main, argument, kind);
        ::pthread_attr_destroy(&attributes);
    }
    return error;
}

int set_usual_stack(std::size_t stack_bytes) {
    pthread_attr_t attributes;
    int error = ::pthread_attr_init(&attributes);
    if (error == 0) {
        error = set_stack(attributes, stack_bytes);
        error = error == 0 ? ::pthread_setattr_default_np(&attributes) : error;
        ::pthread_attr_destroy(&attributes);
    }
    return error;
}

}  // namespace tribus
