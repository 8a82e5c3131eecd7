#include "app/recorder/recording_folder.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include <fmt/format.h>

#include "app/cli/file_error.h"
#include "app/cli/new_file.h"
#include "app/recorder/recording_list.h"
#include "app/replay/capture_text.h"
#include "transports/links/unique_fd.h"

namespace tribus {
namespace {

namespace fs = std::filesystem;
using Failed = tl::unexpected<std::string>;
using Done = tl::expected<void, std::string>;

constexpr std::size_t kPiecesAtOnce = 256;
constexpr std::size_t kBytesAtOnce = std::size_t{64} * 1024;

/// A new file, written once from begin to end.
class NewFile {
  public:
    static tl::expected<NewFile, std::string> make(const fs::path& path) {
        NewFile file;
        file.path_ = path;
        file.fd_ = UniqueFd(::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0640));
        if (!file.fd_.valid()) {
            return file_error(path, errno);
        }
        return file;
    }
    Done write(std::string_view text) {
        while (!text.empty()) {
            const ssize_t count = ::write(fd_.get(), text.data(), text.size());
            if (count < 0 && errno != EINTR) {
                return file_error(path_, errno);
            }
            text.remove_prefix(count < 0 ? 0 : static_cast<std::size_t>(count));
        }
        return {};
    }
    /// Afterwards the file survives a loss of power.
    Done finish() {
        if (::fsync(fd_.get()) != 0) {
            return file_error(path_, errno);
        }
        return {};
    }

  private:
    UniqueFd fd_;
    fs::path path_;
};

Done write_file(const fs::path& path, std::string_view content) {
    auto file = NewFile::make(path);
    if (!file) {
        return Failed(file.error());
    }
    if (auto written = file->write(content); !written) {
        return written;
    }
    return file->finish();
}

/// The two files of a port; a file without a name is not made.
class PortFiles {
  public:
    static tl::expected<PortFiles, std::string> make(const RecordedPort& port,
                                                     const fs::path& folder) {
        PortFiles files;
        for (const auto& [file, name] : {std::pair(&files.read_, &port.read_file),
                                         std::pair(&files.written_, &port.written_file)}) {
            if (name->empty()) {
                continue;
            }
            auto made = NewFile::make(folder / *name);
            if (!made) {
                return Failed(made.error());
            }
            *file = std::move(*made);
        }
        return files;
    }
    /// Writes the collected text when it is worth a system call, or `all` of it.
    Done take(CaptureText& text, bool all) {
        for (const auto& [file, part] :
             {std::pair(&read_, &text.read()), std::pair(&written_, &text.written())}) {
            if (*file && part->size() >= (all ? 1 : kBytesAtOnce)) {
                if (auto written = (*file)->write(*part); !written) {
                    return written;
                }
            }
            if (all || part->size() >= kBytesAtOnce) {
                part->clear();
            }
        }
        return {};
    }
    Done finish() {
        for (std::optional<NewFile>* file : {&read_, &written_}) {
            if (*file) {
                if (auto finished = (*file)->finish(); !finished) {
                    return finished;
                }
            }
        }
        return {};
    }

