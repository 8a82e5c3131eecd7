#include "config/read/recorder.h"

namespace tribus {

std::optional<RecorderConfig> read_recorder(const Entry* entry, Reading reading) {
    const auto content = read_only_table("recorder", entry, recorder_keys(), reading);
    if (!content) {
        return std::nullopt;
    }
    RecorderConfig recorder;
    recorder.where = entry->value.where;
    content->read_into(recorder);
    if (content->given("directory") && !recorder.directory.starts_with('/')) {
        reading.mistakes.add(content->where("directory"),
                             "\"directory\" must not depend on where the program is started; "
                             "allowed: a path that begins with /");
    }
    return recorder;
}

}  // namespace tribus
