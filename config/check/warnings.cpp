#include "config/check/warnings.h"

#include "config/check/absent_channels.h"

namespace tribus {

std::vector<Mistake> warnings_about(const Configuration& configuration) {
    Mistakes all(configuration.file);
    for (const Warning& warning : configuration.warnings) {
        all.add(warning.where, warning.text);
    }
    for (const Mistake& remark : maps_of_absent_channels(configuration)) {
        all.add(remark);
    }
    return all.sorted();
}

}  // namespace tribus
