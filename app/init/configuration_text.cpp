#include "app/init/configuration_text.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "app/cli/protocol_use.h"
#include "app/init/next_commands.h"
#include "config/keys/keys.h"
#include "config/schema/notation.h"
#include "config/show/paragraph.h"
#include "core/channel_frame.h"
#include "core/quotes.h"
#include "pipelines/rules/settings.h"
#include "transports/codecs/dronecan/dronecan.h"
#include "transports/codecs/ibus/ibus.h"

namespace tribus::init {
namespace {

constexpr std::size_t kColumns = 80;
/// Default of an i.Bus output.
constexpr std::size_t kUsualIbusChannels = 14;

/// One table of the file, with comments between its keys and the equals signs in one column.
class TableText {
  public:
    explicit TableText(std::string_view title) : title_(title) {}

    void comment(std::string_view text) { lines_.push_back({"", std::string(text)}); }
    void key(std::string_view key, std::string value) {
        width_ = std::max(width_, key.size());
        lines_.push_back({std::string(key), std::move(value)});
    }
    /// A key in a comment, which the user can uncomment.
    void commented_key(std::string_view key, std::string_view value) {
        comment(fmt::format("{} = {}", key, value));
    }
    std::string text() const {
        std::string text = fmt::format("\n[{}]\n", title_);
        for (const auto& [key, value] : lines_) {
            text += key.empty() ? paragraph("# ", "# ", value, kColumns)
                                : fmt::format("{:<{}} = {}\n", key, width_, value);
        }
        return text;
    }

