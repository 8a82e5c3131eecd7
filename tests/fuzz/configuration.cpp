#include <string>

#include "config/build.h"
#include "config/effective.h"
#include "config/load.h"
#include "tests/fuzz/fuzz.h"

/// A configuration is refused with mistakes that each have a text, or an engine can be built of it,
/// and what `check` prints of it means the same.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace tribus;
    using fuzz::require;
    const std::string_view text = fuzz::Input({data, size}).rest_as_text();
    const auto configuration = load_configuration(text, "fuzz.toml");
    if (!configuration) {
        require(!configuration.error().empty(), "what is refused has a mistake");
        for (const Mistake& mistake : configuration.error()) {
            require(format_mistake(mistake).starts_with("fuzz.toml"), "a mistake names its file");
            require(!mistake.text.empty(), "a mistake says what is wrong");
        }
        return 0;
    }
    const auto engine = build_engine(*configuration);
    const auto values = build_value_engine(*configuration, *engine);
    engine->start(Instant{});
    engine->poll(Instant{});
    const std::string effective = effective_toml(*configuration);
    const auto again = load_configuration(effective, "fuzz.toml");
    require(again.has_value(), "what check prints is a valid configuration");
    require(effective_toml(*again) == effective, "what check prints means the same");
    return 0;
}
