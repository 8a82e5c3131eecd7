#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "app/doctor/facts/finding.h"
#include "app/doctor/listening/line_judge.h"

namespace tribus::doctor {

/// One sentence about the line: "i.Bus, 18 channels, 115200 baud 8N1".
std::string describe(const LineStory& story);

/// Findings about the line at the port `node`. Pure.
std::vector<Finding> judge_story(const LineStory& story, const std::string& node);

/// A key of an input, with its value as written in a configuration.
struct HeardKey {
    std::string_view key;
    std::string value;
};

/// Further keys of an input that reads this line: those whose defaults do not fit it. Pure.
std::vector<HeardKey> heard_keys(const LineStory& story);

/// Configuration lines that read this line at the port `device`; none if nothing can read it. An
/// input also needs a pipeline and an output. Pure.
std::vector<std::string> configuration_lines(const LineStory& story, const std::string& device);

}  // namespace tribus::doctor
