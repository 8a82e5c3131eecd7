#include "app/init/dialogue.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <istream>
#include <iterator>
#include <utility>

#include <fmt/format.h>

#include "app/init/configuration_text.h"
#include "config/keys/keys.h"
#include "core/quantity.h"
#include "core/quotes.h"
#include "transports/codecs/native_can/channels.h"
#include "transports/links/can/can_medium.h"

namespace tribus::init {
namespace {

constexpr double kCentredThrottleUs = 1500;

std::string trimmed(std::string_view text) {
    constexpr std::string_view kBlanks = " \t\r";
    const std::size_t begin = text.find_first_not_of(kBlanks);
    const std::size_t end = text.find_last_not_of(kBlanks);
    return begin == std::string_view::npos ? std::string()
                                           : std::string(text.substr(begin, end - begin + 1));
}

/// Index for a number from 1 to `most`.
std::optional<std::size_t> number_of(const std::string& text, std::size_t most) {
    std::size_t number = 0;
    const char* const end = text.data() + text.size();
    const auto read = std::from_chars(text.data(), end, number);
    const bool is_number = read.ec == std::errc{} && read.ptr == end;
    return is_number && number >= 1 && number <= most ? std::optional(number - 1) : std::nullopt;
}

/// Description of a port in the list.
std::string port_text(const ExaminedPlace& examined) {
    std::string text = examined.kind;
    if (examined.name != examined.node) {
        text += fmt::format("{}{}", text.empty() ? "" : "; ",
                            std::string_view(examined.name).substr(examined.name.rfind('/') + 1));
    }
    for (const doctor::Finding& finding : examined.findings) {
        if (finding.severity == doctor::Severity::problem) {
            text += fmt::format("{}{}", text.empty() ? "" : "; ", finding.what);
        }
    }
    return text;
}

bool is_taken(const ExaminedPlace& examined, const std::vector<Attachment>& taken) {
    return std::ranges::find(taken, examined.node, &Attachment::node) != taken.end();
}

}  // namespace

std::vector<Dialogue::Choice> Dialogue::choices_of(const std::vector<const Protocol*>& offered) {
    std::vector<Choice> choices;
    std::ranges::transform(offered, std::back_inserter(choices), [](const Protocol* protocol) {
        return Choice{std::string(protocol->name), std::string(protocol->description)};
    });
    return choices;
}

std::optional<std::string> Dialogue::answer() {
    messages_.prompt();
    std::string line;
    const bool answered = static_cast<bool>(std::getline(in_, line));
    if (echo_ || !answered) {
        messages_.say(line);
    }
    return answered ? std::optional(trimmed(line)) : std::nullopt;
}

void Dialogue::list(const std::vector<Choice>& choices) {
    for (std::size_t i = 0; i < choices.size(); ++i) {
        const Choice& choice = choices[i];
        messages_.say(
            choice.text.empty() ? choice.word : fmt::format("{}: {}", choice.word, choice.text),
            fmt::format("{:>3}  ", i + 1));
    }
}

std::optional<std::size_t> Dialogue::choose(std::string_view question,
                                            const std::vector<Choice>& choices,
                                            std::size_t proposed) {
    messages_.say(question);
    list(choices);
    return choose_listed(choices, proposed);
}

std::optional<std::size_t> Dialogue::choose_listed(const std::vector<Choice>& choices,
                                                   std::size_t proposed) {
    while (true) {
        messages_.say(fmt::format("A number; Enter takes {}.", proposed + 1));
        const auto text = answer();
        if (!text) {
            return std::nullopt;
        }
        const auto word = std::ranges::find(choices, *text, &Choice::word);
        const auto chosen = text->empty() ? std::optional(proposed)
                            : word != choices.end()
                                ? std::optional(static_cast<std::size_t>(word - choices.begin()))
                                : number_of(*text, choices.size());
        if (chosen) {
            return chosen;
        }
        messages_.say(fmt::format("{} is not one of them; allowed: 1 to {}.", in_quotes(*text),
                                  choices.size()));
    }
}

std::optional<std::string> Dialogue::place_of(const std::string& answer,
                                              const std::vector<ExaminedPlace>& all) {
    if (const auto index = number_of(answer, all.size())) {
        return all[*index].name;
    }
    const ExaminedPlace examined = ports_.look(answer);
    if (!examined.other_end.empty()) {
        messages_.say(fmt::format("{}: {}.", answer, examined.other_end));
        return std::nullopt;
    }
    if (examined.known) {
        return answer;
    }
    const std::string numbers = all.empty() ? "" : fmt::format("1 to {}, ", all.size());
    messages_.say(
        fmt::format("There is no serial device and no CAN interface {}; allowed: {}a path "
                    "such as /dev/ttyUSB0, a name such as can0.",
                    in_quotes(answer), numbers));
    return std::nullopt;
}

std::optional<std::string> Dialogue::choose_place(std::string_view question,
                                                  const std::vector<Attachment>& taken) {
    while (true) {
        const std::vector<ExaminedPlace> all = ports_.all();
        std::vector<Choice> choices;
        std::ranges::transform(all, std::back_inserter(choices), [](const ExaminedPlace& examined) {
            return Choice{examined.node, port_text(examined)};
        });
        const auto free = std::ranges::find_if(all, [&](const ExaminedPlace& examined) {
            return examined.usable() && !is_taken(examined, taken);
        });
        messages_.say(question);
        list(choices);
        messages_.say(
            all.empty() ? "No serial port and no CAN interface was found. Plug one in and "
                          "press Enter, or give a path."
            : free == all.end()
                ? std::string("A number or a path; Enter looks again.")
                : fmt::format("A number or a path; Enter takes {}.", free - all.begin() + 1));
        const auto text = answer();
        if (!text) {
            return std::nullopt;
        }
        if (text->empty() && free != all.end()) {
            return free->name;
        }
        if (!text->empty()) {
            if (auto place = place_of(*text, all)) {
                return place;
            }
        }
    }
}

const Protocol* Dialogue::choose_protocol(std::string_view question,
                                          const std::vector<const Protocol*>& offered,
                                          const Protocol& usual) {
    const std::vector<Choice> choices = choices_of(offered);
    const auto proposed = std::ranges::find(offered, &usual);
    const auto chosen = choose(
        question, choices,
        proposed == offered.end() ? 0 : static_cast<std::size_t>(proposed - offered.begin()));
    return chosen ? offered[*chosen] : nullptr;
}

/// The reason comes last: a small terminal shows the end.
Dialogue::Step Dialogue::ask_what_now(const ExaminedPlace& examined, Decision refused,
                                      Attachment& input) {
    std::vector<Choice> choices{{"again", "listen once more"}, {"other", "choose another port"}};
    const std::size_t ways = choices.size();
    const auto offered = offered_protocols(SettingScope::input, *examined.medium);
    std::ranges::copy(choices_of(offered), std::back_inserter(choices));
    std::vector<std::string> protocols;
    for (std::size_t i = ways; i < choices.size(); ++i) {
        protocols.push_back(fmt::format("{:>3}  {}", i + 1, choices[i].word));
    }
    while (true) {
        messages_.say("What now?");
        list({choices.begin(), choices.begin() + static_cast<std::ptrdiff_t>(ways)});
        messages_.say("Or name the protocol that will come there:");
        messages_.side_by_side(protocols);
        messages_.findings(refused.findings);
        messages_.say(fmt::format("{}: {}.", examined.node, refused.attachment.error()));
        const auto chosen = choose_listed(choices, 0);
        if (!chosen) {
            return Step::ended;
        }
        if (*chosen < ways) {
            return *chosen == 0 ? Step::again : Step::other_place;
        }
        refused = decide_input(examined, offered[*chosen - ways]);
        if (refused.attachment) {
            input = *std::move(refused.attachment);
            return Step::done;
        }
    }
}

Dialogue::Step Dialogue::try_input(const std::string& place, Attachment& input) {
    ExaminedPlace examined = ports_.look(place);
    const Protocol* named = nullptr;
    if (examined.medium != &kSerialMedium) {
        named = choose_protocol("Which protocol does it carry?",
                                offered_protocols(SettingScope::input, *examined.medium),
                                usual_protocol(examined.medium->shape));
        if (named == nullptr) {
            return Step::ended;
        }
    } else {
        examined = ports_.listen(place);
    }
    Decision decision = decide_input(examined, named);
    if (!decision.attachment) {
        return ask_what_now(examined, std::move(decision), input);
    }
    messages_.findings(decision.findings);
    input = *std::move(decision.attachment);
    for (const std::string& remark : input.remarks) {
        messages_.say(remark);
    }
    return Step::done;
}

std::optional<Attachment> Dialogue::ask_input() {
    Attachment input;
    Step step = Step::other_place;
    std::optional<std::string> place;
    while (step != Step::done) {
        if (step == Step::other_place) {
            place =
                choose_place("Which port is the receiver at, or whatever sends the signal?", {});
        }
        if (!place || step == Step::ended) {
            return std::nullopt;
        }
        step = try_input(*place, input);
    }
    return input;
}

std::optional<Attachment> Dialogue::ask_output(const std::vector<Attachment>& inputs) {
    while (true) {
        const auto place =
            choose_place("Which port are the servos at, or whatever reads the signal?", inputs);
        if (!place) {
            return std::nullopt;
        }
        ExaminedPlace examined = ports_.look(*place);
        auto offered = offered_protocols(SettingScope::output, *examined.medium);
        std::erase_if(offered, [&](const Protocol* protocol) {
            const std::string refusal = examined.refusal(*protocol);
            if (!refusal.empty()) {
                messages_.say(
                    fmt::format("{} is impossible at this port: {}.", protocol->name, refusal));
            }
            return !refusal.empty();
        });
        if (offered.empty()) {
            continue;
        }
        const Protocol* const protocol = choose_protocol("Which protocol does it read?", offered,
                                                         usual_protocol(examined.medium->shape));
        if (protocol == nullptr) {
            return std::nullopt;
        }
        const std::string trial = ports_.try_line(examined, protocol->line);
        Decision decision = decide_output(examined, protocol, trial);
        messages_.findings(decision.findings);
        const std::string conflict =
            decision.attachment ? port_conflict(inputs, *decision.attachment) : std::string();
        if (decision.attachment && conflict.empty()) {
            return *std::move(decision.attachment);
        }
        messages_.say(fmt::format("{}: {}.", examined.node,
                                  decision.attachment ? conflict : decision.attachment.error()));
    }
}

std::optional<double> Dialogue::ask_throttle() {
    messages_.say("Which pulse does channel 3, usually the throttle, get when the signal is lost?");
    list({{"988 us", "low, for aeroplanes and multicopters"},
          {"1500 us", "the centre, for motors that reverse: cars, boats, rovers"}});
    while (true) {
        messages_.say(
            fmt::format("A number, or another pulse from {:.0f} to {:.0f} us; Enter takes 1.",
                        kLeastPulse, kMostPulse));
        const auto text = answer();
        if (!text) {
            return std::nullopt;
        }
        if (const auto chosen =
                text->empty() ? std::optional<std::size_t>(0) : number_of(*text, 2)) {
            return *chosen == 0 ? kLowThrottleUs : kCentredThrottleUs;
        }
        const auto pulse = parse_quantity(*text);
        const bool unit = pulse && (pulse->unit.empty() || trimmed(pulse->unit) == "us");
        if (unit && pulse->number >= kLeastPulse && pulse->number <= kMostPulse) {
            return pulse->number;
        }
        messages_.say(fmt::format("{} is not allowed.", in_quotes(*text)));
    }
}

}  // namespace tribus::init
