#pragma once

#include <filesystem>
#include <string>

#include <tl/expected.hpp>

/// The folder of configurations, which the page may write while a browser may change them. Only
/// root gives and takes that, and only where the package is installed; elsewhere nothing happens.
/// Errors are sentences.
namespace tribus::web {

struct PageFolder {
    std::filesystem::path configurations;
    std::filesystem::path state;  ///< folder of the page, which has its group

    /// The folder gets the page's group, which may write there. What it had before is kept beside
    /// `state`, in a place of root's.
    tl::expected<void, std::string> give() const;
    /// The folder gets back the group and the rights of its group that it had.
    tl::expected<void, std::string> take_back() const;

  private:
    std::filesystem::path kept_in() const { return state.string() + ".before"; }
};

}  // namespace tribus::web