  private:
    std::optional<NewFile> read_;
    std::optional<NewFile> written_;
};

struct PortCounts {
    std::uint64_t read = 0;
    std::uint64_t written = 0;
    std::uint64_t damaged = 0;
    /// Begin of the remaining data, if older data since the zero was overwritten.
    std::optional<Duration> begin;
};

/// Writes piece by piece: a ring may hold more than the free memory.
tl::expected<PortCounts, std::string> write_port(const RecordedPort& port,
                                                 const RecordingOrder& order,
                                                 const fs::path& folder) {
    auto files = PortFiles::make(port, folder);
    if (!files) {
        return Failed(files.error());
    }
    CaptureText text({.can = port.can,
                      .interface = port.device,
                      .byte_time = port.byte_time,
                      .zero = order.zero,
                      .zero_wall = order.zero_wall,
                      .end = order.end});
    PortCounts counts;
    std::array<CapturePiece, kPiecesAtOnce> pieces;
    const std::uint64_t end = port.ring->end();
    for (std::uint64_t next = port.ring->begin(); next < end;) {
        const auto wanted = std::min<std::uint64_t>(pieces.size(), end - next);
        const auto batch =
            port.ring->read(next, std::span(pieces).first(static_cast<std::size_t>(wanted)));
        next = batch.first + std::max<std::size_t>(batch.count, 1);
        if (!counts.begin && batch.count > 0) {
            const bool overwritten =
                batch.first > 0 && pieces[0].at() > order.zero && pieces[0].at() <= order.end;
            counts.begin = overwritten ? pieces[0].at() - order.zero : Duration::zero();
        }
        text.take(std::span(pieces).first(batch.count));
        if (auto taken = files->take(text, false); !taken) {
            return Failed(taken.error());
        }
    }
    text.finish();
    if (auto taken = files->take(text, true); !taken) {
        return Failed(taken.error());
    }
    if (auto finished = files->finish(); !finished) {
        return Failed(finished.error());
    }
    counts.read = text.read_count();
    counts.written = text.written_count();
    counts.damaged = text.damaged_count();
    return counts;
}

std::string readable_time(Duration wall_time) {
    std::string text = recording_time(wall_time);
    std::ranges::replace(text, 'T', ' ');
    text.replace(13, 1, ":").replace(16, 1, ":").replace(19, 1, " UTC");
    return text;
}

tl::expected<std::string, std::string> write_ports(const RecordingOrder& order,
                                                   const fs::path& folder) {
    std::string list;
    for (const RecordedPort& port : order.ports) {
        const auto counts = write_port(port, order, folder);
        if (!counts) {
            return Failed(counts.error());
        }
        const char* what = port.can ? "frames" : "bursts";
        const auto seconds =
            std::chrono::duration<double>(counts->begin.value_or(Duration::zero())).count();
        const std::string begin =
            seconds > 0 ? fmt::format("; from {:.1f} s on: its memory holds no more", seconds) : "";
        if (!port.read_file.empty()) {
            list += fmt::format("  {:<28} read from {}: {} {}{}\n", port.read_file, port.device,
                                counts->read, what, begin);
        }
        if (!port.written_file.empty()) {
            list += fmt::format("  {:<28} written to {}: {} {}{}\n", port.written_file, port.device,
                                counts->written, what, begin);
        }
        if (counts->damaged > 0) {
            list +=
                fmt::format("  damaged pieces of {}, left out: {}\n", port.device, counts->damaged);
        }
    }
    for (const std::string& lack : order.lacks) {
        list += fmt::format("  not recorded: {}\n", lack);
    }
    return list;
}

Done fill(const RecordingOrder& order, const fs::path& folder) {
    const auto list = write_ports(order, folder);
    if (!list) {
        return Failed(list.error());
    }
    for (const SideFile& file : order.files) {
        if (auto written = write_file(folder / file.name, file.content); !written) {
            return written;
        }
    }
    const std::string text = fmt::format(
        "Recorded by tribus: {}, {}.\n"
        "All times count from {} on (by the clock of this machine).\n\n{}\n"
        "To run the same inputs through the same configuration again, in this folder:\n  {}\n",
        order.reason, readable_time(order.event_wall), readable_time(order.zero_wall), *list,
        order.replay);
    return write_file(folder / "README.txt", text);
}

/// Never removes the recording that was just written.
void remove_oldest(const RecordingOrder& order, const fs::path& newest) {
    std::vector<fs::path> found = recordings_in(order.directory);
    std::size_t count = found.size();
    std::erase(found, newest);
    std::uintmax_t total = size_of_recording(newest);
    for (const fs::path& folder : found) {
        total += size_of_recording(folder);
    }
    for (const fs::path& folder : found) {
        if (count <= order.keep && total <= order.space) {
            return;
        }
        total -= size_of_recording(folder);
        --count;
        std::error_code ignored;
        fs::remove_all(folder, ignored);
    }
}

/// Uses the highest number plus one: a free lower number would make the recording look older than
/// it is.
fs::path name_in(const fs::path& directory, const RecordingOrder& order) {
    const std::string name = recording_time(order.event_wall) + "-" + order.kind;
    int number = 0;
    for (const fs::path& found : recordings_in(directory)) {
        const std::string known = found.filename().string();
        if (known == name || known.starts_with(name + "-")) {
            number = std::max(number, number_of_recording(known));
        }
    }
    return directory / (number == 0 ? name : fmt::format("{}-{}", name, number + 1));
}

/// A folder that root makes, by `tribus run` as root, is for the service too if it lies in one of
/// the service: its parent's owner gets it.
std::error_code make_directories(const fs::path& directory) {
    std::error_code error;
    if (directory.empty() || fs::exists(directory, error)) {
        return error;
    }
    if (const auto failed = make_directories(directory.parent_path())) {
        return failed;
    }
    if (fs::create_directory(directory, error)) {
        const UniqueFd made(
            ::open(directory.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC));
        if (made.valid()) {
            give_to_owner(folder_of(directory).get(), made.get());
        }
    }
    return error;
}

}  // namespace

