#include "app/web/answers/plot_job.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <fmt/format.h>

#include "app/cli/exit_status.h"
#include "app/web/answers/answers.h"
#include "app/web/answers/own_process.h"

namespace tribus::web {
namespace {

constexpr std::size_t kPictureBytesAtOnce = std::size_t{32} * 1024;

}  // namespace

tl::expected<std::shared_ptr<PlotJob>, std::string> PlotJob::start(
    const std::filesystem::path& recording, const std::vector<std::string>& range, Instant now) {
    UniqueFd result(::memfd_create("plot", MFD_CLOEXEC));
    const UniqueFd nothing(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (!result.valid() || !nothing.valid()) {
        return tl::unexpected(fmt::format("no process can be started: {}", std::strerror(errno)));
    }
    std::vector<std::string> words{"plot", recording.string()};
    words.insert(words.end(), range.begin(), range.end());
    const auto process = start_own_program(
        words, {.input = nothing.get(), .output = result.get(), .error = result.get()});
    if (!process) {
        return tl::unexpected(
            fmt::format("no process can be started: {}", std::strerror(process.error())));
    }
    // The header of glibc 2.36 declares its function for C only.
    UniqueFd ended(static_cast<int>(::syscall(SYS_pidfd_open, *process, 0)));
    if (!ended.valid()) {
        const int why = errno;
        ::kill(*process, SIGKILL);
        ::waitpid(*process, nullptr, 0);
        return tl::unexpected(fmt::format("no process can be watched: {}", std::strerror(why)));
    }
    return std::shared_ptr<PlotJob>(
        new PlotJob(*process, std::move(ended), std::move(result), later(now, kPatience)));
}

PlotJob::~PlotJob() {
    if (!answer_) {
        ::kill(process_, SIGKILL);
    }
}

void PlotJob::look(Instant now) {
    siginfo_t told{};
    if (answer_ || ::waitid(P_PID, static_cast<id_t>(process_), &told, WEXITED | WNOHANG) != 0) {
        return;
    }
    if (told.si_pid == 0) {
        if (now >= due_) {
            ::kill(process_, SIGKILL);
            too_late_ = true;
            // Its end comes by the descriptor.
            due_ = kNever;
        }
        return;
    }
    const bool fine = told.si_code == CLD_EXITED && told.si_status == kExitFine;
    answer_ = fine ? picture() : failure(told.si_code, told.si_status);
    due_ = kNever;
}

HttpAnswer PlotJob::picture() {
    struct stat told {};
    ::fstat(result_.get(), &told);
    HttpAnswer answer;
    answer.source_bytes = static_cast<std::uint64_t>(told.st_size);
    answer.source = [result = std::make_shared<UniqueFd>(std::move(result_)),
                     at = off_t{0}]() mutable -> std::optional<std::string> {
        std::string piece(kPictureBytesAtOnce, '\0');
        const ssize_t count = ::pread(result->get(), piece.data(), piece.size(), at);
        if (count < 0) {
            return std::nullopt;
        }
        piece.resize(static_cast<std::size_t>(count));
        at += count;
        return piece;
    };
    return answer;
}

HttpAnswer PlotJob::failure(int code, int status) {
    constexpr int kDamaged = 422;
    if (too_late_) {
        return refused(
            kDamaged,
            fmt::format("reading this recording takes longer than {} s",
                        std::chrono::duration_cast<std::chrono::seconds>(kPatience).count()));
    }
    constexpr std::size_t kLongestReason = 1000;
    std::array<char, kLongestReason> said{};
    const ssize_t count = ::pread(result_.get(), said.data(), said.size(), 0);
    std::string why(said.data(), static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (code == CLD_EXITED && status == kExitFailed && !why.empty()) {
        why.erase(why.find_last_not_of('\n') + 1);
        return refused(kDamaged, why);
    }
    return refused(
        kDamaged,
        code == CLD_EXITED
            ? fmt::format("the recording cannot be read: status {}", status)
            : fmt::format("the recording cannot be read: its reader ended by signal {}", status));
}

}  // namespace tribus::web
