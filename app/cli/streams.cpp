#include "app/cli/streams.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <utility>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/journal/print_error.h"
#include "config/show/paragraph.h"

namespace tribus {
namespace {

constexpr std::size_t kReadSize = std::size_t{64} * 1024;

tl::unexpected<std::string> failure(std::string_view name, int error) {
    return tl::unexpected<std::string>(fmt::format("{}: {}", name, std::strerror(error)));
}

}  // namespace

InputFile::InputFile(UniqueFd descriptor, std::string name)
    : descriptor_(std::move(descriptor)),
      name_(std::move(name)),
      opened_at_(::lseek(descriptor_.get(), 0, SEEK_CUR)) {}

tl::expected<InputFile, std::string> InputFile::open(std::string_view name) {
    if (name.empty() || name == "-") {
        return InputFile(UniqueFd(::fcntl(STDIN_FILENO, F_DUPFD_CLOEXEC, 0)), "standard input");
    }
    return open_path(name);
}

tl::expected<InputFile, std::string> InputFile::open_path(std::string_view path) {
    std::string name(path);
    UniqueFd descriptor(::open(name.c_str(), O_RDONLY | O_CLOEXEC | O_NOCTTY));
    if (!descriptor.valid()) {
        return failure(name, errno);
    }
    return InputFile(std::move(descriptor), std::move(name));
}

bool InputFile::is_whole() const {
    struct stat about {};
    return ::fstat(descriptor_.get(), &about) == 0 && S_ISREG(about.st_mode);
}

tl::expected<std::string, std::string> InputFile::read_some() {
    std::string bytes(kReadSize, '\0');
    ssize_t count = 0;
    do {
        count = ::read(descriptor_.get(), bytes.data(), bytes.size());
    } while (count < 0 && errno == EINTR);
    if (count < 0) {
        return failure(name_, errno);
    }
    bytes.resize(static_cast<std::size_t>(count));
    return bytes;
}

tl::expected<std::string, std::string> InputFile::read_all(std::string beginning) {
    std::string content = std::move(beginning);
    const bool piped = !is_whole();
    if (piped) {
        // Growing would take twice the memory.
        content.reserve(kMostPipedBytes + kReadSize);
    }
    while (!piped || content.size() <= kMostPipedBytes) {
        auto bytes = read_some();
        if (!bytes || bytes->empty()) {
            return bytes ? tl::expected<std::string, std::string>(std::move(content))
                         : std::move(bytes);
        }
        content += *bytes;
    }
    return tl::unexpected(
        fmt::format("{}: more than {} MiB, and no end; save it as a file and name that", name_,
                    kMostPipedBytes / (std::size_t{1024} * 1024)));
}

void InputFile::rewind() {
    ::lseek(descriptor_.get(), opened_at_, SEEK_SET);
}

tl::expected<std::unique_ptr<FilePieces>, std::string> FilePieces::open_path(
    std::string_view path) {
    auto file = InputFile::open_path(path);
    if (!file) {
        return tl::unexpected(std::move(file.error()));
    }
    return of(std::move(*file));
}

tl::expected<std::unique_ptr<FilePieces>, std::string> FilePieces::of(InputFile file,
                                                                      std::string beginning) {
    std::unique_ptr<FilePieces> pieces(new FilePieces(std::move(file)));
    if (pieces->file_.is_whole()) {
        pieces->file_.rewind();
    } else {
        auto content = pieces->file_.read_all(std::move(beginning));
        if (!content) {
            return tl::unexpected(std::move(content.error()));
        }
        pieces->piece_ = std::move(*content);
        pieces->whole_.emplace(pieces->piece_);
    }
    return pieces;
}

std::string_view FilePieces::next() {
    if (whole_) {
        return whole_->next();
    }
    auto bytes = file_.read_some();
    if (!bytes) {
        failed_ = std::move(bytes.error());
    }
    piece_ = std::move(bytes).value_or(std::string());
    return piece_;
}

void FilePieces::rewind() {
    if (whole_) {
        whole_->rewind();
    } else {
        file_.rewind();
    }
}

std::optional<std::size_t> terminal_columns(int descriptor) {
    winsize size{};
    const bool known = ::ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    return known ? std::optional<std::size_t>(size.ws_col) : std::nullopt;
}

void hold_standard_streams() {
    for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
        if (::fcntl(stream, F_GETFD) < 0) {
            ::open("/dev/null", stream == STDIN_FILENO ? O_WRONLY : O_RDONLY);
        }
    }
}

bool print_line_now(std::string_view line) {
    std::fwrite(line.data(), 1, line.size(), stdout);
    std::fputc('\n', stdout);
    return std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
}

std::size_t text_columns(int descriptor) {
    constexpr std::size_t kPlainColumns = 80;
    constexpr std::size_t kMostColumns = 100;
    return std::min(terminal_columns(descriptor).value_or(kPlainColumns), kMostColumns);
}

void tell_person(std::string_view text, std::string_view first) {
    const std::string rest(first.size(), ' ');
    print_error("{}", paragraph(first, rest, text, text_columns(STDERR_FILENO)));
}

int finish_standard_output(int status) {
    std::cout.flush();
    const bool flushed = std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
    if (flushed && std::cout.good()) {
        return status;
    }
    pollfd output{.fd = STDOUT_FILENO, .events = POLLOUT, .revents = 0};
    const bool reader_gone = ::poll(&output, 1, 0) == 1 && (output.revents & POLLERR) != 0;
    return reader_gone ? status : complain("cannot write to standard output", kExitFailed);
}

}  // namespace tribus
