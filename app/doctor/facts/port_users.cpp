#include "app/doctor/facts/port_users.h"

#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <system_error>
#include <utility>

namespace tribus::doctor {
namespace {

namespace fs = std::filesystem;

enum class Has : std::uint8_t { no, yes, hidden };

Has has_open(const KernelFiles& files, const std::string& process, const std::string& node) {
    std::error_code error;
    for (fs::directory_iterator entry(files.at(process + "/fd"), error), end;
         !error && entry != end; entry.increment(error)) {
        std::error_code none;
        if (fs::read_symlink(entry->path(), none) == node) {
            return Has::yes;
        }
    }
    return error == std::errc::permission_denied ? Has::hidden : Has::no;
}

/// getty and agetty have the name of the port among their arguments.
bool waits_for(const std::string& command_line, const std::string& name) {
    std::istringstream words(command_line);
    std::string word;
    words >> word;
    if (!word.ends_with("getty")) {
        return false;
    }
    while (words >> word) {
        if (word == name || word == "/dev/" + name) {
            return true;
        }
    }
    return false;
}

/// The last part of "0::/system.slice/tribus@servos.service", if it is a service. systemd escapes -
/// as \x2d only in slices.
std::string unit_of(const std::string& groups) {
    std::istringstream lines(groups);
    for (std::string line; std::getline(lines, line);) {
        std::string last = line.substr(line.rfind('/') + 1);
        if (last.ends_with(".service")) {
            return last;
        }
    }
    return {};
}

}  // namespace

NodeUsers users_of(const KernelFiles& files, const std::string& node,
                   const std::string& login_name) {
    NodeUsers found;
    for (const std::string& name : files.names_in("proc")) {
        if (name.find_first_not_of("0123456789") != std::string::npos) {
            continue;
        }
        const std::string process = "proc/" + name;
        const bool login =
            !login_name.empty() && waits_for(files.line(process + "/cmdline"), login_name);
        const Has open = has_open(files, process, node);
        found.hidden = found.hidden || open == Has::hidden;
        if (login || open == Has::yes) {
            found.users.push_back({.process = std::atoi(name.c_str()),
                                   .command = files.line(process + "/comm"),
                                   .unit = unit_of(files.text(process + "/cgroup")),
                                   .is_login = login});
        }
    }
    return found;
}

std::string names_of_users(const std::vector<PortUser>& users) {
    constexpr std::size_t kMostNamed = 3;
    std::string names;
    for (std::size_t i = 0; i < std::min(users.size(), kMostNamed); ++i) {
        names += fmt::format("{}{} (process {})", i == 0 ? "" : ", ", users[i].command,
                             users[i].process);
    }
    return users.size() > kMostNamed
               ? names + fmt::format(" and {} more", users.size() - kMostNamed)
               : names;
}

void look_at_users(const KernelFiles& files, SerialFacts& facts) {
    NodeUsers found = users_of(files, facts.node, facts.name);
    facts.users = std::move(found.users);
    facts.users_hidden = found.hidden;
}

}  // namespace tribus::doctor
