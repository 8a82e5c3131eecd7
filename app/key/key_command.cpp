#include "app/key/key_command.h"

#include <fmt/format.h>

#include <memory>
#include <string>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/key/key_file_made.h"
#include "config/language/key_file.h"

namespace tribus {
namespace {

struct KeyOptions {
    std::string action;
    std::string file;
    bool fingerprint = false;
};

int make(const KeyOptions& options) {
    const auto made = make_key_file(options.file);
    if (!made) {
        return complain(made.error(), kExitFailed);
    }
    fmt::print("{}: a new key, fingerprint {}\n", options.file, fingerprint(made->secret));
    if (made->service_reads) {
        fmt::print("Its owner and the group {}, which the service has, may read it.\n", kKeyGroup);
    } else {
        fmt::print(
            "Only its owner may read it. For the service: sudo chgrp {} {}; "
            "sudo chmod 0640 {}\n",
            kKeyGroup, options.file, options.file);
    }
    fmt::print(
        "Both ends of a link need this file. Copy it on a way that nobody else can read, "
        "such as scp.\n");
    return kExitFine;
}

int show(const KeyOptions& options) {
    const auto secret = read_secret(options.file);
    if (!secret) {
        return complain(
            fmt::format("{}: {}; allowed: {}", options.file, secret.error(), kAllowedKeyFile),
            kExitFailed);
    }
    const std::string shown = fingerprint(*secret);
    if (options.fingerprint) {
        fmt::print("{}\n", shown);
    } else {
        fmt::print("{}: fingerprint {}\n", options.file, shown);
    }
    return kExitFine;
}

}  // namespace

Command key_command() {
    auto options = std::make_shared<KeyOptions>();
    return {
        .name = "key",
        .help = "Make a key file for an authenticated link, or show its fingerprint",
        .notes =
            "The key itself is never shown: two files with the same fingerprint have the same "
            "key.",
        .options = {{.name = "ACTION",
                     .value = &options->action,
                     .help = "new: make the file with a random key; show: print the fingerprint of "
                             "its key",
                     .required = true,
                     .choices = {"new", "show"}},
                    {.name = "FILE",
                     .value = &options->file,
                     .help = "The key file, such as /etc/tribus/keys/boat.key",
                     .required = true},
                    {.name = "--fingerprint",
                     .value = &options->fingerprint,
                     .help = "Print nothing but the fingerprint, for scripts"}},
        .examples = {{"tribus key new /etc/tribus/keys/boat.key",
                      "a new key; the file is then copied to the other end of the link"},
                     {"tribus key show --fingerprint boat.key",
                      "two ends with the same fingerprint have the same key"}},
        .run = [options] { return options->action == "new" ? make(*options) : show(*options); },
    };
}

}  // namespace tribus
