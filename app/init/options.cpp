#include "app/init/options.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "config/schema/notation.h"
#include "core/quantity.h"
#include "core/quotes.h"
#include "transports/links/serial/serial_medium.h"

namespace tribus::init {
namespace {

constexpr Duration kShortestListening = std::chrono::seconds(1);
constexpr Duration kLongestListening = std::chrono::seconds(60);

OrFailure<std::vector<PlaceOption>> read_places(const std::vector<std::string>& texts,
                                                SettingScope way) {
    std::vector<PlaceOption> places;
    for (const std::string& text : texts) {
        auto option = parse_place_option(text, way);
        if (!option) {
            return failed(fmt::format("{} {}: {}", option_of(way), in_quotes(text), option.error()),
                          kExitWrongUse);
        }
        places.push_back(*std::move(option));
    }
    return places;
}

std::vector<std::string_view> names_of_inputs() {
    std::vector<std::string_view> names;
    std::ranges::transform(offered_protocols(SettingScope::input, kSerialMedium),
                           std::back_inserter(names), &Protocol::name);
    return names;
}

}  // namespace

OrFailure<Request> read_options(const Options& options) {
    Request request;
    const auto listening = options.listening == "0" ? std::optional(Duration::zero())
                                                    : parse_duration(options.listening);
    const bool none = listening == Duration::zero();
    if (!listening ||
        (!none && (*listening < kShortestListening || *listening > kLongestListening))) {
        return failed(fmt::format("--listen {}: must be a time from {} to {}, such as 3s, or 0 to "
                                  "open no port",
                                  in_quotes(options.listening), format_duration(kShortestListening),
                                  format_duration(kLongestListening)),
                      kExitWrongUse);
    }
    request.listening = *listening;
    auto inputs = read_places(options.in, SettingScope::input);
    auto outputs = read_places(options.out, SettingScope::output);
    if (!inputs || !outputs) {
        return tl::unexpected(!inputs ? inputs.error() : outputs.error());
    }
    request.inputs = *std::move(inputs);
    request.outputs = *std::move(outputs);
    for (const PlaceOption& input : request.inputs) {
        const bool serial =
            input.place.find('/') != std::string::npos && !input.place.starts_with("/dev/input/");
        if (none && serial && input.protocol == nullptr) {
            return failed(fmt::format("--in {}: with --listen 0 the protocol must be named, --in "
                                      "PLACE=PROTOCOL; allowed: {}",
                                      input.place, fmt::join(names_of_inputs(), ", ")),
                          kExitWrongUse);
        }
    }
    return request;
}

}  // namespace tribus::init
