#include "app/cli/configured_use.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string_view>
#include <vector>

#include "app/cli/load_or_explain.h"
#include "config/language/mistakes.h"
#include "config/schema/schema.h"
#include "core/quotes.h"

namespace tribus {
namespace {

using Refused = tl::unexpected<std::string>;

template <class Ports>
std::optional<ProtocolUse> find_in(const Ports& ports, std::string_view name) {
    const auto port = std::ranges::find_if(ports, [&](const auto& p) { return p.name == name; });
    if (port == ports.end()) {
        return std::nullopt;
    }
    ProtocolUse use{port->protocol, port->settings, port->port.line};
    if constexpr (requires { port->supervision; }) {
        use.supervision = port->supervision;
    }
    return use;
}

std::vector<std::string_view> names_in(const Configuration& configuration) {
    std::vector<std::string_view> names;
    for (const InputConfig& input : configuration.inputs) {
        names.push_back(input.name);
    }
    for (const OutputConfig& output : configuration.outputs) {
        names.push_back(output.name);
    }
    return names;
}

}  // namespace

tl::expected<ProtocolUse, std::string> configured_use(const std::string& file_and_name,
                                                      SettingScope direction) {
    const std::size_t colon = file_and_name.rfind(':');
    if (colon == std::string::npos) {
        return Refused(fmt::format("--as {}: must be FILE:NAME", file_and_name));
    }
    const std::string file = file_and_name.substr(0, colon);
    const std::string name = file_and_name.substr(colon + 1);
    const auto configuration = load_or_explain(file);
    if (!configuration) {
        return Refused(fmt::format("--as {}: the configuration has mistakes", file_and_name));
    }
    const auto input = find_in(configuration->inputs, name);
    const auto output = find_in(configuration->outputs, name);
    const bool input_first = direction == SettingScope::input;
    const auto& first = input_first ? input : output;
    auto use = first ? first : input_first ? output : input;
    if (!use) {
        return Refused(fmt::format("--as {}: the configuration has no {}; {}", file_and_name,
                                   in_quotes(name), suggestion(name, names_in(*configuration))));
    }
    const auto mistakes = use->protocol->check == nullptr
                              ? std::vector<SettingMistake>{}
                              : use->protocol->check(use->settings, direction);
    if (!mistakes.empty()) {
        return Refused(fmt::format("--as {}: does not work in this direction: {}", file_and_name,
                                   mistakes.front().text));
    }
    if (const auto refusal = refusal_of_key(*use->protocol, use->settings); !refusal.empty()) {
        return Refused(fmt::format("--as {}: {}", file_and_name, refusal));
    }
    return std::move(*use);
}

}  // namespace tribus