std::string recording_time(Duration wall_time) {
    const std::time_t seconds = std::chrono::floor<std::chrono::seconds>(wall_time).count();
    std::tm utc{};
    ::gmtime_r(&seconds, &utc);
    std::array<char, 32> text{};
    const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H-%M-%SZ", &utc);
    return {text.data(), length};
}

tl::expected<fs::path, std::string> write_recording(const RecordingOrder& order) {
    std::error_code error = make_directories(order.directory);
    if (error) {
        return Failed(fmt::format("{}: {}", order.directory.string(), error.message()));
    }
    const fs::path folder = name_in(order.directory, order);
    fs::path unfinished = folder;
    unfinished += kUnfinishedEnding;
    if (::mkdir(unfinished.c_str(), 0750) != 0) {
        return file_error(unfinished, errno);
    }
    Done done = fill(order, unfinished);
    if (done && ::rename(unfinished.c_str(), folder.c_str()) != 0) {
        done = file_error(folder, errno);
    }
    if (!done) {
        fs::remove_all(unfinished, error);
        return Failed(done.error());
    }
    const UniqueFd directory(::open(order.directory.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
    ::fsync(directory.get());
    remove_oldest(order, folder);
    return folder;
}

void remove_unfinished_recordings(const fs::path& directory) {
    std::error_code error;
    std::vector<fs::path> found;
    for (fs::directory_iterator at(directory, error), end; !error && at != end;
         at.increment(error)) {
        if (is_unfinished_recording(at->path().filename().string())) {
            found.push_back(at->path());
        }
    }
    for (const fs::path& folder : found) {
        fs::remove_all(folder, error);
    }
}

std::optional<Duration> age_of_latest(const fs::path& directory, const std::string& kind,
                                      Duration wall_now) {
    std::optional<Duration> age;
    for (const fs::path& folder : recordings_in(directory)) {
        struct stat told {};
        // A time in the future means that the clock was set back since.
        if (folder.filename().string().find("Z-" + kind) == kRecordingTimeLength - 1 &&
            ::stat(folder.c_str(), &told) == 0 &&
            std::chrono::seconds(told.st_mtim.tv_sec) < wall_now) {
            const Duration written = std::chrono::seconds(told.st_mtim.tv_sec) +
                                     std::chrono::nanoseconds(told.st_mtim.tv_nsec);
            age = age ? std::min(*age, wall_now - written) : wall_now - written;
        }
    }
    return age;
}

}  // namespace tribus
