#pragma once

#include <string>
#include <vector>

#include "app/doctor/finding.h"
#include "app/doctor/line_judge.h"

namespace tribus::doctor {

/// "i.Bus, 18 channels, 115200 baud 8N1": one sentence of what is on the line.
std::string describe(const LineStory& story);

/// What is wrong with it, for the port `node`. Pure.
std::vector<Finding> judge_story(const LineStory& story, const std::string& node);

/// The lines of a configuration that read this line, `device` as the port; none where nothing could
/// read it. An input needs a pipeline and an output beside it. Pure.
std::vector<std::string> configuration_lines(const LineStory& story, const std::string& device);

}  // namespace tribus::doctor
