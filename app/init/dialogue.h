#pragma once

#include <cstddef>
#include <cstdint>
#include <iosfwd>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "app/init/attachment.h"
#include "app/init/messages.h"
#include "app/init/ports.h"

namespace tribus::init {

/// Asks for what the command line leaves open. An answer is a line of `in`. An empty line takes the
/// default; after a wrong answer the question is repeated. Each question returns nothing if `in`
/// ends. Thread-bound.
class Dialogue {
  public:
    /// `echo`: print each answer, because no terminal shows it.
    Dialogue(std::istream& in, bool echo, Messages& messages, Ports& ports)
        : in_(in), echo_(echo), messages_(messages), ports_(ports) {}

    std::optional<Attachment> ask_input();
    /// The ports of `inputs` are not the default.
    std::optional<Attachment> ask_output(const std::vector<Attachment>& inputs);
    /// The pulse of channel 3 in failsafe, microseconds.
    std::optional<double> ask_throttle();

  private:
    /// One of several answers, chosen by its number or its word.
    struct Choice {
        std::string word;
        std::string text;
    };
    enum class Step : std::uint8_t { done, again, other_place, ended };

    static std::vector<Choice> choices_of(const std::vector<const Protocol*>& offered);
    std::optional<std::string> answer();
    void list(const std::vector<Choice>& choices);
    /// Returns the index of the choice; `proposed` for an empty answer.
    std::optional<std::size_t> choose(std::string_view question, const std::vector<Choice>& choices,
                                      std::size_t proposed);
    /// The same, after question and choices were printed.
    std::optional<std::size_t> choose_listed(const std::vector<Choice>& choices,
                                             std::size_t proposed);
    /// Returns a device or an interface, chosen by its number in a list or by its name. Places of
    /// `taken` are not the default.
    std::optional<std::string> choose_place(std::string_view question,
                                            const std::vector<Attachment>& taken);
    /// The place that an answer names. If there is none, prints what is allowed.
    std::optional<std::string> place_of(const std::string& answer,
                                        const std::vector<ExaminedPlace>& all);
    /// Null if `in` ends.
    const Protocol* choose_protocol(std::string_view question,
                                    const std::vector<const Protocol*>& offered,
                                    const Protocol& usual);
    /// Looks at a place and listens to it. Sets `input` if the step is `done`.
    Step try_input(const std::string& place, Attachment& input);
    /// Asks what to do about an input that was refused. Sets `input` if the step is `done`.
    Step ask_what_now(const ExaminedPlace& examined, Decision refused, Attachment& input);

    std::istream& in_;
    bool echo_;
    Messages& messages_;
    Ports& ports_;
};

}  // namespace tribus::init
