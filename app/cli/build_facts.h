#pragma once

#include <string>
#include <string_view>

namespace tribus {

/// How a program was built, without times and paths: two builds of one commit are the same bytes.
struct BuildFacts {
    /// `0.3.0`
    std::string_view version;
    /// `GCC 12.2.0 for Debian GNU/Linux 12 amd64, Release, hardened`
    std::string_view how;
    /// Empty: not known.
    std::string_view commit;
};

/// The facts of this program. app/build_facts.cmake writes them; only programs have them.
BuildFacts build_facts();

/// Returns the text that `--version` prints. Pure.
inline std::string version_text(std::string_view program, const BuildFacts& built) {
    std::string text(program);
    text.append(" ").append(built.version).append("\nbuilt with ").append(built.how);
    if (!built.commit.empty()) {
        text.append(", commit ").append(built.commit);
    }
    return text + "\n";
}

}  // namespace tribus
