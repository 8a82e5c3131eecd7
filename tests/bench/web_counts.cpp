#include "tests/bench/web_counts.h"

#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <list>
#include <memory>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "app/web/pairing/pairing.h"
#include "pipelines/realtime/clock.h"
#include "tests/bench/daemon_counts.h"
#include "tests/bench/latency.h"
#include "tests/bench/process.h"
#include "tests/bench/tester.h"
#include "tests/loopback/browser.h"
#include "tests/support/temporary_folder.h"

namespace tribus::bench {
namespace {

namespace fs = std::filesystem;
using WebRefused = tl::unexpected<std::string>;

constexpr std::uint64_t kFewRounds = 200;
constexpr std::uint64_t kManyRounds = 1000;
constexpr std::size_t kPagesOfABrowser = 4;

/// A page that reads its stream in a thread of its own.
class Page {
  public:
    Page(const test::Browser& browser, int port, const std::string& path)
        : stream_(browser, port, path), reader_([this] { read(); }) {}
    Page(const Page&) = delete;
    Page& operator=(const Page&) = delete;
    ~Page() { reader_.join(); }

    std::uint64_t events() const { return events_; }
    std::size_t bytes() const { return bytes_; }

  private:
    void read() {
        while (const auto status = stream_.next("status")) {
            bytes_ = status->size();
            ++events_;
        }
    }

    test::EventStream stream_;
    std::atomic<std::uint64_t> events_{0};
    std::atomic<std::size_t> bytes_{0};
    std::thread reader_;
};

/// A daemon on ptys, and `tribus-web` with pages before it. The pages end with the server.
class Watched {
  public:
    Watched() { fs::create_directory(folder() / "state"); }
    Watched(const Watched&) = delete;
    Watched& operator=(const Watched&) = delete;
    ~Watched() { end_server(); }

    const fs::path& folder() const { return folder_.path(); }
    Subject& daemon() { return *daemon_; }
    Process& server() { return *server_; }
    const Page& page() const { return *pages_.front(); }

    tl::expected<void, std::string> start_daemon(std::vector<std::string> in_front) {
        ApplianceSettings settings;
        settings.program = TRIBUS_PROGRAM;
        settings.carries = Carries::sbus;
        settings.period = std::chrono::milliseconds(7);
        settings.environment = environment();
        settings.in_front = std::move(in_front);
        auto started = carrying(Subject::appliance(1, settings));
        if (!started) {
            return WebRefused(started.error());
        }
        daemon_ = std::make_unique<Subject>(std::move(*started));
        return {};
    }

    tl::expected<void, std::string> start_server(std::vector<std::string> in_front) {
        in_front.insert(in_front.end(), {TRIBUS_WEB, "serve", "--listen", "127.0.0.1:0",
                                         "--configurations", folder().string(), "--state",
                                         folder_ / "state", "--page", folder_ / "page"});
        auto process = Process::execute(in_front, {}, environment());
        if (!process) {
            return WebRefused(process.error());
        }
        server_ = std::make_unique<Process>(std::move(*process));
        const std::string said = "the page is at http://127.0.0.1:";
        const bool up = frames_until([&] { return errors_have(said); });
        if (!up) {
            return WebRefused("tribus-web did not start: " + server_->errors());
        }
        const std::string errors = server_->errors();
        port_ = std::atoi(errors.c_str() + errors.find(said) + said.size());
        return {};
    }

    /// Waits until each page has got a status.
    tl::expected<void, std::string> open_pages(std::size_t count) {
        std::optional<test::Browser> browser;
        for (std::size_t i = 0; i < count; ++i) {
            if (i % kPagesOfABrowser == 0) {
                browser.emplace(port_);
                if (!pair(*browser)) {
                    return WebRefused(std::string("a browser cannot be paired"));
                }
            }
            pages_.push_back(std::make_unique<Page>(
                *browser, port_, "/api/" + folder().filename().string() + "/stream?rate=10"));
            if (!frames_until([&] { return pages_.back()->events() > 0; })) {
                return WebRefused(std::string("a page got no status"));
            }
        }
        return {};
    }

    void end_server() {
        if (server_) {
            server_->end();
        }
        pages_.clear();
    }

