#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <tl/expected.hpp>

/// Which browsers may use the page. `tribus pair` makes codes, `tribus-web` turns one into a
/// cookie. They meet in a folder that belongs to the user of `tribus-web`.
namespace tribus::web {

/// The rights of a paired browser. `change` may do all that `look` may.
enum class Role : std::uint8_t { look, change };
std::string_view word_of(Role role);
std::optional<Role> role_of(std::string_view word);

/// Seconds since 1970.
using WallTime = std::chrono::seconds;

/// A browser that may use the page. Only the SHA-256 of its cookie is kept.
struct Session {
    std::string name;
    Role role = Role::look;
    std::string hash;
    WallTime made{};
};

/// The result of a code that somebody typed.
struct CodeTried {
    std::optional<Role> role;  ///< nothing: the code is wrong, or none is valid
    bool any_valid = false;    ///< there is a code that would be right
};

/// A browser that has typed a code.
struct JoiningBrowser {
    std::string name;
    std::string hash;  ///< of its cookie
};

/// The folder with the code and the sessions. Each call reads and writes under a lock, so programs
/// do not disturb each other; files are replaced as a whole. Errors are sentences.
class PairingFolder {
  public:
    explicit PairingFolder(std::filesystem::path folder) : folder_(std::move(folder)) {}

    static constexpr WallTime kCodeLasts = std::chrono::minutes(5);
    static constexpr WallTime kSessionLasts = std::chrono::hours(24 * 90);
    static constexpr std::size_t kMostSessions = 64;

    /// Something that is done before another program may read or write the files.
    using Step = std::function<tl::expected<void, std::string>()>;

    /// Makes a code of 8 signs for one browser. It takes the place of the one before. `then`
    /// follows if it is made.
    tl::expected<std::string, std::string> make_code(Role role, WallTime now,
                                                     const Step& then = {});
    /// A right code is used up; a wrong one changes nothing, else whoever reaches the page could
    /// end each code (`PairingPauses` limits the tries; in the five minutes of a code, 200 tries a
    /// second hit one of 10^12 with a chance of 1 to 18 million). With a right one the browser
    /// `joins`, before the code goes: in between, `lets_change` must not be false.
    tl::expected<CodeTried, std::string> try_code(std::string_view typed, WallTime now,
                                                  const std::optional<JoiningBrowser>& joins = {});

    /// Adds a browser. If there are too many, the oldest goes.
    tl::expected<void, std::string> add_session(std::string_view name, Role role, std::string hash,
                                                WallTime now);
    tl::expected<std::vector<Session>, std::string> sessions() const;
    /// Removes all browsers of that name. Returns how many.
    tl::expected<std::size_t, std::string> revoke(std::string_view name);
    /// Removes the browser whose cookie has that hash.
    tl::expected<void, std::string> leave(std::string_view hash);

    /// Whether a browser may change something, or may soon by a code. What cannot be read lets
    /// nobody in, so it counts as nothing.
    bool lets_change(WallTime now) const;
    /// Takes the step `close` unless a browser may change something. Who holds the files for too
    /// long does not hinder it.
    tl::expected<void, std::string> close_if_unused(WallTime now, const Step& close) const;

    std::filesystem::path sessions_file() const { return folder_ / "sessions.json"; }

  private:
    tl::expected<void, std::string> add(std::string_view name, Role role, std::string hash,
                                        WallTime now);
    tl::expected<void, std::string> write(const std::filesystem::path& file,
                                          const std::string& text) const;
    std::filesystem::path folder_;
};

/// The sessions of a folder, read again when their file has changed: a stream asks each second.
/// Thread-bound.
class SessionsInMemory {
  public:
    /// Empty if the file cannot be read.
    const std::vector<Session>& of(const PairingFolder& folder);

  private:
    struct Version {
        std::uint64_t inode = 0;
        std::int64_t bytes = 0;
        std::int64_t changed_s = 0;
        std::int64_t changed_ns = 0;
        bool operator==(const Version&) const = default;
    };
    Version version_;
    std::vector<Session> sessions_;
};

/// The session whose cookie has that hash, if it has not expired. Null if there is none.
const Session* find_session(const std::vector<Session>& sessions, std::string_view hash,
                            WallTime now);

}  // namespace tribus::web
