#include <array>
#include <string>
#include <string_view>
#include <vector>

#include "config/build/build.h"
#include "config/language/read_document.h"
#include "config/load.h"
#include "config/show/effective.h"
#include "tests/fuzz/fuzz.h"

namespace tribus::fuzz::configuration_target {
namespace {

/// The folder of the DBC files that examples name.
constexpr const char* kFile = TRIBUS_SOURCE_DIR "/config/examples/fuzz.toml";

/// Replaces a missing run by the timeout, as `check` prints it.
std::vector<tribus::InputConfig> with_runs(std::vector<tribus::InputConfig> inputs) {
    for (tribus::InputConfig& input : inputs) {
        auto& supervision = input.supervision;
        supervision.frame_lost_run = supervision.frame_lost_run.value_or(supervision.timeout);
    }
    return inputs;
}

bool means_the_same(const tribus::Configuration& a, const tribus::Configuration& b) {
    return a.runtime == b.runtime && a.recorder == b.recorder &&
           with_runs(a.inputs) == with_runs(b.inputs) && a.outputs == b.outputs &&
           a.pipelines == b.pipelines && a.lines == b.lines && a.sensor_buses == b.sensor_buses &&
           a.values == b.values && a.dronecan == b.dronecan;
}

/// Random input makes nothing deep. So the byte 1, which no text contains, stands with the two
/// bytes after it for one of these repeated up to 25,500 times.
std::string with_depth(std::string_view text) {
    constexpr std::array<std::string_view, 12> kDeeper{
        "a.",  "\"a\".", "a . ",     "[",       "{ a = ",    "[[",
        "]\n", "}",      "{ a.a = ", "[{ a = ", "\n[a.b.c.", "a.b.c = [{ x.y = "};
    constexpr std::size_t kSteps = 100;
    constexpr std::size_t kLongest = 2 * tribus::kMostConfigurationBytes;
    std::string deep;
    for (std::size_t at = 0; at < text.size(); ++at) {
        if (text[at] != '\1' || at + 2 >= text.size()) {
            deep += text[at];
            continue;
        }
        const auto& more = kDeeper[static_cast<unsigned char>(text[at + 1]) % kDeeper.size()];
        const auto times = static_cast<unsigned char>(text[at + 2]) * kSteps;
        for (std::size_t i = 0; i < times && deep.size() < kLongest; ++i) {
            deep += more;
        }
        at += 2;
    }
    return deep;
}

}  // namespace

/// A configuration is refused with mistakes that each have a text, or an engine can be built from
/// it, and what `check` prints of it means the same.
FUZZ_TARGET(configuration) {
    const std::string text = with_depth(Input({data, size}).rest_as_text());
    const auto configuration = load_configuration(text, kFile);
    if (!configuration) {
        require(!configuration.error().empty(), "what is refused has a mistake");
        for (const Mistake& mistake : configuration.error()) {
            require(format_mistake(mistake).starts_with(kFile), "a mistake names its file");
            require(!mistake.text.empty(), "a mistake says what is wrong");
        }
        return 0;
    }
    const auto engine = build_engine(*configuration);
    const auto values = build_value_engine(*configuration, *engine);
    engine->start(Instant{});
    engine->poll(Instant{});
    const std::string effective = effective_toml(*configuration);
    const auto again = load_configuration(effective, kFile);
    require(again.has_value(), "what check prints is a valid configuration");
    require(means_the_same(*again, *configuration), "what check prints means the same");
    require(effective_toml(*again) == effective, "what check prints is printed again");
    return 0;
}

}  // namespace tribus::fuzz::configuration_target