  private:
    /// The daemon has its socket in the folder, and its name, whatever other daemons run here.
    std::vector<std::string> environment() const {
        return {"RUNTIME_DIRECTORY=" + folder().string()};
    }
    bool errors_have(const std::string& text) {
        return server_->errors().find(text) != std::string::npos;
    }
    bool pair(test::Browser& browser) const {
        web::PairingFolder pairing(folder() / "state");
        const auto code = pairing.make_code(
            web::Role::look, std::chrono::duration_cast<web::WallTime>(
                                 std::chrono::system_clock::now().time_since_epoch()));
        return code && browser.pair(*code).status == 200;
    }
    /// The receiver goes on meanwhile.
    template <class Done>
    bool frames_until(Done done) {
        const Instant end = monotonic_now() + std::chrono::seconds(30);
        while (!done()) {
            if (monotonic_now() > end) {
                return false;
            }
            drive(*daemon_, {.period = kDaemonFramePeriod, .rounds = 1});
        }
        return true;
    }

    test::TemporaryFolder folder_;
    std::unique_ptr<Subject> daemon_;
    std::unique_ptr<Process> server_;
    int port_ = 0;
    std::list<std::unique_ptr<Page>> pages_;
};

/// Counts of callgrind, and the frames that came out meanwhile.
struct WebCounted : CallgrindCounts {
    std::uint64_t frames = 0;
    std::uint64_t events = 0;
    std::size_t bytes = 0;
};

enum class CountedProgram : std::uint8_t { daemon, server };

tl::expected<WebCounted, std::string> count_web(CountedProgram program, std::size_t pages,
                                                std::uint64_t rounds) {
    Watched watched;
    const fs::path counts = watched.folder() / "counts";
    fs::create_directory(counts);
    const auto in_front = under_callgrind(counts);
    const std::vector<std::string> none;
    auto ready = watched.start_daemon(program == CountedProgram::daemon ? in_front : none);
    if (ready && pages > 0) {
        ready = watched.start_server(program == CountedProgram::server ? in_front : none);
    }
    if (ready) {
        ready = watched.open_pages(pages);
    }
    if (!ready) {
        return WebRefused(ready.error());
    }
    {
        const TesterPriority priority;
        drive(watched.daemon(), {.period = kDaemonFramePeriod, .rounds = rounds});
    }
    const std::uint64_t frames = watched.daemon().lane().counts().arrived;
    const std::uint64_t events = pages > 0 ? watched.page().events() : 0;
    const std::size_t bytes = pages > 0 ? watched.page().bytes() : 0;
    if (program == CountedProgram::daemon) {
        watched.daemon().process().end();
    }
    watched.end_server();
    WebCounted counted{callgrind_counts(counts)};
    if (counted.main_thread == 0) {
        return WebRefused(std::string("callgrind counted nothing"));
    }
    counted.frames = frames;
    counted.events = events;
    counted.bytes = bytes;
    return counted;
}

/// Counts a short run and a long one; their difference has no start and no end.
template <class Result, class Made>
tl::expected<Result, std::string> web_difference(CountedProgram program, std::size_t pages,
                                                 Made made) {
    const auto few = count_web(program, pages, kFewRounds);
    const auto many = count_web(program, pages, kManyRounds);
    if (!few || !many) {
        return WebRefused(few ? many.error() : few.error());
    }
    return made(*few, *many);
}

}  // namespace

tl::expected<PagesInDaemon, std::string> daemon_with_pages(std::size_t pages) {
    const std::chrono::duration<double> longer = kDaemonFramePeriod * (kManyRounds - kFewRounds);
    return web_difference<PagesInDaemon>(
        CountedProgram::daemon, pages, [&](const WebCounted& few, const WebCounted& many) {
            const std::uint64_t main_thread = many.main_thread - few.main_thread;
            return PagesInDaemon{
                .data_thread_a_frame = static_cast<double>(many.all - few.all - main_thread) /
                                       static_cast<double>(many.frames - few.frames),
                .main_thread_a_second = static_cast<double>(main_thread) / longer.count()};
        });
}

tl::expected<WebInstructions, std::string> web_with_pages(std::size_t pages) {
    return web_difference<WebInstructions>(
        CountedProgram::server, pages, [](const WebCounted& few, const WebCounted& many) {
            return WebInstructions{.an_event = static_cast<double>(many.all - few.all) /
                                               static_cast<double>(many.events - few.events),
                                   .bytes = many.bytes};
        });
}

tl::expected<double, std::string> web_memory(std::size_t pages) {
    Watched watched;
    auto ready = watched.start_daemon({});
    if (ready) {
        ready = watched.start_server({});
    }
    if (ready) {
        ready = watched.open_pages(pages);
    }
    if (!ready) {
        return WebRefused(ready.error());
    }
    drive(watched.daemon(), {.period = kDaemonFramePeriod, .rounds = kFewRounds});
    const auto usage = usage_of(watched.server().id());
    return usage ? tl::expected<double, std::string>(static_cast<double>(usage->resident_bytes))
                 : WebRefused(std::string("tribus-web has ended"));
}

}  // namespace tribus::bench
