#pragma once

#include <string>
#include <string_view>

#include <CLI/CLI.hpp>

namespace tribus {

/// Help that keeps to 80 columns. What has no blank is not broken.
class HelpFormatter : public CLI::Formatter {
  public:
    std::string make_help(const CLI::App* app, std::string name,
                          CLI::AppFormatMode mode) const override;
};

/// How help shows that an option has a few allowed words, `a, b, c`; completions read it.
std::string choices_type(std::string_view words);

}  // namespace tribus
