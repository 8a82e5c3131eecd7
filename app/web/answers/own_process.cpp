#include "app/web/answers/own_process.h"

#include <spawn.h>
#include <unistd.h>

#include <csignal>

namespace tribus::web {
namespace {

/// The rules of posix_spawn(3), freed at the end.
class SpawnRules {
  public:
    explicit SpawnRules(const ProcessFiles& files) {
        ::posix_spawn_file_actions_init(&files_);
        ::posix_spawn_file_actions_adddup2(&files_, files.input, STDIN_FILENO);
        ::posix_spawn_file_actions_adddup2(&files_, files.output, STDOUT_FILENO);
        if (files.error >= 0) {
            ::posix_spawn_file_actions_adddup2(&files_, files.error, STDERR_FILENO);
        }
        sigset_t none;
        ::sigemptyset(&none);
        ::posix_spawnattr_init(&attributes_);
        ::posix_spawnattr_setsigmask(&attributes_, &none);
        // This program ignores it; a child that prints must end when nobody reads.
        sigset_t usual;
        ::sigemptyset(&usual);
        ::sigaddset(&usual, SIGPIPE);
        ::posix_spawnattr_setsigdefault(&attributes_, &usual);
        ::posix_spawnattr_setflags(&attributes_, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
    }
    SpawnRules(const SpawnRules&) = delete;
    SpawnRules& operator=(const SpawnRules&) = delete;
    ~SpawnRules() {
        ::posix_spawn_file_actions_destroy(&files_);
        ::posix_spawnattr_destroy(&attributes_);
    }

    const posix_spawn_file_actions_t* files() const { return &files_; }
    const posix_spawnattr_t* attributes() const { return &attributes_; }

  private:
    posix_spawn_file_actions_t files_{};
    posix_spawnattr_t attributes_{};
};

}  // namespace

tl::expected<pid_t, int> start_own_program(const std::vector<std::string>& words,
                                           const ProcessFiles& files) {
    std::vector<std::string> all{"tribus-web"};
    all.insert(all.end(), words.begin(), words.end());
    std::vector<char*> arguments;
    arguments.reserve(all.size() + 1);
    for (std::string& word : all) {
        arguments.push_back(word.data());
    }
    arguments.push_back(nullptr);
    const SpawnRules rules(files);
    pid_t process = 0;
    const int error = ::posix_spawn(&process, "/proc/self/exe", rules.files(), rules.attributes(),
                                    arguments.data(), environ);
    return error == 0 ? tl::expected<pid_t, int>(process) : tl::unexpected(error);
}

}  // namespace tribus::web
