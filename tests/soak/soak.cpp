#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <deque>
#include <filesystem>
#include <fstream>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "app/client/ask_daemon.h"
#include "app/client/status_fields.h"
#include "tests/loopback/program.h"
#include "tests/soak/bare_timer.h"
#include "tests/soak/line.h"

/// Many pipelines for a long time. One daemon runs between simulated receivers and servos at ptys.
/// Receivers fall silent, devices are unplugged and the daemon is stopped for a while. Figures that
/// must not grow are compared with the first part of the run, and missed deadlines also with those
/// of a bare thread at the same time.
namespace tribus::test {
namespace {

using namespace std::chrono_literals;

/// Number of parts of the run. The first one is for warming up.
constexpr int kParts = 20;
constexpr double kMillion = 1e6;
/// Memory that may come and go with what the main thread is doing.
constexpr long kMemoryNoiseKib = 256;

struct Options {
    std::size_t pipelines = 64;
    int seconds = 3600;
};

/// Counts and sizes at the end of one part of the run.
struct Part {
    std::uint64_t good = 0;
    std::uint64_t marked = 0;
    std::uint64_t frames = 0;  ///< frames that the daemon reports as written
    std::uint64_t misses = 0;
    std::uint64_t bare_wakes = 0;
    std::uint64_t bare_misses = 0;
    long resident_kib = 0;
    long data_kib = 0;
    std::ptrdiff_t descriptors = 0;
    std::size_t deaf_lines = 0;  ///< lines without one good frame
};

double per_million(std::uint64_t misses, std::uint64_t of) {
    return of == 0 ? 0 : kMillion * static_cast<double>(misses) / static_cast<double>(of);
}

class Soak {
  public:
    Soak(const std::filesystem::path& folder, const Options& options)
        : options_(options), folder_(folder) {
        std::string text;
        for (std::size_t i = 0; i < options.pipelines; ++i) {
            text += lines_.emplace_back(folder, i).configuration();
        }
        const std::string file = folder / "soak.toml";
        std::ofstream(file) << text;
        daemon_.emplace(folder, std::vector<std::string>{"run", file});
    }

    int run() {
        if (!daemon_->says("started")) {
            fmt::print(stderr, "the daemon did not start:\n{}", daemon_->errors());
            return 1;
        }
        fmt::print(
            "  minutes      good    marked  misses/1e6  bare/1e6  RSS KiB  data KiB  "
            "descriptors\n");
        // The first answer makes the heap grow once.
        static_cast<void>(ask_daemon(folder_ / "control", "status", 5s));
        const Clock::time_point begin = Clock::now();
        const auto part_length = std::chrono::milliseconds(1000L * options_.seconds / kParts);
        for (int part = 1; part <= kParts && daemon_->runs(); ++part) {
            translate(begin + part * part_length, part_length);
            note(begin);
        }
        return judge();
    }

  private:
    /// Sends until `end`, with some troubles, the last of which ends a while before `end`.
    void translate(Clock::time_point end, std::chrono::milliseconds length) {
        constexpr auto kTrouble = 3s;
        const auto last_trouble =
            end - std::max<std::chrono::milliseconds>(length / 3, 2 * kTrouble);
        Clock::time_point change = Clock::now() + kTrouble;
        bool troubled = false;
        SoakLine* hurt = nullptr;
        for (Clock::time_point now = Clock::now(); now < end; now = Clock::now()) {
            if (now >= change && (troubled || now < last_trouble)) {
                troubled = !troubled;
                troubled ? void(hurt = hurt_one(now + kTrouble)) : hurt->plug_in();
                change = now + kTrouble;
            }
            if (stopped_until_ && now >= *stopped_until_) {
                daemon_->signal(SIGCONT);
                stopped_until_.reset();
            }
            for (SoakLine& line : lines_) {
                line.send(now);
                line.listen();
            }
            constexpr timespec kPause{.tv_sec = 0, .tv_nsec = 1'000'000};
            ::nanosleep(&kPause, nullptr);
        }
    }

    /// Starts a trouble at one line. Now and then it also stops the daemon for a while.
    SoakLine* hurt_one(Clock::time_point until) {
        SoakLine& line = lines_[random_() % lines_.size()];
        if (random_() % 4 == 0) {
            daemon_->signal(SIGSTOP);
            stopped_until_ = until - 2900ms + std::chrono::milliseconds(random_() % 2400);
        }
        switch (random_() % 4) {
            case 0:
                line.silence(until);
                break;
            case 1:
                line.babble(until);
                break;
            case 2:
                line.pull_receiver();
                break;
            default:
                line.pull_servos();
        }
        return &line;
    }

    void note(Clock::time_point begin) {
        Part part;
        good_before_.resize(lines_.size());
        for (std::size_t i = 0; i < lines_.size(); ++i) {
            const Testimony& heard = lines_[i].testimony();
            part.good += heard.unmarked;
            part.marked += heard.marked;
            part.deaf_lines += heard.unmarked == good_before_[i] ? 1U : 0U;
            good_before_[i] = heard.unmarked;
        }
        // Memory is measured first: the answer is a text of a hundred KiB that exists for a moment.
        part.resident_kib = daemon_->memory_kib("VmRSS");
        part.data_kib = daemon_->memory_kib("VmData");
        if (const auto status = ask_daemon(folder_ / "control", "status", 5s)) {
            for (const auto& output : status_fields::list(*status, "outputs")) {
                part.frames += status_fields::count(output, "frames");
                part.misses += status_fields::count(output, "deadline_misses");
            }
        }
        part.bare_wakes = bare_.wakes();
        part.bare_misses = bare_.misses();
        part.descriptors = daemon_->open_descriptors();
        parts_.push_back(part);
        print_latest(begin);
    }

