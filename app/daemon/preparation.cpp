#include "app/daemon/preparation.h"

#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <utility>

#include "config/build/machine_mistakes.h"
#include "config/load.h"
#include "transports/links/unique_fd.h"

namespace tribus {
namespace {

/// More than the deepest configuration needs. All of it counts as locked memory.
constexpr std::size_t kPreparationStackBytes = std::size_t{1024} * 1024;

std::atomic<int> preparations_running{0};

}  // namespace

struct Preparation::Work {
    std::function<Result()> prepare;
    Result result = tl::unexpected(std::vector<Mistake>{});
    std::atomic<bool> done{false};
    UniqueFd event{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};

    void run() {
        result = prepare();
        done.store(true, std::memory_order_release);
        const std::uint64_t one = 1;
        [[maybe_unused]] const ssize_t told = ::write(event.get(), &one, sizeof one);
    }
};

void* Preparation::main(void* given) {
    ::pthread_setname_np(::pthread_self(), "tribus-reload");
    std::unique_ptr<std::shared_ptr<Work>> work(static_cast<std::shared_ptr<Work>*>(given));
    (*work)->run();
    work.reset();
    --preparations_running;
    return nullptr;
}

std::unique_ptr<Preparation> Preparation::begin(std::function<Result()> prepare) {
    auto work = std::make_shared<Work>();
    work->prepare = std::move(prepare);
    auto own = std::make_unique<std::shared_ptr<Work>>(work);
    pthread_attr_t attributes;
    ::pthread_attr_init(&attributes);
    ::pthread_attr_setstacksize(&attributes, kPreparationStackBytes);
    ::pthread_attr_setdetachstate(&attributes, PTHREAD_CREATE_DETACHED);
    pthread_t thread{};
    ++preparations_running;
    if (::pthread_create(&thread, &attributes, &Preparation::main, own.get()) == 0) {
        static_cast<void>(own.release());
    } else {
        // If no thread can be created, waiting is better than refusing.
        --preparations_running;
        work->run();
    }
    ::pthread_attr_destroy(&attributes);
    return std::unique_ptr<Preparation>(new Preparation(std::move(work)));
}

Preparation::Result Preparation::appliance_of(std::string text, const std::string& path) {
    auto configuration = load_configuration_draft(text, path);
    if (!configuration) {
        return tl::unexpected(std::move(configuration.error()));
    }
    if (auto mistakes = mistaken_processor(*configuration, configured_processors());
        !mistakes.empty()) {
        return tl::unexpected(std::move(mistakes));
    }
    return Prepared{Appliance::build(std::move(*configuration)), std::move(text)};
}

std::unique_ptr<Preparation> Preparation::of_file(const std::string& path) {
    return begin([path]() -> Result {
        return read_configuration_text(path, FileKinds::regular).and_then([&](std::string text) {
            return appliance_of(std::move(text), path);
        });
    });
}

std::unique_ptr<Preparation> Preparation::of_draft(const std::string& draft,
                                                   const std::string& path) {
    return begin([draft, path]() -> Result {
        return read_configuration_text(draft, FileKinds::draft).and_then([&](std::string text) {
            return appliance_of(std::move(text), path);
        });
    });
}

std::unique_ptr<Preparation> Preparation::of_text(const std::string& path) {
    return begin([path]() -> Result {
        return read_configuration_text(path, FileKinds::regular).map([](std::string text) {
            return Prepared{.appliance = nullptr, .text = std::move(text)};
        });
    });
}

std::unique_ptr<Preparation> Preparation::of(const Configuration& configuration) {
    return begin([configuration]() -> Result {
        return Prepared{.appliance = Appliance::build(configuration), .text = {}};
    });
}

Preparation::~Preparation() = default;

int Preparation::descriptor() const {
    return work_->event.get();
}

bool Preparation::done() const {
    return work_->done.load(std::memory_order_acquire);
}

Preparation::Result Preparation::take() {
    return std::move(work_->result);
}

bool Preparation::any_abandoned() {
    return preparations_running > 0;
}

}  // namespace tribus
