#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <tl/expected.hpp>

#include "app/cli/exit_status.h"
#include "app/init/attachment.h"
#include "core/setting.h"
#include "core/time.h"

namespace tribus::init {

/// The options of `tribus init`, as typed.
struct Options {
    std::string file = "tribus.toml";
    std::vector<std::string> in;
    std::vector<std::string> out;
    std::string listening = "3s";
    std::optional<double> throttle;
    bool force = false;
};

/// The options, parsed.
struct Request {
    std::vector<PlaceOption> inputs;
    std::vector<PlaceOption> outputs;
    Duration listening{};  ///< zero: open no port
};

/// Why `init` ends without a configuration.
struct Failure {
    std::string text;  ///< for the user
    int status = kExitFailed;
};
template <class Result>
using OrFailure = tl::expected<Result, Failure>;

inline tl::unexpected<Failure> failed(std::string text, int status = kExitFailed) {
    return tl::unexpected(Failure{std::move(text), status});
}

/// Option for an input or an output.
inline std::string_view option_of(SettingScope way) {
    return way == SettingScope::input ? "--in" : "--out";
}

/// Parses the options. Every failure is wrong use. Pure.
OrFailure<Request> read_options(const Options& options);

}  // namespace tribus::init
