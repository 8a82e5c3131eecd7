#include "transports/codecs/pwm/pwm.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <string>
#include <string_view>

#include "core/pwm_pulses.h"
#include "transports/codecs/setting_tables.h"

namespace tribus {
namespace {

constexpr std::int64_t kMostChipOutput = 63;

constexpr std::array kPwmSettings{
    Setting{.key = "outputs",
            .type = SettingType::tree,
            .required = true,
            .scope = SettingScope::output,
            .help = "The output of the chip for each channel, counted from 0: `{ 1 = 0, 2 = 1 }`; "
                    "`tribus pwm` shows how many there are",
            .example = "{ 1 = 0, 2 = 1 }"},
    Setting{.key = "calibration",
            .type = SettingType::number,
            .fallback = "1",
            .least = 0.9,
            .most = 1.1,
            .scope = SettingScope::output,
            .help = "How much faster than it should the oscillator of the chip is: the pulse that "
                    "was asked for, divided by the one that was measured. That of a PCA9685 is off "
                    "by up to 8 %",
            .example = "1.031"},
};

/// The channel of an entry, or nothing.
std::optional<std::size_t> pwm_channel(std::string_view key) {
    const std::string text(key);
    const std::size_t number = std::strtoul(text.c_str(), nullptr, 10);
    const bool fits = number >= 1 && number <= kChannelCount && std::to_string(number) == text;
    return fits ? std::optional(number - 1) : std::nullopt;
}

std::optional<std::uint8_t> pwm_output(const SettingTree& tree) {
    const auto* number = tree.as<std::int64_t>();
    const bool fits = number != nullptr && *number >= 0 && *number <= kMostChipOutput;
    return fits ? std::optional(static_cast<std::uint8_t>(*number)) : std::nullopt;
}

/// Empty without the key, which is a mistake then.
SettingTree::Table pwm_table(const SettingValues& settings) {
    const auto* table = table_of(settings, "outputs");
    return table == nullptr ? SettingTree::Table{} : *table;
}

std::vector<SettingMistake> check_pwm(const SettingValues& settings, SettingScope /*scope*/) {
    std::vector<SettingMistake> mistakes;
    std::vector<std::uint8_t> taken;
    for (const SettingEntry& entry : pwm_table(settings)) {
        const std::vector<std::string> path{"outputs", entry.key};
        const auto output = pwm_output(entry.value);
        if (!pwm_channel(entry.key)) {
            mistakes.push_back({path, "unknown; allowed: channels 1 to 18"});
        } else if (!output) {
            mistakes.push_back({path, "allowed: an output of the chip, 0 to 63"});
        } else if (std::ranges::count(taken, *output) != 0) {
            mistakes.push_back({path, "output " + std::to_string(*output) +
                                          " has a channel already; allowed: each output once"});
        } else {
            taken.push_back(*output);
        }
    }
    if (pwm_table(settings).empty()) {
        mistakes.push_back({{"outputs"}, "allowed: at least one channel, such as { 1 = 0 }"});
    }
    return mistakes;
}

AnyEncoder make_pwm_encoder(const SettingValues& settings) {
    return std::make_unique<PwmEncoder>(pwm_outputs(settings), settings.get_or("calibration", 1.0));
}

}  // namespace

std::vector<PwmOutput> pwm_outputs(const SettingValues& settings) {
    std::vector<PwmOutput> outputs;
    for (const SettingEntry& entry : pwm_table(settings)) {
        const auto channel = pwm_channel(entry.key);
        const auto output = pwm_output(entry.value);
        if (channel && output) {
            outputs.push_back({*channel, *output});
        }
    }
    return outputs;
}

static_assert(kChannelCount * pwm_pulses::kRecordBytes <= kLongestSerialFrame);

// Analogue servos take a pulse each 20 ms, many digital ones more.
const Protocol kPwmProtocol{
    .name = "pwm",
    .title = "PWM",
    .description = "Servo pulses of the board's own PWM or of a chip such as the PCA9685",
    .only_on = "a PWM chip",
    .settings = kPwmSettings,
    .longest_frame = kChannelCount * pwm_pulses::kRecordBytes,
    .default_period = std::chrono::milliseconds(20),
    .least_period = std::chrono::milliseconds(10),
    .signals_failsafe = never_signals_failsafe,
    .check = check_pwm,
    .make_encoder = make_pwm_encoder,
};

}  // namespace tribus
