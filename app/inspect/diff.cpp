#include "app/inspect/diff.h"

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "app/cli/complain.h"
#include "app/cli/exit_status.h"
#include "app/cli/load_or_explain.h"
#include "app/client/ask_daemon.h"
#include "app/client/status_fields.h"
#include "app/inspect/live_difference.h"
#include "app/inspect/value_text.h"
#include "config/build/carry_over.h"
#include "config/load.h"
#include "config/show/effective.h"

namespace tribus {
namespace {

using OrderedJson = nlohmann::ordered_json;
using Lines = std::vector<std::string>;

void compare_channels(const OrderedJson& before, const OrderedJson& after, std::string_view input,
                      Lines& lines) {
    constexpr int kChannels = 18;
    for (int channel = 1; channel <= kChannels; ++channel) {
        const std::string key = std::to_string(channel);
        const auto words = [&](const OrderedJson& rules) {
            return rules.contains(key) ? channel_text(rules[key]) : "channel " + key;
        };
        if (words(before) != words(after)) {
            lines.push_back(fmt::format("{}channel {}: {} before, now {}", input, channel,
                                        words(before), words(after)));
        }
    }
}

/// One line for each changed setting; nested tables are compared key by key.
void compare(const OrderedJson& before, const OrderedJson& after, const std::string& path,
             Lines& lines) {
    const auto compare_key = [&](const std::string& key) {
        const OrderedJson old_value = before.value(key, OrderedJson());
        const OrderedJson new_value = after.value(key, OrderedJson());
        const std::string name = path.empty() ? key : path + "." + key;
        if (key == "channels" || key == "map") {
            compare_channels(old_value, new_value, key == "map" ? "its own " : "", lines);
        } else if (old_value.is_object() && new_value.is_object()) {
            compare(old_value, new_value, name, lines);
        } else if (old_value.is_null()) {
            lines.push_back(fmt::format("{}: not set before, now {}", name, plain_text(new_value)));
        } else if (new_value.is_null()) {
            lines.push_back(fmt::format("{}: {} before, now not set", name, plain_text(old_value)));
        } else if (old_value != new_value) {
            lines.push_back(fmt::format("{}: {} before, now {}", name, plain_text(old_value),
                                        plain_text(new_value)));
        }
    };
    for (const auto& [key, value] : before.items()) {
        compare_key(key);
    }
    for (const auto& [key, value] : after.items()) {
        if (!before.contains(key)) {
            compare_key(key);
        }
    }
}

class Difference {
  public:
    Difference(const Configuration& running, const Configuration& fresh)
        : running_(running),
          fresh_(fresh),
          plan_(plan_carry_over(running, fresh)),
          before_(OrderedJson::parse(effective_json(running))),
          after_(OrderedJson::parse(effective_json(fresh))) {}

    std::string text() {
        section("runtime", "", before_["runtime"], after_["runtime"]);
        recorder();
        for (const std::string_view kind : {"input", "output", "pipeline", "gpio", "sensor_type",
                                            "values", "sensor_bus", "dronecan"}) {
            tables(std::string(kind));
        }
        if (text_.empty()) {
            return {};
        }
        for (const std::string& obstacle : plan_.obstacles) {
            text_ += fmt::format("a reload stops all outputs for a moment: {}\n", obstacle);
        }
        return text_;
    }

  private:
    void section(const std::string& kind, const std::string& name, const OrderedJson& before,
                 const OrderedJson& after) {
        Lines lines;
        compare(before, after, "", lines);
        if (lines.empty()) {
            return;
        }
        const std::string meaning = meaning_of(kind, name);
        text_ += fmt::format("{}{}{}:\n", kind, name.empty() ? "" : " ", name);
        for (const std::string& line : lines) {
            text_ += fmt::format("  {}\n", line);
        }
        if (!meaning.empty()) {
            text_ += fmt::format("  ({})\n", meaning);
        }
    }

    /// The table [recorder] is optional.
    void recorder() {
        const bool before = before_.contains("recorder");
        const bool after = after_.contains("recorder");
        if (before && after) {
            section("recorder", "", before_["recorder"], after_["recorder"]);
        } else if (before || after) {
            text_ += after ? "recorder: new\n" : "recorder: removed\n";
        }
    }

    void tables(const std::string& kind) {
        const OrderedJson before = before_.value(kind, OrderedJson::object());
        const OrderedJson after = after_.value(kind, OrderedJson::object());
        for (const auto& [name, table] : before.items()) {
            if (after.contains(name)) {
                section(kind, name, table, after[name]);
            } else if (const auto now = renamed_to(kind, name)) {
                text_ += fmt::format("{} {}: is now called {}, and goes on\n", kind, name, *now);
            } else {
                text_ +=
                    fmt::format("{} {}: removed{}\n", kind, name,
                                kind == "output" ? "; it sends its last frames as at the end" : "");
            }
        }
        for (const auto& [name, table] : after.items()) {
            if (!before.contains(name) && !came_from(kind, name)) {
                text_ += fmt::format("{} {}: new\n", kind, name);
            }
        }
    }

