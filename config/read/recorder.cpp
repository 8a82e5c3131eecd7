#include "config/read/recorder.h"

#include <cstdint>
#include <string>

namespace tribus {

std::optional<RecorderConfig> read_recorder(const Entry* entry, Reading reading) {
    const auto content = read_only_table("recorder", entry, recorder_keys(), reading);
    if (!content) {
        return std::nullopt;
    }
    const SettingValues& values = content->values();
    const auto number = [&](std::string_view key) {
        return static_cast<int>(values.get_or<std::int64_t>(key, 1));
    };
    RecorderConfig recorder;
    recorder.directory = values.get_or("directory", std::string());
    recorder.where = entry->value.where;
    recorder.memory_kib = number("memory");
    recorder.before = values.get_or("before", Duration::zero());
    recorder.after = values.get_or("after", Duration::zero());
    recorder.on_failsafe = values.get_or("on_failsafe", true);
    recorder.pause = values.get_or("pause", Duration::zero());
    recorder.keep = number("keep");
    recorder.space_mib = number("space");
    if (content->given("directory") && !recorder.directory.starts_with('/')) {
        reading.mistakes.add(content->where("directory"),
                             "\"directory\" must not depend on where the program is started; "
                             "allowed: a path that begins with /");
    }
    return recorder;
}

}  // namespace tribus
