#pragma once

#include <string>
#include <vector>

namespace tribus {

/// Sentences for the user from threads that may not log, such as those of links. Thread-safe; not
/// for the data thread, which never waits for another one.
void add_thread_notice(std::string text);
/// Those since the last call.
std::vector<std::string> take_thread_notices();

}  // namespace tribus