    /// Name of the old part from which the new part `name` goes on.
    std::optional<std::string> came_from(const std::string& kind, const std::string& name) const {
        const auto look = [&](const auto& parts, const auto& parts_before,
                              const auto& carries) -> std::optional<std::string> {
            for (std::size_t i = 0; i < parts.size(); ++i) {
                if (parts[i].name == name && carries[i].from) {
                    return parts_before[*carries[i].from].name;
                }
            }
            return std::nullopt;
        };
        if (kind == "input") {
            return look(fresh_.inputs, running_.inputs, plan_.engine.inputs);
        }
        return kind == "output" ? look(fresh_.outputs, running_.outputs, plan_.engine.outputs)
                                : std::nullopt;
    }

    std::optional<std::string> renamed_to(const std::string& kind, const std::string& name) const {
        const OrderedJson after = after_.value(kind, OrderedJson::object());
        for (const auto& [fresh_name, table] : after.items()) {
            if (came_from(kind, fresh_name) == name) {
                return fresh_name;
            }
        }
        return std::nullopt;
    }

    std::string meaning_of(const std::string& kind, const std::string& name) const {
        if (kind == "input") {
            return came_from(kind, name) ? "it goes on; nothing is lost"
                                         : "it starts again, as never seen";
        }
        if (kind == "output") {
            return came_from(kind, name)
                       ? "it goes on; the change applies from its next frame"
                       : "the old one sends its last frames, then the new one starts";
        }
        return kind == "pipeline" ? "applies from the next frame of its outputs" : "";
    }

    const Configuration& running_;
    const Configuration& fresh_;
    CarryOver plan_;
    OrderedJson before_;
    OrderedJson after_;
    std::string text_;
};

struct DiffOptions {
    std::string first;
    std::string fresh;
    std::string daemon;
    std::optional<std::string> socket;
};

int compare_files(const DiffOptions& options) {
    const auto running = load_or_explain(options.first);
    const auto fresh = load_or_explain(options.fresh);
    if (!running || !fresh) {
        return kExitWrongUse;
    }
    fmt::print("{}", configuration_difference(*running, *fresh));
    return kExitFine;
}

/// If several daemons run, takes the one with the name of the file.
tl::expected<std::string, std::string> daemon_of(const DiffOptions& options) {
    if (options.socket || !options.daemon.empty()) {
        return find_daemon(options.daemon, options.socket, Wants::look);
    }
    auto namesake = find_daemon(options.first, std::nullopt, Wants::look);
    return namesake ? namesake : find_daemon("", std::nullopt, Wants::look);
}

int compare_with_daemon(const DiffOptions& options) {
    constexpr Duration kPatience = std::chrono::seconds(5);
    const auto fresh = load_or_explain(options.first);
    if (!fresh) {
        return kExitWrongUse;
    }
    const auto socket = daemon_of(options);
    const auto answer = socket.and_then(
        [&](const std::string& path) { return ask_daemon(path, "configuration", kPatience); });
    if (!answer) {
        return complain(answer.error(), kExitFailed);
    }
    const auto status = ask_daemon(*socket, "status", kPatience);
    if (!status) {
        return complain(status.error(), kExitFailed);
    }
    const auto running = load_configuration(status_fields::raw_text(*answer, "toml"),
                                            status_fields::text(*answer, "file"));
    if (!running) {
        explain_mistakes(running.error());
        return complain(
            "the configuration of the daemon cannot be read here; a file that it names has changed",
            kExitFailed);
    }
    const std::string difference = configuration_difference(*running, *fresh);
    if (!difference.empty()) {
        fmt::print("{}{}", difference,
                   live_difference(*running, *fresh, live_inputs(*running, *status)));
    }
    return kExitFine;
}

}  // namespace

std::string configuration_difference(const Configuration& running, const Configuration& fresh) {
    return Difference(running, fresh).text();
}

Command diff_command() {
    auto options = std::make_shared<DiffOptions>();
    CommandOption socket = daemon_socket_option(options->socket);
    socket.excludes = {"NEW"};
    return {
        .name = "diff",
        .help = "Print what changes if a configuration replaces another one",
        .notes =
            "One line for each changed setting and channel, and what a reload does with it. "
            "Prints nothing if nothing changes. With a running daemon: also what each output "
            "would send with the sticks as they are now.",
        .options =
            {{.name = "CONFIG",
              .value = &options->first,
              .help = "The running configuration; without NEW, the one to replace that of a daemon",
              .required = true},
             {.name = "NEW",
              .value = &options->fresh,
              .help = "The configuration to replace CONFIG",
              .value_name = "CONFIG"},
             {.name = "--daemon",
              .value = &options->daemon,
              .help = "Name of the daemon's configuration file; needed if several run and none has "
                      "the name of CONFIG",
              .value_name = "NAME",
              .excludes = {"NEW"},
              .offers = running_daemons},
             std::move(socket)},
        .examples = {{"tribus diff servos.toml new.toml", "two files"},
                     {"tribus diff new.toml --daemon servos",
                      "a file and what a daemon runs, with the sticks as they are now"}},
        .run =
            [options] {
                return options->fresh.empty() ? compare_with_daemon(*options)
                                              : compare_files(*options);
            },
    };
}

}  // namespace tribus
