#pragma once

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>
#include <string_view>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace tribus::test {

inline std::filesystem::path config_folder() {
    return std::filesystem::path(TRIBUS_SOURCE_DIR) / "config";
}

/// The example configurations, by name.
inline std::vector<std::filesystem::path> example_files() {
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(config_folder() / "examples")) {
        if (entry.path().extension() == ".toml") {
            files.push_back(entry.path());
        }
    }
    std::sort(files.begin(), files.end());
    return files;
}

inline std::string content_of(const std::filesystem::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

/// The examples, and beside them the key files that they name, all with the same key, as if the
/// folder were that of the keys.
class ExamplesWithKeys {
  public:
    explicit ExamplesWithKeys(const std::string& key = std::string(64, '7')) {
        namespace fs = std::filesystem;
        for (const auto& entry : fs::directory_iterator(config_folder() / "examples")) {
            const std::string name = entry.path().filename().string();
            const std::string text = content_of(entry.path());
            folder_.write(name, std::regex_replace(text, std::regex(kKeys), folder_ / ""));
            for (std::sregex_iterator line(text.begin(), text.end(), kKeyLine), none; line != none;
                 ++line) {
                const std::string file = folder_.write((*line)[1], key);
                fs::permissions(file, fs::perms::owner_read | fs::perms::owner_write);
            }
        }
    }
    std::filesystem::path operator/(const std::string& name) const { return folder_ / name; }
    /// The configurations, by name.
    std::vector<std::filesystem::path> files() const {
        std::vector<std::filesystem::path> files;
        for (const auto& file : example_files()) {
            files.push_back(*this / file.filename().string());
        }
        return files;
    }

  private:
    inline static const std::string kKeys = "/etc/tribus/keys/";
    inline static const std::regex kKeyLine{"\nkey +=  *\"" + kKeys + "([^\"]+)\""};
    TemporaryFolder folder_;
};

}  // namespace tribus::test
