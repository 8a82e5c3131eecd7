#include "app/journal/journal.h"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <spdlog/details/null_mutex.h>
#include <spdlog/pattern_formatter.h>
#include <spdlog/sinks/base_sink.h>

#include "app/journal/line_writer.h"
#include "core/utf8.h"
#include "transports/links/unique_fd.h"

namespace tribus {
namespace {

/// Priorities of syslog(3).
int priority_of(spdlog::level::level_enum level) {
    constexpr int kCritical = 2;
    constexpr int kError = 3;
    constexpr int kWarning = 4;
    constexpr int kInformational = 6;
    constexpr int kDebug = 7;
    switch (level) {
        case spdlog::level::critical:
            return kCritical;
        case spdlog::level::err:
            return kError;
        case spdlog::level::warn:
            return kWarning;
        case spdlog::level::info:
            return kInformational;
        default:
            return kDebug;
    }
}

/// A text of several lines is preceded by its length in 64 bits, little-endian.
void append_field(std::string& entry, std::string_view name, std::string_view text) {
    constexpr unsigned kBytesOfLength = 8;
    constexpr unsigned kBitsOfByte = 8;
    entry += name;
    if (text.find('\n') == std::string_view::npos) {
        entry += '=';
    } else {
        entry += '\n';
        for (unsigned byte = 0; byte < kBytesOfLength; ++byte) {
            entry += static_cast<char>(std::uint64_t{text.size()} >> (byte * kBitsOfByte));
        }
    }
    entry += text;
    entry += '\n';
}

/// The flag `%*` of a pattern: the message.
class MessageFlag final : public spdlog::custom_flag_formatter {
  public:
    void format(const spdlog::details::log_msg& message, const std::tm&,
                spdlog::memory_buf_t& destination) override {
        const std::string text = without_control_characters(
            std::string_view(message.payload.data(), message.payload.size()));
        destination.append(text.data(), text.data() + text.size());
    }
    std::unique_ptr<spdlog::custom_flag_formatter> clone() const override {
        return spdlog::details::make_unique<MessageFlag>();
    }
};

class JournalSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
  public:
    explicit JournalSink(const std::string& path)
        : socket_(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
        sockaddr_un address{};
        address.sun_family = AF_UNIX;
        path.copy(address.sun_path, sizeof address.sun_path - 1);
        // If nobody listens there, `send` fails too, and the message goes to standard error.
        [[maybe_unused]] const int ignored =
            ::connect(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address);
    }

  protected:
    void sink_it_(const spdlog::details::log_msg& message) override {
        const std::string text = without_control_characters(
            std::string_view(message.payload.data(), message.payload.size()));
        const std::string entry = journal_entry(message.level, text, LogFields::current());
        if (::send(socket_.get(), entry.data(), entry.size(), MSG_NOSIGNAL) < 0) {
            writer_.write(fmt::format("<{}>{}", priority_of(message.level), text));
        }
    }
    void flush_() override {}

  private:
    UniqueFd socket_;
    LineWriter writer_{STDERR_FILENO};
};

constexpr std::string_view kNoColour = "\x1b[m";

std::string_view colour_of(spdlog::level::level_enum level) {
    return level >= spdlog::level::err    ? "\x1b[31m\x1b[1m"
           : level >= spdlog::level::warn ? "\x1b[33m\x1b[1m"
                                          : "\x1b[32m";
}

/// The sinks of the library wait for whoever reads a full pipe.
class TerminalSink final : public spdlog::sinks::base_sink<spdlog::details::null_mutex> {
  public:
    TerminalSink(int descriptor, bool colours) : writer_(descriptor), colours_(colours) {}

  protected:
    void sink_it_(const spdlog::details::log_msg& message) override {
        spdlog::memory_buf_t formatted;
        formatter_->format(message, formatted);
        std::string line(formatted.data(), formatted.size());
        line.erase(line.find_last_not_of('\n') + 1);
        if (colours_ && message.color_range_end > message.color_range_start) {
            line.insert(message.color_range_end, kNoColour);
            line.insert(message.color_range_start, colour_of(message.level));
        }
        writer_.write(line);
    }
    void flush_() override {}

  private:
    LineWriter writer_;
    bool colours_;
};

/// Characters that are no control characters of ASCII, but act on a line of text: those of ISO 6429
/// (U+0080 to U+009F), line ends of Unicode, and those that turn the direction of writing.
bool acts_on_text(char32_t character) {
    return (character >= 0x80 && character < 0xA0) ||
           (character >= 0x2028 && character <= 0x202E) ||
           (character >= 0x2066 && character <= 0x2069);
}

}  // namespace

std::string without_control_characters(std::string_view text) {
    std::string line;
    line.reserve(text.size());
    while (!text.empty()) {
        const std::size_t length = utf8_length(text);
        const std::string_view character = text.substr(0, std::max<std::size_t>(length, 1));
        text.remove_prefix(character.size());
        const auto first = static_cast<unsigned char>(character.front());
        if (length == 0 || std::iscntrl(first) != 0 ||
            (length > 1 && acts_on_text(utf8_character(character)))) {
            for (const char byte : character) {
                line += fmt::format("\\x{:02x}", static_cast<unsigned char>(byte));
            }
        } else {
            line += character;
        }
    }
    return line;
}

std::unique_ptr<spdlog::formatter> terminal_formatter() {
    auto formatter = std::make_unique<spdlog::pattern_formatter>();
    formatter->add_flag<MessageFlag>('*').set_pattern("%H:%M:%S.%e %^%l%$ %*");
    return formatter;
}

bool stderr_is_journal() {
    const char* const stream = std::getenv("JOURNAL_STREAM");
    struct stat file {};
    return stream != nullptr && ::fstat(STDERR_FILENO, &file) == 0 &&
           stream == fmt::format("{}:{}", file.st_dev, file.st_ino);
}

std::string journal_entry(spdlog::level::level_enum level, std::string_view message,
                          std::span<const LogField> fields) {
    std::string entry;
    append_field(entry, "MESSAGE", message);
    append_field(entry, "PRIORITY", std::to_string(priority_of(level)));
    append_field(entry, "SYSLOG_IDENTIFIER", "tribus");
    for (const LogField& field : fields) {
        if (!field.name.empty()) {
            append_field(entry, field.name, field.text);
        }
    }
    return entry;
}

std::shared_ptr<spdlog::sinks::sink> terminal_sink(int descriptor, bool colours) {
    return std::make_shared<TerminalSink>(descriptor, colours);
}

std::shared_ptr<spdlog::sinks::sink> journal_sink(const std::string& socket) {
    return std::make_shared<JournalSink>(socket);
}

}  // namespace tribus
