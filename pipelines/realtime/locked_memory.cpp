#include "pipelines/realtime/locked_memory.h"

#include <link.h>
#include <malloc.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cinttypes>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <memory>
#include <string_view>

// Range of the data path's code and constants (app/data_path.ld). Null if linked without it.
extern "C" {
[[gnu::weak]] extern const char kDataPathCodeBegin[];
[[gnu::weak]] extern const char kDataPathCodeEnd[];
[[gnu::weak]] extern const char kDataPathConstantsBegin[];
[[gnu::weak]] extern const char kDataPathConstantsEnd[];
}

namespace tribus {
namespace {

struct MemoryRange {
    std::uintptr_t begin = 0;
    std::uintptr_t end = 0;

    bool holds(std::uintptr_t address) const { return begin <= address && address < end; }
};

std::uintptr_t address_of(const char* symbol) {
    return reinterpret_cast<std::uintptr_t>(symbol);
}

/// In bytes: 4 KiB, on a Raspberry Pi 5 16 KiB.
std::uintptr_t page_size() {
    return static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
}

/// Applies `function` to each page that has a part of the range.
template <class Function>
int advise(Function function, MemoryRange range) {
    const std::uintptr_t begin = range.begin / page_size() * page_size();
    // The loader and /proc/self/maps give addresses as numbers.
    return function(reinterpret_cast<void*>(begin),  // NOLINT(performance-no-int-to-ptr)
                    range.end - begin);
}

int lock(MemoryRange range) {
    return advise([](void* begin, std::size_t length) { return ::mlock(begin, length); }, range);
}

/// Calls `visit` for each read-only segment of the program and its libraries until it returns
/// nonzero.
template <class Visit>
int each_clean_segment(Visit visit) {
    const auto visit_object = [](dl_phdr_info* object, std::size_t, void* data) {
        for (int i = 0; i < object->dlpi_phnum; ++i) {
            const auto& segment = object->dlpi_phdr[i];
            if (segment.p_type == PT_LOAD && (segment.p_flags & PF_W) == 0) {
                const std::uintptr_t begin = object->dlpi_addr + segment.p_vaddr;
                const int result =
                    (*static_cast<Visit*>(data))(MemoryRange{begin, begin + segment.p_memsz});
                if (result != 0) {
                    return result;
                }
            }
        }
        return 0;
    };
    return ::dl_iterate_phdr(visit_object, &visit);
}

/// Read-only pages can be dropped because the kernel reads them again from their files.
int drop_clean(MemoryRange range) {
    return advise(
        [](void* begin, std::size_t length) { return ::madvise(begin, length, MADV_DONTNEED); },
        range);
}

/// Pages stay from their first use on.
int lock_on_use(MemoryRange range) {
    return advise(
        [](void* begin, std::size_t length) { return ::mlock2(begin, length, MLOCK_ONFAULT); },
        range);
}

/// Locks the segment of the C library's code, found by the address of one of its functions.
int lock_c_library() {
    const auto inside = reinterpret_cast<std::uintptr_t>(&::epoll_pwait2);
    return each_clean_segment(
        [&](MemoryRange segment) { return segment.holds(inside) ? lock(segment) : 0; });
}

/// Keeps the first error.
class FirstError {
  public:
    void note(int result) {
        if (result != 0 && error_ == 0) {
            error_ = errno;
        }
    }
    int error() const { return error_; }

  private:
    int error_ = 0;
};

/// Kind of a writable line of /proc/self/maps.
enum class Mapping : std::uint8_t { other, heap, main_stack };

/// Calls `visit` with each writable range of memory and its kind.
template <class Visit>
int each_writable_range(Visit visit) {
    const std::unique_ptr<std::FILE, int (*)(std::FILE*)> maps(std::fopen("/proc/self/maps", "re"),
                                                               &std::fclose);
    std::array<char, 512> line{};
    while (maps && std::fgets(line.data(), line.size(), maps.get()) != nullptr) {
        const std::string_view text(line.data());
        MemoryRange range;
        std::array<char, 5> permissions{};
        std::sscanf(line.data(), "%" SCNxPTR "-%" SCNxPTR " %4s", &range.begin, &range.end,
                    permissions.data());
        if (std::string_view(permissions.data()).starts_with("rw")) {
            visit(range, text.ends_with("[heap]\n")    ? Mapping::heap
                         : text.ends_with("[stack]\n") ? Mapping::main_stack
                                                       : Mapping::other);
        }
    }
    return maps ? 0 : -1;
}

/// Locks data and thread stacks. Not the heap: its used pages are present, and its unused pages are
/// not needed. Not the main thread's stack: no frame waits for that thread.
void lock_writable_memory(FirstError& first) {
    first.note(each_writable_range([&](MemoryRange range, Mapping mapping) {
        if (mapping == Mapping::other) {
            first.note(lock(range));
        }
    }));
}

void lock_heap(FirstError& first) {
    first.note(each_writable_range([&](MemoryRange range, Mapping mapping) {
        if (mapping == Mapping::heap) {
            first.note(lock_on_use(range));
        }
    }));
}

void lock_data_path(FirstError& first) {
    if (kDataPathCodeBegin == nullptr) {
        first.note(each_clean_segment([&](MemoryRange segment) {
            first.note(lock(segment));
            return 0;
        }));
        return;
    }
    first.note(lock({address_of(kDataPathCodeBegin), address_of(kDataPathCodeEnd)}));
    first.note(lock({address_of(kDataPathConstantsBegin), address_of(kDataPathConstantsEnd)}));
    first.note(lock_c_library());
}

/// Whether RLIMIT_MEMLOCK applies to mappings that are locked on creation. It tries it out, because
/// a capability that is valid only inside a container does not help.
bool limit_binds() {
    rlimit limit{};
    if (::getrlimit(RLIMIT_MEMLOCK, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY) {
        return false;
    }
    const std::size_t page = page_size();
    // A limit of 64 bits may be more than a process of 32 bits can map.
    if (limit.rlim_cur > std::numeric_limits<std::size_t>::max() - page) {
        return false;
    }
    const std::size_t beyond = static_cast<std::size_t>(limit.rlim_cur) + page;
    void* const probe =
        ::mmap(nullptr, beyond, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (probe == MAP_FAILED) {
        return true;
    }
    ::munmap(probe, beyond);
    return false;
}

/// Locks all present and future memory. Returns false, with nothing locked, if a limit applies.
bool lock_all_that_comes() {
    const int on_use = kDataPathCodeBegin == nullptr ? 0 : MCL_ONFAULT;
    if (::mlockall(MCL_FUTURE | on_use) != 0 || limit_binds() ||
        ::mlockall(MCL_CURRENT | MCL_FUTURE | on_use) != 0) {
        ::munlockall();
        return false;
    }
    return true;
}

enum class Locked : std::uint8_t { nothing, present, present_and_future };
std::atomic<Locked> locked{Locked::nothing};

}  // namespace

int lock_memory() {
    ::munlockall();
    ::malloc_trim(0);
    if (kDataPathCodeBegin != nullptr) {
        each_clean_segment([](MemoryRange segment) {
            drop_clean(segment);
            return 0;
        });
    }
    FirstError first;
    locked = lock_all_that_comes() ? Locked::present_and_future : Locked::present;
    lock_data_path(first);
    lock_writable_memory(first);
    if (locked == Locked::present) {
        lock_heap(first);
    }
    return first.error();
}

int lock_new_memory() {
    FirstError first;
    if (locked == Locked::present) {
        lock_writable_memory(first);
        lock_heap(first);
    }
    return first.error();
}

}  // namespace tribus