    void print_latest(Clock::time_point begin) const {
        const Part& part = parts_.back();
        const Part before = parts_.size() > 1 ? parts_[parts_.size() - 2] : Part{};
        fmt::print(
            "{:>9.1f} {:>9} {:>9}  {:>10.0f} {:>9.0f} {:>8} {:>9}  {:>11}\n",
            std::chrono::duration<double, std::ratio<60>>(Clock::now() - begin).count(),
            part.good - before.good, part.marked - before.marked,
            per_million(part.misses - before.misses, part.frames - before.frames),
            per_million(part.bare_misses - before.bare_misses, part.bare_wakes - before.bare_wakes),
            part.resident_kib, part.data_kib, part.descriptors);
        std::fflush(stdout);
    }

    void demand(bool kept, const std::string& promise) {
        fmt::print("{}  {}\n", kept ? "kept  " : "BROKEN", promise);
        kept_ = kept_ && kept;
    }

    int judge() {
        Testimony all;
        for (const SoakLine& line : lines_) {
            all.never_sent += line.testimony().never_sent;
            all.too_old += line.testimony().too_old;
            all.strays += line.testimony().strays;
        }
        const Part& warm = parts_.front();
        const Part& end = parts_.back();
        demand(daemon_->runs() && parts_.size() == kParts, "the daemon runs until the end");
        demand(all.never_sent == 0,
               fmt::format("no good frame has values that were not sent: {}", all.never_sent));
        demand(all.too_old == 0, fmt::format("no good frame has old values: {}", all.too_old));
        demand(all.strays == 0,
               fmt::format("every byte belongs to a frame: {} do not", all.strays));
        demand(std::ranges::all_of(parts_, [](const Part& part) { return part.deaf_lines == 0; }),
               "every line has control in every part of the run");
        demand(end.descriptors == warm.descriptors,
               fmt::format("descriptors: {} and {}", warm.descriptors, end.descriptors));
        for (const auto& [name, first, last] :
             {std::tuple("resident", warm.resident_kib, end.resident_kib),
              std::tuple("data", warm.data_kib, end.data_kib)}) {
            demand(last <= first + kMemoryNoiseKib,
                   fmt::format("{} memory: {} and {} KiB", name, first, last));
        }
        judge_deadlines();
        daemon_->signal(SIGTERM);
        demand(daemon_->end() == 0, "the daemon ends when it is told to");
        demand(count_of("allocated", daemon_->errors()) == 0, "the data thread allocated nothing");
        return kept_ ? 0 : 1;
    }

    /// Compares the missed deadlines of the last third with those of the first, relative to the
    /// bare thread.
    void judge_deadlines() {
        constexpr std::size_t kThird = kParts / 3;
        constexpr double kNoise = 2;
        if (parts_.size() != kParts) {
            return;
        }
        const auto rates = [&](std::size_t from, std::size_t to) {
            const Part& first = parts_[from];
            const Part& last = parts_[to];
            return std::pair(per_million(last.misses - first.misses, last.frames - first.frames),
                             per_million(last.bare_misses - first.bare_misses,
                                         last.bare_wakes - first.bare_wakes));
        };
        const auto [early, bare_early] = rates(0, kThird);
        const auto [late, bare_late] = rates(kParts - 1 - kThird, kParts - 1);
        // Deadlines that the bare thread missed as well are the machine's fault.
        const double machine = (bare_late + 1) / (bare_early + 1);
        demand(
            late <= kNoise * std::max(1.0, machine) * (early + 1),
            fmt::format("deadlines missed of a million: {:.0f}, then {:.0f} (bare thread: {:.0f}, "
                        "{:.0f})",
                        early, late, bare_early, bare_late));
    }

    Options options_;
    std::filesystem::path folder_;
    std::deque<SoakLine> lines_;
    std::optional<Program> daemon_;
    BareTimer bare_;
    std::mt19937 random_{1};
    std::optional<Clock::time_point> stopped_until_;
    std::vector<std::uint64_t> good_before_;
    std::vector<Part> parts_;
    bool kept_ = true;
};

int soak(const Options& options) {
    std::string name = (std::filesystem::temp_directory_path() / "tribus-soak-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
        fmt::print(stderr, "no folder for the devices\n");
        return 1;
    }
    const int status = Soak(name, options).run();
    std::filesystem::remove_all(name);
    return status;
}

}  // namespace
}  // namespace tribus::test

int main(int argc, char** argv) {
    CLI::App app("Many pipelines over pseudo-terminals for a long time");
    tribus::test::Options options;
    app.add_option("SECONDS", options.seconds, "How long")->capture_default_str();
    app.add_option("PIPELINES", options.pipelines, "How many")->capture_default_str();
    CLI11_PARSE(app, argc, argv);
    return tribus::test::soak(options);
}
