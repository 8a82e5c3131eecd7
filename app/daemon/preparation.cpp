#include "app/daemon/preparation.h"

#include <pthread.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <utility>

#include "app/cli/replace_file.h"
#include "config/build/machine_mistakes.h"
#include "config/load.h"
#include "transports/links/start_thread.h"
#include "transports/links/unique_fd.h"

namespace tribus {
namespace {

/// More than the deepest configuration needs. All of it counts as locked memory.
constexpr std::size_t kPreparationStackBytes = std::size_t{1024} * 1024;

std::atomic<int> preparations_running{0};

tl::unexpected<std::vector<Mistake>> mistake(const std::string& file, std::string text) {
    return tl::unexpected(std::vector{Mistake{file, {}, std::move(text), true}});
}

std::unique_ptr<Appliance> build_with_files(Configuration configuration) {
    auto built = Appliance::build(std::move(configuration));
    built->open_files();
    return built;
}

}  // namespace

struct Preparation::Work {
    std::function<Result(Work&)> prepare;
    Result result = tl::unexpected(std::vector<Mistake>{});
    std::atomic<bool> done{false};
    /// Set once: by the thread before a step that nobody can undo, or by who abandons the work.
    std::atomic<bool> decided{false};
    UniqueFd event{::eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC)};

    void run() {
        result = prepare(*this);
        done.store(true, std::memory_order_release);
        const std::uint64_t one = 1;
        [[maybe_unused]] const ssize_t told = ::write(event.get(), &one, sizeof one);
    }
};

void* Preparation::main(void* given) {
    ::pthread_setname_np(::pthread_self(), "tribus-reload");
    // This thread's share of the work, and so perhaps the result, is gone before the count drops.
    (*std::unique_ptr<std::shared_ptr<Work>>(static_cast<std::shared_ptr<Work>*>(given)))->run();
    --preparations_running;
    return nullptr;
}

std::unique_ptr<Preparation> Preparation::begin(std::function<Result(Work&)> prepare) {
    auto work = std::make_shared<Work>();
    work->prepare = std::move(prepare);
    auto own = std::make_unique<std::shared_ptr<Work>>(work);
    pthread_t thread{};
    ++preparations_running;
    if (start_thread(thread, kPreparationStackBytes, &Preparation::main, own.get(),
                     ThreadKind::detached) == 0) {
        static_cast<void>(own.release());
    } else {
        // If no thread can be created, waiting is better than refusing.
        --preparations_running;
        work->run();
    }
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
    return Prepared{build_with_files(std::move(*configuration)), std::move(text)};
}

std::unique_ptr<Preparation> Preparation::of_file(const std::string& path) {
    return begin([path](Work&) -> Result {
        return read_configuration_text(path, FileKinds::regular).and_then([&](std::string text) {
            return appliance_of(std::move(text), path);
        });
    });
}

std::unique_ptr<Preparation> Preparation::of_draft(const std::string& draft,
                                                   const std::string& path) {
    return begin([draft, path](Work&) -> Result {
        auto prepared =
            read_configuration_text(draft, FileKinds::draft).and_then([&](std::string text) {
                return appliance_of(std::move(text), path);
            });
        if (auto present = read_configuration_text(path, FileKinds::regular); prepared && present) {
            prepared->file_text = std::move(*present);
        }
        return prepared;
    });
}

std::unique_ptr<Preparation> Preparation::keeping(DraftToKeep draft) {
    return begin([draft = std::move(draft)](Work& work) -> Result {
        auto present = read_configuration_text(draft.path, FileKinds::regular);
        if (!present) {
            return tl::unexpected(std::move(present.error()));
        }
        const std::filesystem::path file = linked_file(draft.path);
        const auto successor = read_configuration_text(successor_of(file), FileKinds::draft);
        const bool has_it = *present == draft.text;
        if (!has_it && (!successor || *successor != draft.text)) {
            return Prepared{.appliance = nullptr, .text = std::move(*present)};
        }
        if (!has_it && *present != draft.file_text) {
            return mistake(draft.path, "was changed by another since the draft went on trial");
        }
        if (work.decided.exchange(true)) {
            return mistake(draft.path, "is as before: the draft was abandoned");
        }
        if (has_it) {
            return Prepared{.appliance = nullptr, .text = std::move(*present)};
        }
        if (auto placed = put_successor_in_place(file); !placed) {
            return mistake(draft.path, "cannot be replaced by the draft: " + placed.error());
        }
        return Prepared{.appliance = nullptr, .text = draft.text};
    });
}

std::unique_ptr<Preparation> Preparation::of(const Configuration& configuration) {
    return begin([configuration](Work&) -> Result {
        return Prepared{.appliance = build_with_files(configuration), .text = {}};
    });
}

Preparation::~Preparation() = default;

int Preparation::descriptor() const {
    return work_->event.get();
}

bool Preparation::abandon() {
    return !work_->decided.exchange(true);
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