  private:
    std::string title_;
    std::size_t width_ = 0;
    std::vector<std::pair<std::string, std::string>> lines_;
};

/// "receiver", "receiver2", ...
std::vector<std::string> numbered(std::vector<std::string> names) {
    for (std::size_t i = names.size(); i-- > 0;) {
        const auto end = names.begin() + static_cast<std::ptrdiff_t>(i);
        const auto before = std::count(names.begin(), end, names[i]);
        names[i] += before == 0 ? "" : std::to_string(before + 1);
    }
    return names;
}

SettingValues default_settings(const Protocol& protocol) {
    const auto use = use_protocol(protocol, SettingScope::output, {});
    return use ? use->settings : SettingValues{};
}

bool signals_failsafe(const Attachment& output) {
    const Protocol& protocol = *output.protocol;
    return protocol.signals_failsafe(default_settings(protocol));
}

std::string node_of(const Attachment& end) {
    return printable_or(end.node, "a port");
}

void add_place(const Attachment& end, TableText& table) {
    table.key("protocol", in_quotes(end.protocol->name));
    if (end.name != end.node) {
        table.comment(fmt::format("This name stays the same; now it is {}.", node_of(end)));
    }
    table.key(end.medium->place.key, in_quotes(end.name));
}

std::string input_text(const Attachment& input, std::string_view name, std::string_view file) {
    TableText table(fmt::format("input.{}", name));
    for (const std::string& remark : input.remarks) {
        table.comment(remark);
    }
    add_place(input, table);
    if (input.medium->inverts) {
        table.comment(
            "The receiver's signal is at the port's data line in (MISO); no inverter. Its board: "
            "/usr/share/doc/tribus/docs/boards/spi.md.");
    }
    std::string timeout = in_quotes(format_duration(SupervisionSettings{}.timeout));
    for (const doctor::HeardKey& heard : input.keys) {
        if (heard.key == "timeout") {
            timeout = heard.value;
        } else {
            table.key(heard.key, heard.value);
        }
    }
    table.comment("The input is lost after this time without a good frame.");
    table.key("timeout", timeout);
    table.comment(fmt::format(
        "Some receivers go on sending after they have lost the transmitter. `tribus learn {}:{}` "
        "finds out whether this one does, and prints the line to add here, such as",
        file, name));
    table.commented_key("failsafe_when", "[{ channel = 3, below = 950 }]");
    return table.text();
}

void add_output_remarks(const Attachment& output, const Plan& plan, TableText& table) {
    const Protocol& protocol = *output.protocol;
    if (output.medium->inverts) {
        table.comment(
            "The port's data line (MOSI) is the signal; no inverter. Its board: "
            "/usr/share/doc/tribus/docs/boards/spi.md.");
    } else if (protocol.line.inverted_wire) {
        table.comment(
            "This protocol is inverted on the wire. Put an inverter between TX and the servos "
            "(/usr/share/doc/tribus/docs/boards/wiring.md), unless the port inverts by itself.");
    }
    const bool all_channels = std::ranges::any_of(
        plan.inputs, [](const Attachment& input) { return input.channels > kUsualIbusChannels; });
    if (&protocol == &kIbusProtocol && all_channels) {
        table.comment(
            "Every i.Bus device reads 14 channels. Some read 18 (ArduPilot does not); to send them "
            "all channels that were heard:");
        table.commented_key("channels", "18");
    }
    if (&protocol == &kDroneCanProtocol) {
        table.comment(
            "Node id of this board: 1 to 125, different from all other nodes of the bus.");
        table.key("node_id", "42");
    }
}

std::string output_text(const Attachment& output, std::string_view name, const Plan& plan) {
    const Protocol& protocol = *output.protocol;
    TableText table(fmt::format("output.{}", name));
    add_place(output, table);
    add_output_remarks(output, plan, table);
    table.comment(fmt::format("Shortest time between two frames, at least {}.",
                              in_quotes(format_duration(protocol.least_period))));
    table.commented_key("period", in_quotes(format_duration(protocol.default_period)));
    return table.text();
}

/// One name, or a list of them.
std::string name_list(const std::vector<std::string>& names) {
    if (names.size() == 1) {
        return in_quotes(names.front());
    }
    const std::vector<std::string_view> views(names.begin(), names.end());
    return fmt::format("[{}]", in_quotes_all(views));
}

std::string pipeline_text(const Plan& plan) {
    TableText table("pipeline.main");
    if (plan.inputs.size() > 1) {
        table.comment("The first healthy input in this order has control.");
    }
    table.key("from", name_list(input_names(plan)));
    table.key("to", name_list(output_names(plan)));
    const std::size_t channels = plan.inputs.front().channels;
    if (channels > 0 && channels < kChannelCount) {
        table.comment(fmt::format(
            "The receiver sends {} channels. Outputs send their presets (below) for the others, or "
            "nothing if the format can leave channels out.",
            channels));
    }
    table.comment(
        "Channels pass unchanged. To change some, uncomment these lines (man tribus.toml):");
    table.comment("[pipeline.main.channels]");
    table.comment("1 = { from = 1, reverse = true, trim = 12, min = 1100, max = 1900 }");
    return table.text();
}

void add_action(const Plan& plan, TableText& table) {
    const auto saying = std::ranges::count_if(plan.outputs, signals_failsafe);
    if (saying == std::ssize(plan.outputs)) {
        table.comment(
            "After that the outputs send the presets below, marked failsafe. Also allowed: "
            "\"silence\", \"hold\".");
        table.key("action", "\"preset\"");
    } else if (saying == 0) {
        table.comment(
            "After that the output falls silent: its protocol has no mark for failsafe, so presets "
            "would look like control. \"preset\" sends those below nevertheless.");
        table.key("action", "\"silence\"");
    } else {
        table.comment(
            "After that, outputs whose protocol has a mark for failsafe send the presets below "
            "with "
            "this mark; the others fall silent.");
    }
}

std::string failsafe_text(const Plan& plan) {
    const FailsafeSettings defaults;
    TableText table("pipeline.main.failsafe");
    table.comment(
        "When no input is healthy, the outputs repeat the last values for this time, marked "
        "\"frame lost\" if the protocol has that mark.");
    table.key("hold", in_quotes(format_duration(defaults.hold)));
    add_action(plan, table);
    table.comment(
        "SET THIS TO WHAT IS SAFE ON YOUR MACHINE, in microseconds, before anything moves. "
        "Channel 3 is the throttle of most transmitters. 988 stops the motor of most "
        "aeroplanes and multicopters, but is full reverse for speed controllers with reverse "
        "(cars, boats, rovers), which stop at 1500.");
    table.key("preset", fmt::format("{{ 3 = {}, other = 1500 }}", format_number(plan.throttle_us)));
    table.comment(
        "Good frames must come for this time without a break before they have control again.");
    table.key("recover", in_quotes(format_duration(defaults.recover)));
    return table.text();
}

std::string places(const std::vector<Attachment>& ends) {
    std::string text;
    for (const Attachment& end : ends) {
        text +=
            fmt::format("{}{} at {}", text.empty() ? "" : ", ", end.protocol->name, node_of(end));
    }
    return text;
}

}  // namespace

std::vector<std::string> input_names(const Plan& plan) {
    std::vector<std::string> names;
    std::ranges::transform(plan.inputs, std::back_inserter(names), [](const Attachment& input) {
        return input.protocol->shape == WireShape::bytes ? "receiver" : "bus";
    });
    return numbered(std::move(names));
}

std::vector<std::string> output_names(const Plan& plan) {
    std::vector<std::string> names;
    std::ranges::transform(plan.outputs, std::back_inserter(names), [](const Attachment& output) {
        return output.protocol->shape == WireShape::bytes ? "servos" : "bus";
    });
    return numbered(std::move(names));
}

bool sends_presets(const Plan& plan) {
    return std::ranges::any_of(plan.outputs, signals_failsafe);
}

std::string configuration_text(const Plan& plan, std::string_view file_name) {
    const std::string file = name_in_comments(file_name);
    std::string text = paragraph("# ", "# ",
                                 fmt::format("{} to {}, written by `tribus init`.",
                                             places(plan.inputs), places(plan.outputs)),
                                 kColumns);
    text += paragraph(
        "# ", "# ",
        "All keys: man tribus.toml. All values, with the defaults: tribus check " + file, kColumns);
    text += "#\n# Before anything moves, with the propellers off:\n";
    if (sends_presets(plan)) {
        text += paragraph("# - ", "#   ",
                          "Set `preset` at the end to what is safe on your machine.", kColumns);
    }
    text += paragraph("# - ", "#   ",
                      fmt::format("Run `tribus learn {}:{}`: it finds out what the receiver does "
                                  "without its transmitter.",
                                  file, input_names(plan).front()),
                      kColumns);
    const auto inputs = input_names(plan);
    for (std::size_t i = 0; i < inputs.size(); ++i) {
        text += input_text(plan.inputs[i], inputs[i], file);
    }
    const auto outputs = output_names(plan);
    for (std::size_t i = 0; i < outputs.size(); ++i) {
        text += output_text(plan.outputs[i], outputs[i], plan);
    }
    return text + pipeline_text(plan) + failsafe_text(plan);
}

}  // namespace tribus::init
