#include <iostream>

#include "tests/captures/recordings.h"

/// Says in one line which recordings the tests could not read. Says nothing if they read all.
int main() {
    const auto missing = tribus::test::missing_recordings();
    if (missing.empty()) {
        return 0;
    }
    std::cout << "Recordings that were not read, only their twins:";
    for (const char* separator = " "; const std::string& file : missing) {
        std::cout << separator << file;
        separator = ", ";
    }
    std::cout << "\n";
}
